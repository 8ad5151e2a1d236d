// A small run folder to draw from.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "fricid/base/files.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "temporary_folder.hpp"

namespace fricid::render {

/// The oracle and one model, fitted with bristles as the truth has them, on one trajectory of two
/// joints.
class RunFolder : public TemporaryFolder {
 protected:
  using json = nlohmann::json;
  static constexpr int kRows = 4000, kJoints = 2;
  static constexpr double kTruth = 10, kPredicted = 20, kMeasured = 30, kRollout = 40;

  void SetUp() override {
    TemporaryFolder::SetUp();
    write_evaluation();
    data::Dataset measured;
    measured.joint_names = {"joint_a1", "joint_a2"};
    measured.rate_hz = 250;
    measured.source = "a <test>";
    measured.t = Eigen::VectorXd::LinSpaced(kRows, 0, (kRows - 1) / measured.rate_hz);
    measured.q = measured.tau = ramp(kMeasured);
    data::save_dataset(measured, folder / "data/validation_0.h5");
    data::save_dataset(measured, folder / "data/train_0.h5");
    write("truth/validation_0.h5", "fricid.truth/1",
          {{"/v", kTruth}, {"/tau_f", kTruth}, {"/z", 0}}, friction_json().dump());
    write_model();
    write("predictions/simple_s1_validation_0.h5", "fricid.prediction/1",
          {{"/q", 0},
           {"/v", 0},
           {"/tau", kMeasured},
           {"/tau_predicted", kPredicted},
           {"/tau_f", kPredicted}});
    for (const char* name : {"oracle", "simple"})
      write(std::string("rollouts/") + name + "_s1_validation_0.h5", "fricid.rollout/1",
            {{"/q", kRollout}});
  }

  /// Row k of joint j: base + j + k / 1000.
  static data::RowMatrix ramp(double base) {
    data::RowMatrix values(kRows, kJoints);
    for (int k = 0; k < kRows; ++k)
      for (int j = 0; j < kJoints; ++j) values(k, j) = base + j + k * 1e-3;
    return values;
  }

  /// Changes a JSON file of the folder.
  void edit(const std::string& name, const std::function<void(json&)>& change) const {
    json root = json::parse(read_file(folder / name));
    change(root);
    write_file_atomically(folder / name, root.dump());
  }

  void write(const std::string& name, const std::string& format,
             const std::vector<std::pair<std::string, double>>& tables,
             const std::string& friction = "{}") const {
    data::write_hdf5(folder / name, format, [&](data::H5Writer& file) {
      file.attribute("friction", friction);
      file.vector("/t", Eigen::VectorXd::LinSpaced(kRows, 0, 1), "s");
      for (const auto& [table, base] : tables) file.matrix(table, ramp(base), "");
    });
  }

 private:
  void write_evaluation() const {
    const auto model = [](const char* name, bool is_oracle) {
      return json{{"name", name}, {"label", name}, {"seed", 1}, {"is_oracle", is_oracle}};
    };
    const auto summary = [](const char* name, bool is_oracle, double mse) {
      return json{{"name", name},
                  {"label", name},
                  {"is_oracle", is_oracle},
                  {"is_conventional", !is_oracle},
                  {"q_mse_geometric_mean", {mse, nullptr}},
                  {"ratio_to_oracle", {mse * 1e6, nullptr}},
                  {"headroom_closed", {0, nullptr}},
                  {"rollouts", 4}};
    };
    json simple = model("simple", false);
    for (const double mse : {4.0, 16.0})
      simple["trajectories"].push_back({{"q_mse_joint", {{1, mse}, {1, 1}}}});
    const json evaluation{{"format", "fricid.evaluation/1"},
                          {"scene", "two joints"},
                          {"horizons_s", {1, 10}},
                          {"trajectories", {"validation_0"}},
                          {"models", {model("simulator", true), model("oracle", true), simple}},
                          {"summary",
                           {summary("simulator", true, 1e-6), summary("oracle", true, 1e-6),
                            summary("simple", false, 7e-6)}},
                          {"oracle", {1e-6, nullptr}},
                          {"floor", {2e-6, nullptr}}};
    write_file_atomically(folder / "evaluation.json", evaluation.dump());
  }

  /// A bristle at every joint, as a truth file says it.
  static json friction_json() {
    json parameters;
    for (const auto& info : friction::parameters_of_law("dahl", 0))
      parameters.push_back({{"symbol", info.symbol}, {"value", info.typical}});
    const json law{
        {"law", "dahl"}, {"elements", 0}, {"modifiers", json::array()}, {"parameters", parameters}};
    const json joint{{"laws", {law}}};
    return {{"joints", {joint, joint}}};
  }

  void write_model() const {
    std::string urdf = "<robot name=\"two\"><link name=\"l0\"/>";
    for (int i = 1; i <= kJoints; ++i)
      urdf += fmt::format(
          "<link name=\"l{0}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" "
          "izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint "
          "name=\"joint_a{0}\" type=\"revolute\"><parent link=\"l{1}\"/><child "
          "link=\"l{0}\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"2\" "
          "effort=\"3\"/></joint>",
          i, i - 1);
    write_file_atomically(folder / "two.urdf", urdf + "</robot>");
    data::ModelFile model{.name = "simple", .label = "simple", .arm = {}};
    model.arm.robot = dynamics::load_urdf(folder / "two.urdf");
    const friction::JointSpec joint{{{.law = "dahl", .elements = 0, .modifiers = {}}}};
    model.arm.friction.model = friction::RobotFriction({joint, joint});
    model.arm.friction.theta = friction::default_theta(model.arm.friction.model);
    data::save_model(model, folder / "models/simple_s1.json");
    write_file_atomically(folder / "fit/simple_s1.json",
                          R"({"outcome": "converged", "usable": true, "parameters": 4})");
  }
};

}  // namespace fricid::render
