// ROS 2 bags: what a bag may hold, and databases that only look like one.
#include <gmock/gmock.h>

#include "fricid/data/contract.hpp"
#include "log_samples.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

using testing::HasSubstr;

class RosBag : public FolderTest {
 protected:
  Dataset import(Database& bag, const std::string& more = "") const {
    const auto contract =
        load_contract(write("contract.toml", more + db3_sample(Recording(2)).contract));
    return import_log(write("log.db3", bag.bytes()), contract);
  }
  std::string error(Database& bag, const std::string& more = "") const {
    return message_of([&] { import(bag, more); });
  }
};

// Reference: the same messages in an MCAP file, to the last bit.
TEST_F(RosBag, GivesWhatAnMcapOfTheSameMessagesGives) {
  const Recording r(300);
  Database bag;
  write_bag(bag, r);
  const LogSample mcap = mcap_sample(r);
  const Dataset expected = import_log(write("log.mcap", mcap.files[0].second),
                                      load_contract(write("mcap.toml", mcap.contract)));
  const Dataset d = import(bag);
  EXPECT_EQ(d.length(), 300);
  EXPECT_EQ(d.t, expected.t);
  EXPECT_EQ(d.q, expected.q);
  EXPECT_EQ(d.v, expected.v);
  EXPECT_EQ(d.tau, expected.tau);
  EXPECT_EQ(d.joint_names, expected.joint_names);
}

TEST_F(RosBag, OfTwoTopicsOneIsNamed) {
  Database bag;
  write_bag(bag, Recording(20));
  bag.run("INSERT INTO topics VALUES (3, '/fake', 'sensor_msgs/msg/JointState', 'cdr', '')");
  EXPECT_EQ(error(bag),
            "log.db3: joint states on /joint_states and /fake; allowed: one, or topic = \"...\"");
  EXPECT_EQ(import(bag, "topic = \"/joint_states\"\n").length(), 20);
  EXPECT_EQ(error(bag, "topic = \"/fake\"\n"), "log.db3: found no joint states on /fake");
  EXPECT_EQ(error(bag, "topic = \"/image\"\n"), "log.db3: found no joint states on /image");
}

// joint_state_broadcaster and a gripper on one topic, at the same times or between them.
TEST_F(RosBag, MessagesOfOtherJointsArePassedOver) {
  const Recording r(50);
  Database alone;
  write_bag(alone, r);
  const Dataset expected = import(alone);
  for (const long long late : {0LL, 2'000'000LL}) {
    std::vector<JointStateSample> messages;
    for (int k = 0; k < r.length(); ++k) {
      messages.push_back({nanosec_of(k) - late, {"finger"}, {0.01}, {0.0}, {}});
      messages.push_back(joint_state(r, k));
    }
    Database bag;
    write_bag(bag, messages);
    const Dataset d = import(bag);
    EXPECT_EQ(d.t, expected.t) << late;
    EXPECT_EQ(d.q, expected.q) << late;
    EXPECT_EQ(d.tau, expected.tau) << late;
  }
}

TEST_F(RosBag, ColumnsAreThoseOfAllMessages) {
  const Recording r(50);
  std::vector<JointStateSample> messages;
  for (int k = 0; k < r.length(); ++k) messages.push_back(joint_state(r, k));
  messages[0].tau.clear();
  messages[7].tau.clear();
  Database bag;
  write_bag(bag, messages);
  const Dataset d = import(bag);
  ASSERT_EQ(d.length(), 50);
  for (int k = 0; k < d.length(); ++k) {
    EXPECT_EQ(d.q(k, 0), r.q(k, 0));
    EXPECT_EQ(std::isnan(d.tau(k, 0)), k == 0 || k == 7) << k;
  }
}

// The other half may come a sample late; a message that comes twice stays two rows.
TEST_F(RosBag, AnArmInTwoMessagesOfOneStampIsOneRow) {
  const Recording r(50);
  const auto half = [&](int k, int j, long long late) {
    return JointStateSample{nanosec_of(k) + late,
                            {j == 0 ? "shoulder" : "elbow"},
                            {r.q(k, j)},
                            {r.v(k, j)},
                            {r.tau(k, j)}};
  };
  for (const int behind : {0, 1}) {
    std::vector<JointStateSample> messages;
    for (int k = 0; k < r.length() + behind; ++k) {
      if (k < r.length()) messages.push_back(half(k, 0, 0));
      if (k >= behind) messages.push_back(half(k - behind, 1, 0));
    }
    Database bag;
    write_bag(bag, messages);
    const Dataset d = import(bag);
    EXPECT_EQ(d.q, r.q) << behind;
    EXPECT_EQ(d.v, r.v) << behind;
    EXPECT_EQ(d.tau, r.tau) << behind;
  }
  std::vector<JointStateSample> apart, twice;
  for (int k = 0; k < r.length(); ++k) {
    apart.push_back(half(k, 0, 0));
    apart.push_back(half(k, 1, 1'000'000));
    twice.push_back(joint_state(r, k));
    if (k == 20) twice.push_back(twice.back());
  }
  Database one, two;
  write_bag(one, apart);
  EXPECT_EQ(error(one),
            "log.db3: shoulder and elbow come in messages of different stamps; allowed: the joints "
            "of the contract in one message, or in messages of one stamp");
  write_bag(two, twice);
  EXPECT_THAT(error(two), HasSubstr("log.db3: sample 21: t = 0.08 s after 0.08 s"));
}

TEST_F(RosBag, OtherEncodingsAreNamed) {
  Database bag;
  write_bag(bag, Recording(20));
  bag.run("UPDATE messages SET data = x'28b52ffd00' WHERE id = 8");
  EXPECT_EQ(error(bag), "log.db3: message encoding 28b5; allowed: little-endian CDR");
  bag.run("UPDATE topics SET serialization_format = 'flat' WHERE id = 2");
  EXPECT_EQ(error(bag), "log.db3: /joint_states is encoded as \"flat\"; allowed: cdr");
}

TEST_F(RosBag, ARecorderThatDidNotCloseItLeavesTheRestBesideIt) {
  Database bag;
  write_bag(bag, Recording(20));
  for (const std::string journal : {"log.db3-wal", "log.db3-journal"}) {
    write(journal, "rest");
    EXPECT_EQ(error(bag),
              journal +
                  ": not all of the bag is in log.db3; allowed: a bag that its recorder "
                  "has closed; `sqlite3 log.db3 'PRAGMA journal_mode = DELETE'` closes it");
    write(journal, "");
    EXPECT_EQ(import(bag).length(), 20);
    std::filesystem::remove(path(journal));
  }
}

// Bags that were recorded with a write-ahead log say so in their header for ever.
TEST_F(RosBag, ABagOnceWrittenAheadIsRead) {
  Database bag;
  write_bag(bag, Recording(20));
  const LogSample sample = db3_sample(Recording(20));
  std::string bytes = bag.bytes();
  bytes[18] = bytes[19] = 2;
  const Dataset d =
      import_log(write("log.db3", bytes), load_contract(write("contract.toml", sample.contract)));
  EXPECT_EQ(d.length(), 20);
  EXPECT_FALSE(std::filesystem::exists(path("log.db3-wal")));
  EXPECT_FALSE(std::filesystem::exists(path("log.db3-shm")));
}

// Only stored rows of two plain tables are read: nothing that the file would have computed.
TEST_F(RosBag, DatabasesThatOnlyLookLikeABag) {
  const Recording r(5);
  const std::string topics =
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format "
      "TEXT)";
  {
    Database empty;
    empty.run("CREATE TABLE other(x)");
    EXPECT_EQ(error(empty), "log.db3: no ROS 2 bag: it has no table topics");
  }
  {
    Database view;
    write_bag(view, r);
    view.run("ALTER TABLE messages RENAME TO hidden")
        .run("CREATE VIEW messages AS SELECT * FROM hidden");
    EXPECT_EQ(error(view), "log.db3: no ROS 2 bag: it has no table messages");
  }
  {
    Database table;
    table.run(topics).run("CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)");
    EXPECT_EQ(error(table), "log.db3: no ROS 2 bag: it has no table messages");
  }
  {
    Database computed;
    computed.run(topics).run(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER,"
        " data BLOB AS (zeroblob(1000000000)))");
    EXPECT_EQ(error(computed), "log.db3: no ROS 2 bag: the table messages has computed columns");
  }
  {
    Database columns;
    columns.run(topics).run("CREATE TABLE messages(id INTEGER PRIMARY KEY, content BLOB)");
    EXPECT_EQ(error(columns), "log.db3: no ROS 2 bag, or damaged: no such column: data");
  }
  {
    Database rows;
    rows.run(topics).run(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, data BLOB) WITHOUT ROWID");
    EXPECT_THAT(error(rows), HasSubstr("log.db3: "));
  }
  {
    Database large;
    write_bag(large, r);
    large.run("UPDATE messages SET data = zeroblob(16777217) WHERE id = 4");
    EXPECT_EQ(error(large),
              "log.db3: a message is larger than the 16777216 bytes that are allowed");
  }
}

// Triggers of a file act on writing alone; there is none.
TEST_F(RosBag, ReadingChangesNothing) {
  Database bag;
  write_bag(bag, Recording(20));
  bag.run("CREATE TRIGGER t AFTER INSERT ON messages BEGIN DELETE FROM messages; END");
  const std::string bytes = bag.bytes();
  EXPECT_EQ(import(bag).length(), 20);
  EXPECT_EQ(read("log.db3"), bytes);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder),
                          std::filesystem::directory_iterator{}),
            4);  // arm.urdf, arm.xml, contract.toml, log.db3
}

// Damage within the file: a table, or one line.
TEST_F(RosBag, SurvivesBytesThatAreWrong) {
  Database bag;
  write_bag(bag, Recording(6));
  const std::string whole = bag.bytes();
  const auto contract = load_contract(write("contract.toml", db3_sample(Recording(2)).contract));
  int refused = 0;
  for (std::size_t at = 16; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(~bytes[at]);
    const auto log = write("log.db3", bytes);
    const std::string said = message_of([&] { import_log(log, contract); });
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    refused += said != "no error";
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace fricid::data
