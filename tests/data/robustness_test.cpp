// Damaged files: every reader ends with a result or a UserError, whatever byte is changed, lost or
// doubled.
#include <gtest/gtest.h>

#include "fricid/base/rng.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/scene/problem.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

class DamagedFile : public FolderTest {
 protected:
  // Reads `count` damaged copies; returns how many were refused.
  int refused(const std::string& whole, int count,
              const std::function<void(const std::filesystem::path&)>& load) const {
    Rng rng(1, 0);
    int errors = 0;
    const auto below = [&](std::size_t n) {
      return static_cast<std::size_t>(rng.uniform() * static_cast<double>(n));
    };
    for (int trial = 0; trial < count; ++trial) {
      std::string damaged = whole;
      const std::size_t at = below(damaged.size());
      switch (trial % 4) {
        case 0:
          damaged[at] = static_cast<char>(below(256));
          break;
        case 1:
          damaged.erase(at, 1 + below(20));
          break;
        case 2:
          damaged.insert(at, damaged.substr(below(damaged.size()), 1 + below(40)));
          break;
        default:
          damaged[at] = static_cast<char>(damaged[at] ^ (1 << below(8)));
      }
      try {
        load(write("damaged", damaged));
      } catch (const UserError& error) {
        ++errors;
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      }
    }
    return errors;
  }
};

TEST_F(DamagedFile, Scene) {
  const std::string scene = scene::to_toml(scene::load_problem(write("scene.toml", kScene)).scene);
  const int errors = refused(scene, 800, [](const auto& file) { scene::load_problem(file); });
  EXPECT_GT(errors, 300);
}

TEST_F(DamagedFile, Dataset) {
  Dataset d;
  d.joint_names = {"a", "b"};
  d.rate_hz = 100;
  d.source = "test";
  d.t = Eigen::VectorXd::LinSpaced(100, 0, 0.99);
  d.q = RowMatrix::Random(100, 2);
  d.tau = RowMatrix::Random(100, 2);
  save_dataset(d, path("a.h5"));
  const int errors = refused(read("a.h5"), 800, [](const auto& file) { load_dataset(file); });
  EXPECT_GT(errors, 600);
}

TEST_F(DamagedFile, Model) {
  ModelFile model{.name = "m", .label = "M", .arm = {}};
  model.arm.robot = dynamics::load_urdf(path("arm.urdf"));
  model.arm.friction = *scene::load_problem(write("scene.toml", kScene)).scene.friction;
  save_model(model, path("a.json"));
  const int errors = refused(read("a.json"), 800, [](const auto& file) { load_model(file); });
  EXPECT_GT(errors, 300);
}

TEST_F(DamagedFile, Log) {
  const Contract contract = load_contract(
      write("contract.toml",
            "joint_names = [\"a\"]\nposition.columns = \"q\"\ntorque.columns = \"tau\"\n"));
  std::string log = "t,q,tau\n";
  for (int k = 0; k < 40; ++k)
    log += std::to_string(0.01 * k) + "," + std::to_string(k * k) + "," +
           std::to_string(1.0 / (k + 1)) + "\n";
  const int errors = refused(log, 800, [&](const auto& file) { import_log(file, contract); });
  EXPECT_GT(errors, 200);
}

TEST_F(DamagedFile, Contract) {
  const int errors =
      refused(contract_template(), 800, [](const auto& file) { load_contract(file); });
  EXPECT_GT(errors, 100);
}

}  // namespace
}  // namespace fricid::data
