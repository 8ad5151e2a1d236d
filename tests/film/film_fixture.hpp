// A run folder made by formulas: the KR 6 swings for two seconds, three models drift away from it.
#pragma once

#include <cmath>

#include "blank_evaluation.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/truth.hpp"
#include "fricid/workflow/run_folder.hpp"
#include "source_dir.hpp"
#include "temporary_folder.hpp"

namespace fricid::film {

class FilmFolder : public TemporaryFolder {
 protected:
  static constexpr int kRows = 501, kJoints = 6;
  static constexpr double kRate = 250;
  static constexpr const char* kTrajectory = "validation_0";

  const workflow::RunFolder run{folder};
  evaluate::Trajectory trajectory;
  scene::Scene scene = scene::load_scene(source_dir() / "scenes/kr6_demo.toml");
  scene::Problem problem() const { return scene::resolve(scene); }

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

  /// An open loop that is `drift` rad off after one second, its friction torque as it is given.
  void save_rollout(const std::string& model, double drift, const data::RowMatrix& tau_f,
                    int rows = kRows) const {
    const evaluate::Rollout rollout{{0, 0, rows - 1},
                                    false,
                                    motion(drift, false).topRows(rows),
                                    motion(drift, true).topRows(rows),
                                    tau_f.topRows(std::min<Eigen::Index>(rows, tau_f.rows()))};
    evaluate::save_rollout(rollout, trajectory, model, 1, run.rollout({model, 1}, kTrajectory));
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
    data::save_model(file, run.model({name, 1}));
  }

  void SetUp() override {
    TemporaryFolder::SetUp();
    data::Dataset& measured = trajectory.data;
    measured.name = kTrajectory;
    for (int j = 0; j < kJoints; ++j)
      measured.joint_names.push_back("joint_a" + std::to_string(j + 1));
    measured.rate_hz = kRate;
    measured.t = Eigen::VectorXd::LinSpaced(kRows, 0, (kRows - 1) / kRate);
    measured.q = motion(0, false);
    measured.tau = friction(0);
    data::save_dataset(measured, run.recording(kTrajectory));

    evaluate::Evaluation evaluation = blank_evaluation("swing", {1, 2}, {kTrajectory});
    const auto add = [&](const std::string& name, double drift, bool is_oracle) {
      add_model(evaluation, name, is_oracle, {drift * drift / 10, drift * drift});
      if (!is_oracle) write_model(name);
      save_rollout(name, drift, friction(10 * drift));
    };
    add("oracle", 1e-4, true);
    add("simple", 0.08, false);
    add("lugre", 0.05, false);
    add("dahl", 0.06, false);
    add("gms", 0.02, false);
    data::save(evaluation, run.evaluation());

    sim::Truth truth;
    truth.joint_names = measured.joint_names;
    truth.rate_hz = kRate;
    truth.friction.model = friction::RobotFriction(std::vector<friction::JointSpec>(kJoints));
    truth.trace = sim::make_trace(kRows, truth.dt(), kJoints, 0);
    truth.trace.q = motion(0, false);
    truth.trace.v = motion(0, true);
    truth.trace.tau_f = friction(0);
    sim::save_truth(truth, run.truth(kTrajectory));
    scene.name = "swing";
    scene.description = "two seconds made by formulas";
  }
};

}  // namespace fricid::film
