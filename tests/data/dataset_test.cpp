#include "fricid/data/dataset.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "fricid/base/not_finite.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Dataset make_dataset(int length = 50) {
  Dataset d;
  d.name = "train_0";
  d.joint_names = {"shoulder", "elbow"};
  d.rate_hz = 250;
  d.source = "simulation of a test, seed 1";
  d.t = Eigen::VectorXd::LinSpaced(length, 0, (length - 1) * 0.004);
  d.q.resize(length, 2);
  d.tau.resize(length, 2);
  for (int k = 0; k < length; ++k) {
    d.q.row(k) << std::sin(0.1 * k), 1.0 / (3 + k);
    d.tau.row(k) << 10 * std::cos(0.3 * k), -2.5;
  }
  return d;
}

bool same_bits(const RowMatrix& a, const RowMatrix& b) {
  const auto bits = [](const RowMatrix& x) {
    return std::as_bytes(std::span(x.data(), static_cast<std::size_t>(x.size())));
  };
  return a.rows() == b.rows() && a.cols() == b.cols() && std::ranges::equal(bits(a), bits(b));
}

class DatasetFile : public FolderTest {};

TEST_F(DatasetFile, RoundTripToTheLastBit) {
  Dataset d = make_dataset();
  for (const bool rich : {false, true}) {
    if (rich) {
      d.v = d.q * 3;
      d.temperature = RowMatrix::Constant(50, 2, 293.15);
      d.q(7, 1) = kNan;
    }
    save_dataset(d, path("new/train_0.h5"));
    const Dataset read = load_dataset(path("new/train_0.h5"));
    EXPECT_EQ(read.name, "train_0");
    EXPECT_EQ(read.joint_names, d.joint_names);
    EXPECT_EQ(read.rate_hz, 250);
    EXPECT_EQ(read.source, d.source);
    EXPECT_TRUE(same_bits(read.t, d.t));
    EXPECT_TRUE(same_bits(read.q, d.q));
    EXPECT_TRUE(same_bits(read.tau, d.tau));
    EXPECT_TRUE(same_bits(read.v, d.v));
    EXPECT_TRUE(same_bits(read.temperature, d.temperature));
  }
}

TEST_F(DatasetFile, SameContentSameBytes) {
  save_dataset(make_dataset(), path("a.h5"));
  save_dataset(make_dataset(), path("b.h5"));
  EXPECT_EQ(read("a.h5"), read("b.h5"));
}

TEST_F(DatasetFile, UnitsAreAttributes) {
  Dataset d = make_dataset();
  d.v = d.q;
  d.temperature = d.q;
  save_dataset(d, path("a.h5"));
  const H5Reader file(path("a.h5"), "fricid.dataset/1");
  EXPECT_THAT(file.names(), testing::ElementsAre("q", "t", "tau", "temperature", "v"));
  EXPECT_EQ(file.unit("t"), "s");
  EXPECT_EQ(file.unit("q"), "rad");
  EXPECT_EQ(file.unit("tau"), "N m");
  EXPECT_EQ(file.unit("v"), "rad/s");
  EXPECT_EQ(file.unit("temperature"), "K");
  EXPECT_EQ(hdf5_format(path("a.h5")), "fricid.dataset/1");
}

TEST_F(DatasetFile, TruncatedAtAnyLengthIsAnError) {
  save_dataset(make_dataset(500), path("a.h5"));
  const std::string whole = read("a.h5");
  const std::size_t step = 97;
  for (std::size_t length = 1; length < whole.size(); length += step) {
    write("torn.h5", whole.substr(0, length));
    ASSERT_THAT(message_of([&] { load_dataset(path("torn.h5")); }),
                testing::StartsWith("torn.h5: "))
        << "length " << length;
  }
  write("torn.h5", whole.substr(0, whole.size() - 1));
  EXPECT_EQ(message_of([&] { load_dataset(path("torn.h5")); }),
            "torn.h5: torn: its checksum does not match");
}

TEST_F(DatasetFile, ChangedNumbersAreAnError) {
  save_dataset(make_dataset(500), path("a.h5"));
  std::string whole = read("a.h5");
  const double value = make_dataset(500).q(321, 0);
  const std::size_t at =
      whole.find(std::string(reinterpret_cast<const char*>(&value), sizeof value));
  ASSERT_NE(at, std::string::npos);
  whole[at + 6] = static_cast<char>(whole[at + 6] ^ 1);
  write("changed.h5", whole);
  EXPECT_EQ(message_of([&] { load_dataset(path("changed.h5")); }),
            "changed.h5: torn: its checksum does not match");
}

TEST_F(DatasetFile, NotADataset) {
  const auto error = [&](const std::string& name) {
    return message_of([&] { load_dataset(path(name)); });
  };
  EXPECT_EQ(error("none.h5"), "none.h5: cannot be read: No such file or directory");
  std::filesystem::create_directory(path("folder.h5"));
  EXPECT_EQ(error("folder.h5"), "folder.h5: is a folder, a file is expected");
  write("empty.h5", "");
  EXPECT_EQ(error("empty.h5"), "empty.h5: an empty file");
  write("text.h5", "t,q1,tau1\n0,1,2\n");
  EXPECT_EQ(error("text.h5"),
            "text.h5: not an HDF5 file, or torn; `fricid import` makes one of a log in a format of "
            "docs/your_own_log.md");
  write_hdf5(path("truth.h5"), "fricid.truth/1", [](H5Writer&) {});
  EXPECT_EQ(error("truth.h5"), "truth.h5: format = \"fricid.truth/1\"; allowed: fricid.dataset/1");
  write_hdf5(path("newer.h5"), "fricid.dataset/2", [](H5Writer&) {});
  EXPECT_EQ(error("newer.h5"),
            "newer.h5: format fricid.dataset/2 is newer than fricid.dataset/1, which this program "
            "reads");
}

TEST_F(DatasetFile, PartsThatAreMissingOrOfAnotherShape) {
  const auto error = [&](const std::function<void(H5Writer&)>& change) {
    write_hdf5(path("a.h5"), "fricid.dataset/1", change);
    return message_of([&] { load_dataset(path("a.h5")); });
  };
  const auto head = [](H5Writer& file) {
    file.attribute("joint_names", std::vector<std::string>{"a", "b"});
    file.attribute("rate_hz", 250.0);
    file.attribute("source", std::string("test"));
    file.vector("t", Eigen::VectorXd::LinSpaced(3, 0, 0.008), "s");
  };
  EXPECT_EQ(error([](H5Writer&) {}), "a.h5: attribute joint_names is missing or not a text");
  EXPECT_EQ(error(head), "a.h5: /q is missing");
  EXPECT_EQ(error([&](H5Writer& file) {
              head(file);
              file.matrix("q", RowMatrix::Zero(3, 3), "rad");
            }),
            "a.h5: /q has 3 columns; allowed: 2");
  EXPECT_EQ(error([&](H5Writer& file) {
              head(file);
              file.matrix("q", RowMatrix::Zero(3, 2), "deg");
            }),
            "a.h5: unit of /q = \"deg\"; allowed: rad");
  EXPECT_EQ(error([&](H5Writer& file) {
              head(file);
              file.matrix("q", RowMatrix::Zero(4, 2), "rad");
              file.matrix("tau", RowMatrix::Zero(3, 2), "N m");
            }),
            "a.h5: table q has 4 rows; allowed: 3, as t");
}

TEST_F(DatasetFile, NothingIsWrittenWhenTheDataAreWrong) {
  Dataset d = make_dataset();
  d.tau(3, 0) = kInfinity;
  EXPECT_EQ(message_of([&] { save_dataset(d, path("a.h5")); }),
            "a.h5: sample 3: tau of shoulder = inf; allowed: finite, or nan where missing");
  EXPECT_FALSE(std::filesystem::exists(path("a.h5")));
}

TEST_F(DatasetFile, AFailedWriteKeepsTheOldFile) {
  save_dataset(make_dataset(), path("a.h5"));
  const std::string before = read("a.h5");
  EXPECT_EQ(message_of([&] {
              write_hdf5(path("a.h5"), "fricid.dataset/1", [](H5Writer& file) {
                file.vector("t", Eigen::VectorXd::Zero(3), "s");
                file.vector("t", Eigen::VectorXd::Zero(3), "s");
              });
            }),
            "a.h5: cannot create a table");
  EXPECT_EQ(read("a.h5"), before);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 3);
}

std::string error_of(const Dataset& d) {
  try {
    check_dataset(d, "log.h5");
  } catch (const UserError& error) {
    return error.what();
  }
  return "no error";
}

TEST(CheckDataset, AcceptsACleanRecording) {
  EXPECT_EQ(error_of(make_dataset()), "no error");
  EXPECT_TRUE(check_dataset(make_dataset(), "log.h5").empty());
}

TEST(CheckDataset, Times) {
  Dataset d = make_dataset();
  d.t[10] = d.t[9];
  EXPECT_EQ(error_of(d), "log.h5: sample 10: t = 0.036 s after 0.036 s; allowed: rising times");
  d = make_dataset();
  d.t.tail(30).array() += 0.004;
  EXPECT_EQ(error_of(d),
            "log.h5: sample 20: gap in time: 0.008 s after the sample before; allowed: 0.004 s "
            "within 1 %");
  d = make_dataset();
  d.t[10] += 0.0001;
  EXPECT_EQ(error_of(d),
            "log.h5: sample 10: jitter in time: 0.0041 s after the sample before; allowed: 0.004 s "
            "within 1 %; where samples were taken evenly and stamped late, `fricid import --fix "
            "jitter`");
  d.t[10] = kNan;
  EXPECT_EQ(error_of(d), "log.h5: sample 10: t = nan; allowed: a finite time");
  d = make_dataset();
  d.t[10] += 0.9 * 0.01 * 0.004;
  EXPECT_EQ(error_of(d), "no error");
}

TEST(CheckDataset, Shapes) {
  EXPECT_EQ(error_of(make_dataset(1)), "log.h5: 1 samples; allowed: at least 2");
  EXPECT_EQ(error_of(Dataset{}), "log.h5: 0 samples; allowed: at least 2");
  Dataset d = make_dataset();
  d.joint_names.pop_back();
  EXPECT_EQ(error_of(d), "log.h5: 1 joint names for 2 joints");
  d = make_dataset();
  d.tau.conservativeResize(50, 3);
  EXPECT_EQ(error_of(d), "log.h5: tau is 50 x 3; allowed: 50 samples x 2 joints");
  d = make_dataset();
  d.v = RowMatrix::Zero(49, 2);
  EXPECT_EQ(error_of(d), "log.h5: v is 49 x 2; allowed: 50 samples x 2 joints");
  d = make_dataset();
  d.rate_hz = 0;
  EXPECT_EQ(error_of(d), "log.h5: rate_hz = 0; allowed: a positive number");
}

TEST(CheckDataset, MissingValuesAreMarkedByNaN) {
  Dataset d = make_dataset();
  d.q(0, 0) = kNan;
  d.tau(3, 1) = kNan;
  EXPECT_EQ(error_of(d), "no error");
  d.tau.col(1).setConstant(kNan);
  EXPECT_EQ(error_of(d), "log.h5: tau of elbow has no value at all");
  d.q(0, 0) = -kInfinity;
  EXPECT_EQ(error_of(d),
            "log.h5: sample 0: q of shoulder = -inf; allowed: finite, or nan where missing");
}

TEST(CheckDataset, DegreesWarn) {
  Dataset d = make_dataset();
  d.q.col(1) *= 4 * std::numbers::pi / d.q(0, 1);
  EXPECT_TRUE(check_dataset(d, "log.h5").empty());
  d.q.col(1) *= 180 / (4 * std::numbers::pi);
  EXPECT_THAT(check_dataset(d, "log.h5"),
              testing::ElementsAre(
                  "log.h5: |q| of elbow reaches 180, more than 4 pi: degrees, or millimetres?"));
}

TEST(CheckDataset, CoarseQuantisationWarns) {
  Dataset d = make_dataset(500);
  const auto rounded = [&](double step) {
    for (int k = 0; k < 500; ++k) d.q(k, 0) = step * std::round(std::sin(0.001 * k) / step);
    return check_dataset(d, "log.h5");
  };
  EXPECT_TRUE(rounded(1e-5).empty());
  EXPECT_THAT(rounded(0.1 * std::numbers::pi / 180),
              testing::ElementsAre("log.h5: q of shoulder moves in steps of 0.00175: log it "
                                   "with more digits"));
}

}  // namespace
}  // namespace fricid::data
