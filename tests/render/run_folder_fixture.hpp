// A small run folder to draw from.
#pragma once

#include <functional>
#include <string>

#include "blank_evaluation.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/sim/truth.hpp"
#include "fricid/workflow/run_folder.hpp"
#include "temporary_folder.hpp"

namespace fricid::render {

/// The oracle and one model, fitted with bristles as the truth has them, on one trajectory of two
/// joints.
class RunToDraw : public TemporaryFolder {
 protected:
  static constexpr int kRows = 4000, kJoints = 2;
  static constexpr double kTruth = 10, kPredicted = 20, kMeasured = 30, kRollout = 40;
  static constexpr const char* kTrajectory = "validation_0";

  const workflow::RunFolder run{folder};
  const workflow::FitId simple{"simple", 1};
  evaluate::Trajectory trajectory;

  void SetUp() override {
    TemporaryFolder::SetUp();
    data::Dataset& measured = trajectory.data;
    measured.name = kTrajectory;
    measured.joint_names = {"joint_a1", "joint_a2"};
    measured.rate_hz = 250;
    measured.source = "a <test>";
    measured.t = Eigen::VectorXd::LinSpaced(kRows, 0, (kRows - 1) / measured.rate_hz);
    measured.q = measured.tau = ramp(kMeasured);
    data::save_dataset(measured, run.recording(kTrajectory));
    data::save_dataset(measured, run.recording(run.training(0)));

    save_evaluation();
    save_truth();
    save_model();
    evaluate::TorquePrediction prediction;
    prediction.tau = prediction.tau_f = ramp(kPredicted);
    evaluate::save_prediction(prediction, measured, ramp(0), ramp(0),
                              run.prediction(simple, kTrajectory));
    const evaluate::Rollout rollout{{0, 0, kRows - 1}, false, ramp(kRollout), ramp(0), ramp(0)};
    for (const char* name : {"oracle", "simple"})
      evaluate::save_rollout(rollout, trajectory, name, 1, run.rollout({name, 1}, kTrajectory));
  }

  /// Row k of joint j: base + j + k / 1000.
  static data::RowMatrix ramp(double base) {
    data::RowMatrix values(kRows, kJoints);
    for (int k = 0; k < kRows; ++k)
      for (int j = 0; j < kJoints; ++j) values(k, j) = base + j + k * 1e-3;
    return values;
  }

  void edit_evaluation(const std::function<void(evaluate::Evaluation&)>& change) const {
    auto evaluation = data::load<evaluate::Evaluation>(run.evaluation());
    change(evaluation);
    data::save(evaluation, run.evaluation());
  }
  /// Changes the fit of the model, beginning with two joints of which nothing is said.
  void edit_fit(const std::function<void(data::FitFile&)>& change) const {
    auto fit = data::load<data::FitFile>(run.fit(simple));
    for (const std::string& name : trajectory.data.joint_names)
      fit.joints.emplace_back().joint = name;
    change(fit);
    data::save(fit, run.fit(simple));
  }

  /// Makes a joint of the model's robot slide.
  void let_slide(int joint) const {
    data::ModelFile model = data::load_model(run.model(simple));
    model.arm.robot.joints[static_cast<std::size_t>(joint)].type = dynamics::JointType::kPrismatic;
    data::save_model(model, run.model(simple));
  }

 private:
  void save_evaluation() const {
    evaluate::Evaluation evaluation = blank_evaluation("two joints", {1, 10}, {kTrajectory});
    add_model(evaluation, "simulator", true, {1e-6, kNotKnown});
    add_model(evaluation, "oracle", true, {1e-6, kNotKnown});
    add_model(evaluation, "simple", false, {7e-6, kNotKnown});
    for (evaluate::Summary& row : evaluation.summary) {
      row.ratio_to_oracle[0] = row.q_mse_geometric_mean[0] * 1e6;
      row.headroom_closed[0] = 0;
      row.rollouts = 4;
    }
    for (const double mse : {4.0, 16.0}) {
      evaluate::RolloutScore& score = evaluation.models[2].scores.emplace_back();
      score.name = kTrajectory;
      for (const double second : {mse, 1.0})
        score.error.add({kNotKnown,
                         kNotKnown,
                         kNotKnown,
                         kNotKnown,
                         {1, second},
                         unknown(kJoints),
                         unknown(kJoints),
                         unknown(kJoints)});
    }
    evaluation.oracle[0] = 1e-6;
    evaluation.floor[0] = 2e-6;
    data::save(evaluation, run.evaluation());
  }

  /// A bristle at every joint.
  static friction::Friction bristles() {
    const friction::JointSpec joint{{{.law = "dahl", .elements = 0, .modifiers = {}}}};
    friction::RobotFriction model({joint, joint});
    std::vector<double> theta = friction::default_theta(model);
    return {std::move(model), std::move(theta)};
  }

  void save_truth() const {
    sim::Truth truth;
    truth.joint_names = trajectory.data.joint_names;
    truth.rate_hz = trajectory.data.rate_hz;
    truth.friction = bristles();
    truth.trace = sim::make_trace(kRows, truth.dt(), kJoints, truth.friction.model.state_size());
    truth.trace.v = truth.trace.tau_f = ramp(kTruth);
    truth.trace.z = ramp(0);
    sim::save_truth(truth, run.truth(kTrajectory));
  }

  void save_model() const {
    std::string urdf = "<robot name=\"two\"><link name=\"l0\"/>";
    for (int i = 1; i <= kJoints; ++i)
      urdf += fmt::format(
          "<link name=\"l{0}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" "
          "izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint "
          "name=\"joint_a{0}\" type=\"revolute\"><parent link=\"l{1}\"/><child "
          "link=\"l{0}\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"2\" "
          "effort=\"3\"/></joint>",
          i, i - 1);
    data::ModelFile model{.name = simple.model, .label = simple.model, .arm = {}};
    model.arm.robot = dynamics::parse_urdf(urdf + "</robot>", "two joints");
    model.arm.friction = bristles();
    data::save_model(model, run.model(simple));

    data::FitFile fit;
    fit.name = fit.label = simple.model;
    fit.method = "conventional";
    fit.outcome = data::Outcome::kConverged;
    fit.usable = true;
    fit.parameters = 4;
    data::save(fit, run.fit(simple));
  }

 protected:
  static constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace fricid::render
