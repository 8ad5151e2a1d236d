#include "fricid/render/figures.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "temporary_folder.hpp"

namespace fricid::render {
namespace {

using data::RowMatrix;
using nlohmann::json;

constexpr int kRows = 4000, kJoints = 2;

/// Row k of joint j: base + j + k / 1000.
RowMatrix ramp(double base) {
  RowMatrix values(kRows, kJoints);
  for (int k = 0; k < kRows; ++k)
    for (int j = 0; j < kJoints; ++j) values(k, j) = base + j + k * 1e-3;
  return values;
}

/// A run folder with the oracle and one model on one trajectory of two joints.
class FiguresOfRun : public TemporaryFolder {
 protected:
  static constexpr double kTruth = 10, kPredicted = 20, kMeasured = 30, kRollout = 40;

  void SetUp() override {
    TemporaryFolder::SetUp();
    const auto model = [](const char* name, bool is_oracle) {
      return json{{"name", name}, {"label", name}, {"seed", 1}, {"is_oracle", is_oracle}};
    };
    const auto summary = [](const char* name, double mse) {
      return json{{"name", name}, {"q_mse_geometric_mean", {mse, nullptr}}};
    };
    json simple = model("simple", false);
    for (const double mse : {4.0, 16.0})
      simple["trajectories"].push_back({{"q_mse_joint", {{1, 1}, {1, mse}}}});
    const json evaluation{
        {"scene", "two joints"},
        {"horizons_s", {0.1, 1}},
        {"trajectories", {"validation_0"}},
        {"models", {model("simulator", true), model("oracle", true), simple}},
        {"summary", {summary("simulator", 1), summary("oracle", 1), summary("simple", 7)}},
        {"floor", {2, nullptr}}};
    write_file_atomically(folder / "evaluation.json", evaluation.dump());

    data::Dataset measured;
    measured.joint_names = {"joint_a1", "joint_a2"};
    measured.rate_hz = 250;
    measured.t = Eigen::VectorXd::LinSpaced(kRows, 0, (kRows - 1) / measured.rate_hz);
    measured.q = measured.tau = ramp(kMeasured);
    data::save_dataset(measured, folder / "data/validation_0.h5");
    write("truth/validation_0.h5", "fricid.truth/1",
          {{"/v", kTruth}, {"/tau_f", kTruth}, {"/z", 0}}, friction_json().dump());
    write_file_atomically(folder / "models/simple_s1.json",
                          R"({"friction": [[{"law": "coulomb_viscous"}]]})");
    write("predictions/simple_s1_validation_0.h5", "fricid.prediction/1",
          {{"/v", 0}, {"/tau", kMeasured}, {"/tau_predicted", kPredicted}, {"/tau_f", kPredicted}});
    for (const char* name : {"oracle", "simple"})
      write(std::string("rollouts/") + name + "_s1_validation_0.h5", "fricid.rollout/1",
            {{"/q", kRollout}});
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

  void write(const std::string& name, const std::string& format,
             const std::vector<std::pair<std::string, double>>& tables,
             const std::string& friction = "{}") const {
    data::write_hdf5(folder / name, format, [&](data::H5Writer& file) {
      file.attribute("friction", friction);
      file.vector("/t", Eigen::VectorXd::LinSpaced(kRows, 0, 1), "s");
      for (const auto& [table, base] : tables) file.matrix(table, ramp(base), "");
    });
  }

  Figure figure(const std::string& name) const {
    for (Figure& figure : figures_of_run(folder))
      if (figure.name == name) return figure;
    ADD_FAILURE() << "no figure " << name;
    return {};
  }
};

TEST_F(FiguresOfRun, AreThoseOfTheHeader) {
  std::vector<std::string> names;
  for (const Figure& figure : figures_of_run(folder)) names.push_back(figure.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{"error_time", "error_horizon", "error_joint", "tracking",
                                      "friction_joint_a1", "friction_joint_a2", "torque_simple"}));
}

TEST_F(FiguresOfRun, FrictionShowsTheModelOverTheTruthOfItsJoint) {
  const Figure friction = figure("friction_joint_a2");
  ASSERT_EQ(friction.panels.size(), 1u);
  const auto& series = friction.panels[0].series;
  ASSERT_EQ(series.size(), 2u);
  EXPECT_EQ(series[0].label, "truth");
  EXPECT_EQ(series[0].x[0], kTruth + 1);
  EXPECT_EQ(series[0].y[0], kTruth + 1);
  EXPECT_EQ(series[1].label, "simple");
  EXPECT_EQ(series[1].x[0], 1);
  EXPECT_EQ(series[1].y[0], kPredicted + 1);
}

TEST_F(FiguresOfRun, TrackingShowsMeasurementAndModels) {
  const Figure tracking = figure("tracking");
  ASSERT_EQ(tracking.panels.size(), 2u);
  EXPECT_EQ(tracking.panels[1].title, "joint_a2");
  const auto& series = tracking.panels[1].series;
  ASSERT_EQ(series.size(), 2u);  // the oracle would hide the measurement
  EXPECT_EQ(series[0].y[0], kRollout + 1);
  EXPECT_EQ(series[1].y[0], kMeasured + 1);
}

TEST_F(FiguresOfRun, TorqueShowsTheResidual) {
  const auto series = figure("torque_simple").panels.at(0).series;
  ASSERT_EQ(series.size(), 3u);
  EXPECT_EQ(series[0].y[0], kMeasured - kPredicted);
  EXPECT_EQ(series[1].y[0], kMeasured);
  EXPECT_EQ(series[2].y[0], kPredicted);
}

TEST_F(FiguresOfRun, ErrorOverHorizonHasOracleModelsAndFloor) {
  const auto series = figure("error_horizon").panels.at(0).series;
  ASSERT_EQ(series.size(), 3u);
  EXPECT_EQ(series[0].label, "floor");
  EXPECT_EQ(series[0].y[0], 2);
  EXPECT_EQ(series[1].label, "oracle");
  EXPECT_EQ(series[2].y[0], 7);
  EXPECT_TRUE(std::isnan(series[2].y[1]));
}

TEST_F(FiguresOfRun, ErrorOfAJointIsTheRootOfTheGeometricMean) {
  const Figure joints = figure("error_joint");
  ASSERT_EQ(joints.panels.size(), 1u);  // 1 s is the longest horizon
  const Series& simple = joints.panels[0].series.at(0);
  ASSERT_EQ(simple.y.size(), 2u);
  EXPECT_NEAR(simple.y[1], std::sqrt(std::sqrt(4.0 * 16.0)), 1e-12);
  EXPECT_NEAR(simple.low[1], 2, 1e-12);
  EXPECT_NEAR(simple.high[1], 4, 1e-12);
}

TEST_F(FiguresOfRun, ErrorOverTimeIsTheMeanOverJoints) {
  const auto series = figure("error_time").panels.at(0).series;
  ASSERT_EQ(series.size(), 2u);
  EXPECT_NEAR(series[1].y[0], kRollout - kMeasured, 1e-12);
}

TEST_F(FiguresOfRun, WhatIsAbsentIsLeftOut) {
  std::filesystem::remove_all(folder / "truth");
  EXPECT_EQ(figure("friction_joint_a1").panels.at(0).series.size(), 1u);
  std::filesystem::remove_all(folder / "predictions");
  EXPECT_EQ(figures_of_run(folder).size(), 4u);
  std::filesystem::remove(folder / "evaluation.json");
  EXPECT_THROW(figures_of_run(folder), UserError);
}

}  // namespace
}  // namespace fricid::render
