#include "fricid/optimise/checkpoint.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <limits>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/rng.hpp"
#include "temporary_folder.hpp"

namespace fricid::optimise {
namespace {

struct Row {
  double a = 0;
  int b = 0;
  bool operator==(const Row&) const = default;
  template <class Archive>
  void visit(Archive& archive) {
    archive("a", a);
    archive("b", b);
  }
};

struct State {
  int iteration = 0;
  std::uint64_t draw = 0;
  double best = 0;
  Eigen::VectorXd c, none;
  std::vector<Row> rows;
  std::vector<std::string> warnings;
  bool operator==(const State&) const = default;
  template <class Archive>
  void visit(Archive& archive) {
    archive("iteration", iteration);
    archive("draw", draw);
    archive("best", best);
    archive("c", c);
    archive("none", none);
    archive("rows", rows);
    archive("warnings", warnings);
  }
};

State some_state() {
  return {3,
          (std::uint64_t{1} << 53) - 1,
          1.0 / 3,
          Eigen::Vector4d(0.1, -1e-300, 1.0 / 3, 4e15),
          {},
          {{0.1, -4}, {1e-17, 5}},
          {"beware", "of \"quotes\"\n"}};
}

/// Of the sizes of some_state().
State blank() {
  State state;
  state.c = Eigen::Vector4d::Zero();
  return state;
}

TEST(Checkpoint, BringsEverythingBackToTheLastBit) {
  const OwnFolder folder;
  const auto path = folder.path() / "fit" / "fit.json";
  const Checkpoint checkpoint(path, "key");
  const State state = some_state();
  checkpoint.save(state);
  State back = blank();
  ASSERT_TRUE(checkpoint.load(back));
  EXPECT_TRUE(back == state);
}

TEST(Checkpoint, IsThatOfOneSearchAndGoneWhenItIsDone) {
  const OwnFolder folder;
  const auto path = folder.path() / "fit" / "fit.json";
  const Checkpoint checkpoint(path, "key"), other(path, "another key");
  checkpoint.save(some_state());
  State back = blank();
  EXPECT_FALSE(other.load(back));
  EXPECT_FALSE(Checkpoint().load(back));
  EXPECT_TRUE(back == blank());
  checkpoint.remove();
  EXPECT_FALSE(checkpoint.load(back));
  EXPECT_FALSE(std::filesystem::exists(path.parent_path()));
}

struct Renamed {
  double best = 7, another = 8;
  template <class Archive>
  void visit(Archive& archive) {
    archive("best", best);
    archive("another", another);
  }
};

TEST(Checkpoint, OfOtherNamesOrTornOrNotFiniteIsNotTaken) {
  const OwnFolder folder;
  const auto path = folder.path() / "fit" / "fit.json";
  const Checkpoint checkpoint(path, "key");
  checkpoint.save(some_state());
  Renamed renamed;
  EXPECT_FALSE(checkpoint.load(renamed));
  EXPECT_EQ(renamed.best, 7);

  State infinite = some_state(), back = blank();
  infinite.best = std::numeric_limits<double>::infinity();
  checkpoint.save(infinite);
  EXPECT_FALSE(checkpoint.load(back));

  for (const char* text :
       {"{\"format\": \"fricid.check", "[]", "3", "{\"format\": 1, \"key\": []}"}) {
    std::ofstream(path) << text;
    EXPECT_FALSE(checkpoint.load(back)) << text;
  }
}

// A checkpoint in a run folder from others may hold anything.
class DamagedCheckpoint : public testing::Test {
 protected:
  const OwnFolder folder;
  const std::filesystem::path path = folder.path() / "fit.json";
  const Checkpoint checkpoint{path, "key"};

  /// Whether some_state() with other text in its file is taken.
  bool takes(const std::string& old, const std::string& changed) const {
    checkpoint.save(some_state());
    std::string text = read_file(path);
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old << " in " << text;
    write_file_atomically(path, text.replace(at, old.size(), changed));
    State back = blank();
    return checkpoint.load(back);
  }
};

TEST_F(DamagedCheckpoint, IsTakenAsItWas) { EXPECT_TRUE(takes("0.1", "0.2")); }

TEST_F(DamagedCheckpoint, VectorsKeepTheirSize) {
  EXPECT_FALSE(takes("\"c\":[", "\"c\":[7.0,"));
  EXPECT_FALSE(takes("\"none\":[", "\"none\":[7.0"));
}

TEST_F(DamagedCheckpoint, WholeNumbersAreOfTheirType) {
  for (const char* wrong : {"1e300", "2147483648.0", "-2147483649.0"})
    EXPECT_FALSE(takes("\"iteration\":[3.0]", fmt::format("\"iteration\":[{}]", wrong))) << wrong;
  EXPECT_FALSE(takes("\"draw\":[9.007199254740991e+15]", "\"draw\":[-1.0]"));
  EXPECT_FALSE(takes("\"draw\":[9.007199254740991e+15]", "\"draw\":[18446744073709551616.0]"));
}

TEST_F(DamagedCheckpoint, RowsAreAsManyAsThereAre) {
  for (const char* wrong : {"3.0", "1e15", "-1.0"})
    EXPECT_FALSE(takes("\"rows.rows\":[2.0]", fmt::format("\"rows.rows\":[{}]", wrong))) << wrong;
}

struct Agreeing {
  int first = 1, second = 1;
  bool agrees() const { return first == second; }
  template <class Archive>
  void visit(Archive& archive) {
    archive("first", first);
    archive("second", second);
  }
};

TEST(Checkpoint, OfStatesThatContradictThemselvesIsNotTaken) {
  const OwnFolder folder;
  const Checkpoint checkpoint(folder.path() / "fit.json", "key");
  Agreeing back;
  checkpoint.save(Agreeing{2, 2});
  EXPECT_TRUE(checkpoint.load(back));
  checkpoint.save(Agreeing{2, 3});
  EXPECT_FALSE(checkpoint.load(back));
  EXPECT_EQ(back.first, 2);
}

/// A random search for the least |c|: ten iterations, or as many as it lives; it begins where the
/// checkpoint says.
State search(const Checkpoint& checkpoint, int lives) {
  State now;
  now.c = Eigen::Vector3d(1, -2, 3);
  now.best = now.c.norm();
  checkpoint.load(now);
  Rng rng(4, 2, now.draw);
  for (; now.iteration < 10 && lives > 0; --lives) {
    Eigen::VectorXd trial = now.c;
    for (double& x : trial) x += 0.3 * rng.normal();
    if (trial.norm() < now.best) {
      now.c = trial;
      now.best = trial.norm();
      now.rows.push_back({now.best, now.iteration});
    }
    ++now.iteration;
    now.draw = rng.draw();
    checkpoint.save(now);
  }
  return now;
}

TEST(Checkpoint, ASearchThatIsKilledEndsWhereOneEndsThatRunsOn) {
  const State straight = search({}, 10);
  EXPECT_GT(straight.rows.size(), 2u);
  for (int lives = 1; lives < 10; ++lives) {
    const OwnFolder folder;
    const Checkpoint checkpoint(folder.path() / "search.json", "key");
    EXPECT_FALSE(search(checkpoint, lives) == straight) << lives;
    EXPECT_TRUE(search(checkpoint, 10) == straight) << lives;
  }
}

}  // namespace
}  // namespace fricid::optimise
