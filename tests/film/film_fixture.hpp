// A run folder made by formulas: the KR 6 swings for two seconds, three models drift away from it.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "fricid/base/files.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/data/problem.hpp"
#include "temporary_folder.hpp"

namespace fricid::film {

class FilmFolder : public TemporaryFolder {
 protected:
  static constexpr int kRows = 501, kJoints = 6;
  static constexpr double kRate = 250;

  data::Scene scene = data::load_scene(std::string(FRICID_SOURCE_DIR) + "/scenes/kr6_demo.toml");
  data::Problem problem() const { return data::resolve(scene); }

  /// Angle or speed of joint j, `drift` rad off after one second.
  static data::RowMatrix motion(double drift, bool speed) {
    constexpr std::array<double, kJoints> kMiddle{0.2, -1.2, 0.9, 0, -0.8, 0};
    data::RowMatrix values(kRows, kJoints);
    for (int k = 0; k < kRows; ++k)
      for (int j = 0; j < kJoints; ++j) {
        const double t = k / kRate, w = 2 + 0.5 * j, growth = j == 1 ? 1 : 0.3;
        values(k, j) = speed ? 0.4 * w * std::cos(w * t) + drift * growth
                             : kMiddle[static_cast<std::size_t>(j)] + 0.4 * std::sin(w * t) +
                                   drift * growth * t;
      }
    return values;
  }

  /// Coulomb friction, missed by `missed` N m at joint 2.
  static data::RowMatrix friction(double missed) {
    data::RowMatrix values = motion(0, true);
    for (int k = 0; k < kRows; ++k)
      for (int j = 0; j < kJoints; ++j)
        values(k, j) = 8 * std::tanh(20 * values(k, j)) + (j == 2 ? missed : 0);
    return values;
  }

  void write(const std::string& name, const std::string& format, double drift,
             double missed) const {
    data::write_hdf5(folder / name, format, [&](data::H5Writer& file) {
      file.vector("/t", Eigen::VectorXd::LinSpaced(kRows, 0, (kRows - 1) / kRate), "s");
      file.matrix("/q", motion(drift, false), "rad");
      file.matrix("/v", motion(drift, true), "rad/s");
      file.matrix("/tau_f", friction(missed), "N m");
    });
  }

  void write_model(const std::string& name) const {
    const friction::LawSpec law{
        name == "simple" ? "coulomb_viscous" : name, name == "gms" ? 2 : 0, {}};
    const friction::RobotFriction model(std::vector<friction::JointSpec>(kJoints, {{law}}));
    data::ModelFile file{
        .name = name,
        .label = name,
        .arm = {problem().robot, {model, friction::default_theta(model)}},
    };
    data::save_model(file, folder / "models" / (name + "_s1.json"));
  }

  void SetUp() override {
    TemporaryFolder::SetUp();
    using nlohmann::json;
    json models, summary;
    const auto add = [&](const std::string& name, double drift, bool is_oracle) {
      models.push_back({{"name", name}, {"label", name}, {"seed", 1}, {"is_oracle", is_oracle}});
      summary.push_back(
          {{"name", name}, {"q_mse_geometric_mean", {drift * drift / 10, drift * drift}}});
      if (!is_oracle) write_model(name);
      write("rollouts/" + name + "_s1_validation_0.h5", "fricid.rollout/1", drift, 10 * drift);
    };
    add("oracle", 1e-4, true);
    add("simple", 0.08, false);
    add("lugre", 0.05, false);
    add("dahl", 0.06, false);
    add("gms", 0.02, false);
    write_file_atomically(folder / "evaluation.json", json{{"format", "fricid.evaluation/1"},
                                                           {"scene", "swing"},
                                                           {"horizons_s", {1, 2}},
                                                           {"trajectories", {"validation_0"}},
                                                           {"models", models},
                                                           {"summary", summary}}
                                                          .dump());
    data::Dataset measured;
    for (int j = 0; j < kJoints; ++j)
      measured.joint_names.push_back("joint_a" + std::to_string(j + 1));
    measured.rate_hz = kRate;
    measured.t = Eigen::VectorXd::LinSpaced(kRows, 0, (kRows - 1) / kRate);
    measured.q = motion(0, false);
    measured.tau = friction(0);
    data::save_dataset(measured, folder / "data/validation_0.h5");
    write("truth/validation_0.h5", "fricid.truth/1", 0, 0);
    scene.name = "swing";
    scene.description = "two seconds made by formulas";
  }
};

}  // namespace fricid::film
