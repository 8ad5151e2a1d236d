#include "fricid/render/figures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"
#include "fricid/data/estimate_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/render/palette.hpp"
#include "fricid/sim/excitation_file.hpp"
#include "run_folder_fixture.hpp"

namespace fricid::render {
namespace {

/// Its figures by name.
class FiguresOfRun : public RunToDraw {
 protected:
  Figure figure(const std::string& name) const {
    for (Figure& figure : figures_of_run(run))
      if (figure.name == name) return figure;
    ADD_FAILURE() << "no figure " << name;
    return {};
  }
};

TEST_F(FiguresOfRun, AreThoseOfTheHeader) {
  std::vector<std::string> names;
  for (const Figure& figure : figures_of_run(run)) names.push_back(figure.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{
                "error_time", "error_horizon", "error_joint", "tracking", "friction_joint_a1",
                "friction_joint_a2", "presliding", "friction_time", "friction_error", "latent",
                "parameters", "residual_spectrum", "torque_drift", "excitation", "torque_simple"}));
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

TEST_F(FiguresOfRun, JointsThatSlideHaveMetresAndNewtons) {
  let_slide(1);
  const std::vector<Panel> tracking = figure("tracking").panels;
  EXPECT_EQ(tracking[0].y_label, "q [rad]");
  EXPECT_EQ(tracking[1].y_label, "q [m]");
  const Panel friction = figure("friction_joint_a2").panels[0];
  EXPECT_EQ(friction.x_label, "v [m/s]");
  EXPECT_EQ(friction.y_label, "friction [N]");
  EXPECT_EQ(figure("friction_joint_a1").panels[0].y_label, "friction [N m]");
  EXPECT_EQ(figure("presliding").panels[1].x_label, "displacement [mm]");
  EXPECT_EQ(figure("residual_spectrum").panels[1].y_label, "density [N²/Hz]");
}

// Only a model with a band has the figure; both are drawn less the measurement.
TEST_F(FiguresOfRun, BandsShowTheBestModelAroundTheMeasurement) {
  evaluate::save_band({ramp(kMeasured - 1), ramp(kMeasured + 3)}, trajectory.data, simple.model,
                      run.band(simple.model, kTrajectory));
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    evaluation.summary[2].q_mse_geometric_mean = {1e-6, 2e-6};
    evaluation.summary[2].band_coverage = {0.5, 0.875};
  });
  const Figure bands = figure("bands");
  ASSERT_EQ(bands.panels.size(), 2u);
  const auto& series = bands.panels[1].series;
  ASSERT_EQ(series.size(), 3u);
  EXPECT_NEAR(series[0].low[5], -1, 1e-12);
  EXPECT_NEAR(series[0].high[5], 3, 1e-12);
  EXPECT_EQ(series[1].label, "measured");
  EXPECT_EQ(series[1].y, std::vector<double>(kRows, 0.0));
  EXPECT_NEAR(series[2].y[5], kRollout - kMeasured, 1e-12);
  EXPECT_NE(bands.caption.find("88 %"), std::string::npos) << bands.caption;
}

TEST_F(FiguresOfRun, EveryModelIsShownHoweverMany) {
  constexpr int kModels = 10;
  edit_evaluation([&](evaluate::Evaluation& evaluation) {
    for (int m = 1; m < kModels; ++m) {
      const std::string name = fmt::format("simple{}", m);
      evaluation.models.push_back(evaluation.models[2]);
      evaluation.summary.push_back(evaluation.summary[2]);
      evaluation.models.back().name = evaluation.models.back().label = name;
      evaluation.summary.back().name = evaluation.summary.back().label = name;
    }
  });
  for (int m = 1; m < kModels; ++m) {
    const workflow::FitId id{fmt::format("simple{}", m), 1};
    std::filesystem::copy_file(run.model(simple), run.model(id));
    std::filesystem::copy_file(run.prediction(simple, kTrajectory),
                               run.prediction(id, kTrajectory));
    std::filesystem::copy_file(run.rollout(simple, kTrajectory), run.rollout(id, kTrajectory));
  }

  const auto models_in = [](const Panel& panel) {
    return std::count_if(panel.series.begin(), panel.series.end(),
                         [](const Series& series) { return series.label.starts_with("simple"); });
  };
  for (const char* name :
       {"error_time", "error_horizon", "error_joint", "tracking", "presliding", "friction_time",
        "friction_error", "parameters", "residual_spectrum", "torque_drift"}) {
    SCOPED_TRACE(name);
    const Figure shared = figure(name);
    for (const Panel& panel : shared.panels) EXPECT_EQ(models_in(panel), kModels) << panel.title;
    EXPECT_EQ(shared.width_cm, Figure().width_cm);
    EXPECT_LE(shared.columns, 2);
  }
  EXPECT_EQ(figure("friction_joint_a1").panels.size(), kModels);
  EXPECT_EQ(figure("latent").panels.size(), 1 + kModels);
}

TEST_F(FiguresOfRun, CoulombAndViscousFrictionIsTheReferenceOfTheOthers) {
  edit_evaluation([&](evaluate::Evaluation& evaluation) {
    add_model(evaluation, "plain", false, {1e-6, 2e-6});
  });
  const workflow::FitId plain{"plain", 1};
  data::ModelFile model = data::load_model(run.model(simple));
  friction::Friction& friction = model.arm.friction;
  friction.model =
      friction::RobotFriction(std::vector<friction::JointSpec>(2, {{{"coulomb_viscous", 0, {}}}}));
  friction.theta = friction::default_theta(friction.model);
  data::save_model(model, run.model(plain));
  std::filesystem::copy_file(run.prediction(simple, kTrajectory),
                             run.prediction(plain, kTrajectory));
  const Figure shown = figure("friction_joint_a1");
  ASSERT_EQ(shown.panels.size(), 1u);
  EXPECT_EQ(shown.panels[0].title, "joint_a1, simple");
  EXPECT_EQ(shown.panels[0].series.back().label, "plain");
  EXPECT_NE(shown.caption.find("plain"), std::string::npos) << shown.caption;
}

TEST_F(FiguresOfRun, LatentStatesHaveTheUnitOfTheirLaw) {
  for (const Panel& panel : figure("latent").panels) EXPECT_EQ(panel.y_label, "z [rad]");
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
  EXPECT_EQ(series[0].y[0], 2e-6);
  EXPECT_EQ(series[1].label, "oracle");
  EXPECT_EQ(series[2].y[0], 7e-6);
  EXPECT_TRUE(std::isnan(series[2].y[1]));
}

TEST_F(FiguresOfRun, ErrorOfAJointIsTheRootOfTheGeometricMean) {
  const Figure joints = figure("error_joint");
  ASSERT_EQ(joints.panels.size(), 2u);  // 1 s and the longest horizon
  const Series& bars = joints.panels[0].series.at(0);
  ASSERT_EQ(bars.y.size(), 2u);
  EXPECT_NEAR(bars.y[1], std::sqrt(std::sqrt(4.0 * 16.0)), 1e-12);
  EXPECT_NEAR(bars.low[1], 2, 1e-12);
  EXPECT_NEAR(bars.high[1], 4, 1e-12);
}

TEST_F(FiguresOfRun, ErrorOverTimeIsTheMeanOverJoints) {
  const auto series = figure("error_time").panels.at(0).series;
  ASSERT_EQ(series.size(), 2u);
  EXPECT_NEAR(series[1].y[0], kRollout - kMeasured, 1e-12);
}

TEST_F(FiguresOfRun, PreslidingLoopsOfTheTrueLawLieOnTheTruth) {
  // The fitted law is the injected one, with its parameters.
  const auto series = figure("presliding").panels.at(1).series;
  ASSERT_EQ(series.size(), 2u);
  EXPECT_EQ(series[0].label, "truth");
  EXPECT_EQ(series[0].y, series[1].y);
  // Outer loop: the torque at the turn up differs from that at the turn down by twice its height.
  const auto [least, most] = std::minmax_element(series[1].y.begin(), series[1].y.end());
  EXPECT_NEAR(*least, -*most, 0.05 * *most);
  EXPECT_GT(*most, 0);
}

TEST_F(FiguresOfRun, SlowestReversalIsZoomedInto) {
  // Joint j: velocity crosses zero at 0.5 s steeply and at 1.5 s ten times less so.
  constexpr int kSamples = 500;
  data::RowMatrix v(kSamples, kJoints), none = data::RowMatrix::Zero(kSamples, kJoints);
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(kSamples, 0, (kSamples - 1) / 250.0);
  for (int k = 0; k < kSamples; ++k)
    v.row(k).setConstant(t[k] < 1 ? 20 * (0.502 - t[k]) : 2 * (t[k] - 1.502));
  data::Dataset shorter;
  shorter.joint_names = trajectory.data.joint_names;
  shorter.t = t;
  shorter.tau = none;
  evaluate::TorquePrediction prediction;
  prediction.tau = prediction.tau_f = none;
  evaluate::save_prediction(prediction, shorter, none, v, run.prediction(simple, kTrajectory));
  const Figure zoom = figure("reversal");
  ASSERT_EQ(zoom.panels.size(), 2u);
  EXPECT_EQ(zoom.panels[0].title, "joint_a1, t = 1.50 s");
  const auto& x = zoom.panels[0].series.back().x;
  EXPECT_NEAR(x.front(), -150, 4.1);
  EXPECT_NEAR(x.back(), 150, 4.1);
}

TEST_F(FiguresOfRun, BandOfTheOnlineFilterHoldsNinetyPercent) {
  data::EstimateSignals estimate;
  estimate.t = Eigen::VectorXd::LinSpaced(kRows, 0, 16);
  estimate.ess = estimate.log_likelihood = 100 * estimate.t;
  estimate.q = estimate.v = estimate.tau_f = ramp(5);
  estimate.q_sd = estimate.v_sd = estimate.tau_f_sd = ramp(1);
  data::save_signals(estimate, run.estimate(simple, kTrajectory));
  // a band of 200 bins, each of 20 samples, and its median
  const std::vector<Series> particles = figure("filter_health").panels.at(0).series;
  ASSERT_EQ(particles.size(), 2u);
  EXPECT_EQ(particles[0].low.front(), 0);
  EXPECT_EQ(particles[0].high.back(), 1600);
  ASSERT_EQ(particles[1].y.size(), 200u);
  EXPECT_NEAR(particles[1].y.front(), 1600 * 10 / 3999.0, 1e-9);
  const Series band = figure("friction_time").panels.at(0).series.at(0);
  EXPECT_EQ(band.mark, Mark::kBand);
  EXPECT_NEAR(band.low[0], 5 - 1.645, 1e-12);
  EXPECT_NEAR(band.high[0], 5 + 1.645, 1e-12);
}

// A part of a log keeps its times: the first seconds are those after its first sample.
TEST_F(FiguresOfRun, FrictionOverTimeBeginsWithTheRecording) {
  data::Dataset later = trajectory.data;
  later.t.array() += 18;
  evaluate::TorquePrediction prediction;
  prediction.tau = prediction.tau_f = later.q;
  evaluate::save_prediction(prediction, later, later.q, later.q,
                            run.prediction(simple, kTrajectory));
  for (const Panel& panel : figure("friction_time").panels)
    EXPECT_EQ(panel.series.back().x.front(), 18) << panel.title;
}

TEST_F(FiguresOfRun, ErrorOfFrictionIsAgainstTheTruth) {
  EXPECT_NEAR(figure("friction_error").panels.at(1).series.at(0).y[0], kPredicted - kTruth, 1e-12);
}

TEST_F(FiguresOfRun, ParametersStandBesideTheirTruth) {
  const Figure parameters = figure("parameters");
  const auto panel = std::find_if(parameters.panels.begin(), parameters.panels.end(),
                                  [](const Panel& candidate) { return candidate.title == "Fc"; });
  ASSERT_NE(panel, parameters.panels.end());
  ASSERT_EQ(panel->series.size(), 2u);
  EXPECT_EQ(panel->series[1].label, "truth");
  EXPECT_EQ(panel->series[0].y, panel->series[1].y);
}

TEST_F(FiguresOfRun, CorrelationLeavesOutWhatHasNone) {
  edit_fit([](data::FitFile& fit) {
    for (data::FittedJoint& joint : fit.joints) {
      joint.parameters = {{"Fc"}, {"sigma0"}, {"Fv"}};
      joint.correlation.resize(3, 3);
      joint.correlation << 1, kNotKnown, -0.95, kNotKnown, kNotKnown, kNotKnown, -0.95, kNotKnown,
          1;
    }
  });
  const Panel panel = figure("correlation_simple").panels.at(1);
  EXPECT_EQ(panel.x_tics.size(), 2u);
  EXPECT_EQ(panel.x_tics[1].second, "Fv");
  EXPECT_EQ(panel.series.at(0).low, (std::vector<double>{1, -0.95, -0.95, 1}));
  EXPECT_TRUE(panel.series.at(1).x.empty());
  // two bold minus signs: one stroke each
  const Series& bold = panel.series.at(2);
  ASSERT_EQ(bold.x.size(), 2u);
  EXPECT_DOUBLE_EQ(bold.x[0] + bold.low[0] / 2, 1);
  EXPECT_DOUBLE_EQ(bold.x[1] + bold.low[1] / 2, 0);
  EXPECT_EQ(bold.high[0], 0);
}

TEST_F(FiguresOfRun, CorrelationsHaveTheirSign) {
  edit_fit([](data::FitFile& fit) {
    fit.joints[0].parameters = {{"Fc"}, {"Fs"}, {"Fv"}};
    fit.joints[0].correlation.resize(3, 3);
    fit.joints[0].correlation << 1, 0.6, 0.3, 0.6, 1, -0.7, 0.3, -0.7, 1;
  });
  const Panel panel = figure("correlation_simple").panels.at(0);
  EXPECT_EQ(panel.series.at(1).x.size(), 2u * (2 + 1));  // two plus and two minus signs
  EXPECT_TRUE(panel.series.at(2).x.empty());
}

// Twentieths of measured less predicted: the fixture's difference is constant.
TEST_F(FiguresOfRun, DriftIsWhatThePredictionLeaves) {
  const Series series = figure("torque_drift").panels.at(1).series.at(0);
  ASSERT_EQ(series.y.size(), 20u);
  for (const double left : series.y) EXPECT_NEAR(left, kMeasured - kPredicted, 1e-9);
}

TEST_F(FiguresOfRun, TrainingShowsWhatChoseTheModel) {
  edit_fit([](data::FitFile& fit) {
    data::FittedEm& em = fit.em.emplace();
    em.held_out_start = 4;
    em.iterations = {{.held_out = 3}, {.held_out = 1}};
  });
  const Figure training = figure("training");
  ASSERT_EQ(training.panels.size(), 1u);
  EXPECT_EQ(training.panels[0].series.at(0).y, (std::vector<double>{4, 3, 1}));
  EXPECT_EQ(training.panels[0].series.at(0).x, (std::vector<double>{0, 50, 100}));
}

TEST_F(FiguresOfRun, EmIsShownByIterationAndParticlesWhereThereAreAny) {
  data::FittedIteration first{.log_likelihood = 10, .nis = 2, .least_roots = 1}, second = first;
  first.objective = 5;
  first.velocity_sd = 0.1;
  second.log_likelihood = 15;
  second.nis = 1;
  edit_fit([&](data::FitFile& fit) { fit.em.emplace().iterations = {first, second}; });
  const auto shown = [&] {
    std::vector<std::vector<double>> y;
    for (const Panel& panel : figure("em").panels) y.push_back(panel.series.at(0).y);
    return y;
  };
  const std::vector<std::vector<double>> kalman{{5, 0}, {0, 0.005}, {0.1, 0}, {2, 1}};
  EXPECT_EQ(shown(), kalman);
  auto fit = data::load<data::FitFile>(run.fit(simple));
  fit.em->iterations[1].least_backward_ess = 7;
  data::save(fit, run.fit(simple));
  std::vector<std::vector<double>> particles = kalman;
  particles.push_back({1, 1});
  particles.push_back({0, 7});
  EXPECT_EQ(shown(), particles);
}

TEST_F(FiguresOfRun, RolloutsAloneAreAModelWithItsOwnColour) {
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    add_model(evaluation, "tool", false, {1e-6, 2e-6});
  });
  std::filesystem::copy(run.rollout(simple, kTrajectory), run.rollout({"tool", 1}, kTrajectory));
  for (const char* name : {"tracking", "error_time", "error_horizon"}) {
    const auto series = figure(name).panels.at(0).series;
    const auto tool = std::find_if(series.begin(), series.end(),
                                   [](const Series& line) { return line.label == "tool"; });
    ASSERT_NE(tool, series.end()) << name;
    EXPECT_EQ(tool->colour, look_of_law("external").colour) << name;
  }
  EXPECT_NE(look_of_law("external").colour, look_of_law("a law of no table").colour);
}

TEST_F(FiguresOfRun, BarsOfParametersAreTwoStandardErrors) {
  const friction::Friction fitted = data::load_model(run.model(simple)).arm.friction;
  edit_fit([&](data::FitFile& fit) {
    for (std::size_t i = 0; i < fitted.theta.size(); ++i) {
      const friction::ParameterRef& parameter = fitted.model.parameters()[i];
      fit.joints[static_cast<std::size_t>(parameter.joint)].parameters.push_back(
          {parameter.symbol, fitted.theta[i], parameter.joint == 0 ? kNotKnown : 0.25});
    }
  });
  const Series bars = figure("parameters").panels.at(0).series.at(0);
  EXPECT_EQ(bars.low[0], bars.y[0]);
  EXPECT_DOUBLE_EQ(bars.y[1] - bars.low[1], 0.5);
  EXPECT_DOUBLE_EQ(bars.high[1] - bars.y[1], 0.5);
}

// The trajectory that leaves the least decides.
TEST_F(FiguresOfRun, MarginsAreOfAllTrajectories) {
  sim::ExcitationFile file;
  for (const double left : {0.5, 0.25}) {
    sim::TrajectoryReport& report = file.trajectories.emplace_back();
    for (const std::string& name : trajectory.data.joint_names) {
      sim::JointMargins& joint = report.joints.emplace_back();
      joint.joint = name;
      joint.velocity = name == "joint_a1" ? left : 1;
    }
  }
  data::save(file, run.excitation());
  const Series velocity = figure("margins").panels.at(0).series.at(0);
  EXPECT_EQ(velocity.label, "velocity");
  EXPECT_EQ(velocity.x, (std::vector<double>{75, 0}));
}

TEST_F(FiguresOfRun, WhatIsAbsentIsLeftOut) {
  std::filesystem::remove(run.truth(kTrajectory));
  EXPECT_EQ(figure("friction_joint_a1").panels.at(0).series.size(), 1u);
  for (const auto& file :
       {run.prediction(simple, kTrajectory), run.model(simple), run.recording(run.training(0))})
    std::filesystem::remove(file);
  EXPECT_EQ(figures_of_run(run).size(), 4u);
  std::filesystem::remove(run.evaluation());
  EXPECT_THROW(figures_of_run(run), UserError);
}

TEST_F(FiguresOfRun, WhatIsNotShownIsAbsent) {
  const workflow::RunFolder visible =
      run.restricted_to({run.name_of(run.evaluation()), run.name_of(run.recording(kTrajectory)),
                         run.name_of(run.rollout(simple, kTrajectory))});
  const std::vector<Figure> figures = figures_of_run(visible);
  ASSERT_EQ(figures.size(), 4u);
  EXPECT_EQ(figures[0].name, "error_time");
  EXPECT_EQ(figures[0].panels.at(0).series.size(), 1u);  // the oracle's rollout is not shown
}

// Signals have a row for each sample of the recording at most.
TEST_F(FiguresOfRun, SignalsOfAnotherRecordingAreRefused) {
  data::Dataset shorter = trajectory.data;
  for (data::RowMatrix* values : {&shorter.q, &shorter.tau})
    *values = values->topRows(kRows / 2).eval();
  shorter.t = shorter.t.head(kRows / 2).eval();
  data::save_dataset(shorter, run.recording(kTrajectory));
  EXPECT_THROW(figures_of_run(run), UserError);
}

}  // namespace
}  // namespace fricid::render
