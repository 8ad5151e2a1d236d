// Every format gives the data set that the CSV contract gives for the same recording.
#include <gmock/gmock.h>

#include "fricid/base/files.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_reader.hpp"
#include "log_samples.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class LogFormats : public FolderTest {
 protected:
  std::filesystem::path write_log(const LogSample& sample) const {
    for (const auto& [name, content] : sample.files) write(sample.format + "/" + name, content);
    return path(sample.format + "/" + sample.files[0].first);
  }
  Contract contract(const std::string& text) const {
    return load_contract(write("contract.toml", text));
  }
  Dataset import(const LogSample& sample) const {
    return import_log(write_log(sample), contract(sample.contract));
  }
  void expect_same(const Dataset& d, const Dataset& expected) const {
    EXPECT_EQ(d.joint_names, expected.joint_names);
    EXPECT_EQ(d.rate_hz, expected.rate_hz);
    ASSERT_EQ(d.length(), expected.length());
    EXPECT_LT((d.t - expected.t).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((d.q - expected.q).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((d.tau - expected.tau).cwiseAbs().maxCoeff(), 1e-11);
    if (d.v.size() > 0) {
      EXPECT_LT((d.v - expected.v).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
  std::string error(const LogSample& sample) const {
    return message_of([&] { import(sample); });
  }
};

TEST_F(LogFormats, AllGiveTheSameDataSet) {
  const Dataset expected = import(csv_sample(Recording(200)));
  for (const LogSample& sample : log_samples(200)) {
    SCOPED_TRACE(sample.format);
    expect_same(import(sample), expected);
  }
}

TEST_F(LogFormats, AreRecognisedByTheirContent) {
  for (const LogSample& sample : log_samples(10)) {
    const std::string expected = sample.format == "german_csv" ? "csv" : sample.format;
    EXPECT_EQ(reader_for(write_log(sample), "auto").name, expected);
  }
}

TEST_F(LogFormats, VelocityIsTakenWhereTheFormatHasIt) {
  const Recording r(20);
  EXPECT_EQ(import(ur_csv_sample(r)).v.rows(), 20);
  EXPECT_EQ(import(mcap_sample(r)).v.rows(), 20);
  EXPECT_EQ(import(rsi_xml_sample(r)).v.rows(), 0);
}

TEST_F(LogFormats, TorqueOfAnotherMeaningIsSaid) {
  EXPECT_EQ(import(franka_csv_sample(Recording(20))).source,
            "import log.csv, tau from link_torque");
  EXPECT_THAT(warning_of_torque(import(franka_csv_sample(Recording(20)))),
              testing::HasSubstr("measured beyond the gear"));
  EXPECT_EQ(warning_of_torque(import(csv_sample(Recording(50)))), "");
  Contract contract;
  EXPECT_THAT(
      meaning_in_words(contract, "a.toml"),
      testing::ElementsAre(
          "a.toml: torque.kind = \"joint_torque\": taken as motor torque times gear ratio"));
  contract.torque.kind = "link_torque";
  EXPECT_THAT(meaning_in_words(contract, "a.toml"),
              testing::ElementsAre(testing::HasSubstr("measured beyond the gear")));
}

TEST_F(LogFormats, APositionThatWasCommandedIsSaid) {
  Contract contract;
  for (const char* name :
       {"target_q_{0}", "TargetQ{}", "q{}_cmd", "PosSollMot_A{}", "desired.positions.{}"}) {
    contract.position.columns = {name};
    EXPECT_THAT(meaning_in_words(contract, "a.toml"),
                testing::Contains(testing::HasSubstr(
                    std::string("\"") + name + "\", by its name a position that was commanded")));
  }
  for (const char* name :
       {"q{}", "actual_q_{0}", "Position{}", "description_{}", "preference", "pos_{name}"}) {
    contract.position.columns = {name};
    EXPECT_EQ(meaning_in_words(contract, "a.toml").size(), 1u) << name;
  }
}

TEST_F(LogFormats, Hdf5OfThisAndOtherPrograms) {
  const Dataset expected = import(csv_sample(Recording(50)));
  save_dataset(expected, path("own.h5"));
  const std::string text =
      std::string(kJoints) + "format = \"hdf5\"\n[torque]\ncolumns = \"tau{}\"\n";
  expect_same(import_log(path("own.h5"), contract(text)), expected);
  write_hdf5(path("other.h5"), "other/7", [&](H5Writer& file) {
    file.vector("time", expected.t, "s");
    file.matrix("angle", expected.q, "rad");
    file.matrix("moment", expected.tau, "N m");
  });
  expect_same(import_log(path("other.h5"),
                         contract(std::string(kJoints) +
                                  "[time]\ncolumn = \"time\"\n[position]\ncolumns = \"angle{}\"\n"
                                  "[torque]\ncolumns = \"moment{}\"\n")),
              expected);
}

TEST_F(LogFormats, AColumnThatAnHdf5FileLacksIsNamedWithThoseThatItHas) {
  const Dataset expected = import(csv_sample(Recording(50)));
  write_hdf5(path("log.h5"), "other/7", [&](H5Writer& file) {
    file.vector("t", expected.t, "s");
    file.matrix("angle", expected.q, "rad");
    file.matrix("none", RowMatrix(0, 0), "");
  });
  try {
    import_log(path("log.h5"), contract(std::string(kJoints) +
                                        "format = \"hdf5\"\n[torque]\ncolumns = \"tau{}\"\n"));
    ADD_FAILURE() << "read";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("log.h5: q1 is missing; found angle1, angle2"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("and none (a group, a table of records, or "));
  }
}

// MATLAB stores a matrix by columns: in its HDF5 files rows and columns are exchanged.
TEST_F(LogFormats, Hdf5OfMatlabLiesTheOtherWayRound) {
  const Dataset expected = import(csv_sample(Recording(50)));
  const Contract terms =
      contract(std::string(kJoints) + "format = \"hdf5\"\n[torque]\ncolumns = \"tau{}\"\n");
  for (const bool row : {false, true})
    for (const bool turned : {false, true}) {
      write_hdf5(path("log.h5"), "MATLAB 7.3 MAT-file/1", [&](H5Writer& file) {
        if (row)
          file.matrix("t", expected.t.transpose(), "s");
        else
          file.vector("t", expected.t, "s");
        file.matrix("q", turned ? RowMatrix(expected.q.transpose()) : expected.q, "rad");
        file.matrix("tau", expected.tau.transpose(), "N m");
        file.matrix("gain", RowMatrix::Ones(1, 3), "");
      });
      expect_same(import_log(path("log.h5"), terms), expected);
    }
}

TEST_F(LogFormats, LostRsiPacketsAreAGap) {
  LogSample sample = rsi_xml_sample(Recording(100));
  std::string& text = sample.files[0].second;
  const std::size_t begin = text.find("<IPOC>680309908");
  const std::size_t packet = text.rfind("<Rob", begin);
  text.erase(packet, text.find("<Rob", packet + 1) - packet);
  EXPECT_THAT(error(sample), HasSubstr("log.xml:101: gap in time: 0.008 s"));
}

// Oracle: q = A m with the motor angles in joint units, power is the same on both sides.
TEST_F(LogFormats, CoupledMotors) {
  const Recording r(30);
  const std::string text = csv_sample(r).contract;
  const std::string geared =
      replaced(replaced(text, "columns = \"q{}\"\n", "columns = \"q{}\"\nunit = \"motor_rad\"\n"),
               "columns = \"tau{}\"\n", "columns = \"tau{}\"\nkind = \"motor_torque\"\n");
  const std::string coupled =
      replaced(geared, "[velocity]\ncolumns = \"dq{}\"\n",
               "[velocity]\ncolumns = \"dq{}\"\nunit = \"motor_rad\"\n") +
      "[[coupling]]\njoint = \"elbow\"\nmotor = \"shoulder\"\nfactor = 0.25\n";
  const Dataset d = import({"csv", csv_sample(r).files, "gear_ratio = [2, 4]\n" + coupled});
  for (int k = 0; k < 30; ++k) {
    EXPECT_NEAR(d.q(k, 0), r.q(k, 0) / 2, 1e-12);
    EXPECT_NEAR(d.q(k, 1), r.q(k, 1) / 4 + 0.25 * r.q(k, 0) / 2, 1e-12);
    EXPECT_NEAR(d.tau.row(k).dot(d.v.row(k)), r.tau.row(k).dot(r.v.row(k)), 1e-9);
  }
}

TEST_F(LogFormats, PercentOfTheLargestCurrent) {
  LogSample sample = ur_csv_sample(Recording(20));
  const Dataset plain = import(sample);
  sample.contract += "percent_of = [40, 20]\n";
  const Dataset percent = import(sample);
  EXPECT_NEAR(percent.tau(5, 0), 0.4 * plain.tau(5, 0), 1e-12);
  EXPECT_NEAR(percent.tau(5, 1), 0.2 * plain.tau(5, 1), 1e-12);
}

TEST_F(LogFormats, Mistakes) {
  const Recording r(20);
  EXPECT_EQ(error(mcap_sample(r, "bz2")),
            "mcap/log.mcap: chunks are compressed by \"bz2\"; allowed: zstd lz4");
  LogSample trace = kuka_trace_sample(r);
  trace.contract = replaced(trace.contract, "gear_ratio = [100, 50]\n", "");
  EXPECT_THAT(error(trace), HasSubstr("gear_ratio is missing"));
  LogSample rsi = rsi_xml_sample(r);
  rsi.contract = replaced(rsi.contract, "MACur", "GearTorque");
  EXPECT_THAT(error(rsi), HasSubstr("no column \"GearTorque.A1\""));
  std::filesystem::remove(write_log(kuka_trace_sample(r)).replace_extension(".r64"));
  EXPECT_THAT(message_of([&] {
                import_log(path("kuka_trace/PC - 4711_test_NextGenDrive#1.dat"),
                           contract(kuka_trace_sample(r).contract));
              }),
              HasSubstr("NextGenDrive#1.r64: missing"));
  EXPECT_THAT(
      message_of([&] { contract(std::string(kJoints) + "[torque]\ncolumns = \"tau{}\"\n"); }),
      HasSubstr("position.columns names 0 columns; allowed: 2, one per joint, or one pattern with "
                "{}; or none with format = \"...\", one of mcap db3 hdf5 mat kuka_trace "));
  EXPECT_THAT(message_of([&] {
                contract(csv_sample(r).contract +
                         "[[coupling]]\njoint = \"wrist\"\nmotor = \"elbow\"\nfactor = 1\n");
              }),
              HasSubstr("coupling[1].joint = \"wrist\"; allowed: shoulder, elbow"));
}

// Whatever byte a file ends at: a data set or one line, never a crash.
TEST_F(LogFormats, SurviveTruncationAtEveryByte) {
  for (const LogSample& sample : log_samples(6)) {
    const Contract terms = contract(sample.contract);
    for (std::size_t f = 0; f < sample.files.size(); ++f) {
      const std::filesystem::path log = write_log(sample);
      const auto& [name, content] = sample.files[f];
      int refused = 0;
      for (std::size_t size = 0; size < content.size(); ++size) {
        write(sample.format + "/" + name, content.substr(0, size));
        try {
          import_log(log, terms);
        } catch (const UserError& e) {
          ++refused;
          ASSERT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
        }
      }
      EXPECT_GT(refused, 0) << sample.format;
    }
  }
}

TEST_F(LogFormats, Hdf5SurvivesTruncationAtEveryByte) {
  const Dataset recording = import(csv_sample(Recording(6)));
  save_dataset(recording, path("own.h5"));
  const std::string whole = read_file(path("own.h5"));
  const Contract terms =
      contract(std::string(kJoints) + "format = \"hdf5\"\n[torque]\ncolumns = \"tau{}\"\n");
  int refused = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::filesystem::path torn = write("torn.h5", whole.substr(0, size));
    try {
      import_log(torn, terms);
    } catch (const UserError& e) {
      ++refused;
      ASSERT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
  EXPECT_EQ(refused, static_cast<int>(whole.size()));
}

}  // namespace
}  // namespace fricid::data
