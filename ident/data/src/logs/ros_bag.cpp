#include "ros_bag.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

#include "columns.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "joint_state.hpp"

namespace fricid::data {
namespace {

namespace fs = std::filesystem;

/// One query, row by row. Texts and blobs live until the next row.
class Query {
 public:
  Query(sqlite3* bag, const std::string& file, const char* sql) : bag_(bag), file_(file) {
    if (sqlite3_prepare_v2(bag, sql, -1, &query_, nullptr) != SQLITE_OK) refuse();
  }
  ~Query() { sqlite3_finalize(query_); }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  void bind(const std::string& text) {
    sqlite3_bind_text64(query_, 1, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  }
  void bind(std::int64_t number) { sqlite3_bind_int64(query_, 1, number); }
  bool next() {
    const int state = sqlite3_step(query_);
    if (state != SQLITE_ROW && state != SQLITE_DONE) refuse();
    return state == SQLITE_ROW;
  }
  std::int64_t number(int column) const { return sqlite3_column_int64(query_, column); }
  std::string_view bytes(int column) const {
    const void* data = sqlite3_column_blob(query_, column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(query_, column));
    return data ? std::string_view(static_cast<const char*>(data), size) : std::string_view();
  }
  std::string text(int column) const { return as_utf8(bytes(column)); }

 private:
  [[noreturn]] void refuse() const {
    if (sqlite3_errcode(bag_) == SQLITE_TOOBIG)
      throw UserError("{}: a message is larger than the {} bytes that are allowed", file_,
                      limits::kBagMessageBytes.most);
    if (sqlite3_errcode(bag_) == SQLITE_INTERRUPT)
      throw UserError("{}: damaged: more rows than its bytes can hold", file_);
    throw UserError("{}: no ROS 2 bag, or damaged: {}", file_, sqlite3_errmsg(bag_));
  }

  sqlite3* bag_;
  const std::string& file_;
  sqlite3_stmt* query_ = nullptr;
};

// "file:" URI of a path: what has a meaning there is escaped.
std::string uri_of(const fs::path& path) {
  std::string uri = "file:";
  for (const char c : fs::absolute(path).string()) {
    const bool plain =
        std::isalnum(static_cast<unsigned char>(c)) || c == '/' || c == '.' || c == '_' || c == '-';
    uri += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri + "?mode=ro&immutable=1";
}

/// A bag opened for reading.
class Bag {
 public:
  explicit Bag(const fs::path& path) : file_(path.string()) {
    refuse_journals(path);
    sqlite3* opened = nullptr;
    const int state = sqlite3_open_v2(uri_of(path).c_str(), &opened,
                                      SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    bag_.reset(opened);
    if (state != SQLITE_OK)
      throw UserError("{}: cannot be read: {}", file_,
                      opened ? sqlite3_errmsg(opened) : "no memory");
    distrust(path);
    require_tables();
  }

  /// Hands over the joint states of one topic.
  void walk(const std::string& topic, const std::function<void(const JointState&)>& visit) const {
    Query messages = query("SELECT data FROM messages WHERE topic_id = ? ORDER BY rowid");
    messages.bind(topic_id(topic));
    bool any = false;
    while (messages.next()) {
      any = true;
      visit(parse_joint_state(messages.bytes(0), file_));
    }
    if (!any) throw no_joint_states(file_, topic);
  }

 private:
  Query query(const char* sql) const { return {bag_.get(), file_, sql}; }

  // A recorder that did not end well leaves messages, or what undoes half a write, beside the bag.
  static void refuse_journals(const fs::path& path) {
    for (const char* ending : {"-wal", "-journal"}) {
      const fs::path journal = path.string() + ending;
      std::error_code none;
      if (const auto size = fs::file_size(journal, none); !none && size > 0)
        throw UserError(
            "{}: not all of the bag is in {}; allowed: a bag that its recorder has closed; "
            "`sqlite3 "
            "{} 'PRAGMA journal_mode = DELETE'` closes it",
            journal.string(), path.filename().string(), path.filename().string());
    }
  }

  // Nothing of the file's schema is run, and no row makes more work than its bytes can ask for.
  void distrust(const fs::path& path) {
    for (const auto& [setting, value] :
         {std::pair(SQLITE_DBCONFIG_DEFENSIVE, 1), std::pair(SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0),
          std::pair(SQLITE_DBCONFIG_ENABLE_TRIGGER, 0), std::pair(SQLITE_DBCONFIG_ENABLE_VIEW, 0)})
      sqlite3_db_config(bag_.get(), setting, value, nullptr);
    sqlite3_limit(bag_.get(), SQLITE_LIMIT_LENGTH, static_cast<int>(limits::kBagMessageBytes.most));
    sqlite3_limit(bag_.get(), SQLITE_LIMIT_SQL_LENGTH, 100'000);
    sqlite3_limit(bag_.get(), SQLITE_LIMIT_COLUMN, 100);
    sqlite3_limit(bag_.get(), SQLITE_LIMIT_EXPR_DEPTH, 100);
    sqlite3_limit(bag_.get(), SQLITE_LIMIT_ATTACHED, 0);
    // Some ten steps of SQLite's machine per row, and a row has ten bytes or more: pages that point
    // back to others would otherwise be walked without end.
    constexpr int kBlock = 1'000'000;
    blocks_left_ = 10 + static_cast<std::int64_t>(fs::file_size(path)) * 10 / kBlock;
    sqlite3_progress_handler(
        bag_.get(), kBlock,
        [](void* left) { return --*static_cast<std::int64_t*>(left) < 0 ? 1 : 0; }, &blocks_left_);
  }

  // Two tables that are stored rows, and columns that are stored values.
  void require_tables() const {
    for (const std::string table : {"topics", "messages"}) {
      Query stored =
          query("SELECT 1 FROM sqlite_schema WHERE type = 'table' AND rootpage > 0 AND name = ?");
      stored.bind(table);
      if (!stored.next()) throw UserError("{}: no ROS 2 bag: it has no table {}", file_, table);
      Query computed = query("SELECT 1 FROM pragma_table_xinfo(?) WHERE hidden <> 0");
      computed.bind(table);
      if (computed.next())
        throw UserError("{}: no ROS 2 bag: the table {} has computed columns", file_, table);
    }
  }

  std::int64_t topic_id(const std::string& wanted) const {
    Query topics =
        query("SELECT id, name, serialization_format FROM topics WHERE type = ? ORDER BY rowid");
    topics.bind(std::string(kJointStateType));
    std::string found, encoding;
    std::int64_t id = 0;
    while (topics.next()) {
      const std::string name = topics.text(1);
      if (!wanted.empty() && name != wanted) continue;
      if (!found.empty()) throw two_topics(file_, found, name);
      found = name;
      id = topics.number(0);
      encoding = topics.text(2);
    }
    if (found.empty()) throw no_joint_states(file_, wanted);
    if (encoding != "cdr")
      throw UserError("{}: {} is encoded as {}; allowed: cdr", file_, found, in_quotes(encoding));
    return id;
  }

  std::string file_;
  std::unique_ptr<sqlite3, decltype(&sqlite3_close)> bag_{nullptr, &sqlite3_close};
  mutable std::int64_t blocks_left_ = 0;
};

}  // namespace

std::vector<std::string> bag_names(const fs::path& path, const LogStyle& style) {
  JointStateNames names;
  Bag(path).walk(style.topic, [&](const JointState& state) { names.add(state); });
  return names.take();
}

LogTable read_bag(const fs::path& path, const std::vector<std::string>& wanted,
                  const LogStyle& style) {
  JointStateTable table(bag_names(path, style), wanted, path.string());
  Bag(path).walk(style.topic, [&](const JointState& state) { table.add(state); });
  return table.take();
}

}  // namespace fricid::data
