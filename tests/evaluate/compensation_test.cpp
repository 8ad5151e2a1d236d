#include "fricid/evaluate/compensation.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "fricid/data/artefact.hpp"
#include "temporary_folder.hpp"

namespace fricid::evaluate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kDt = 0.004;

/// One joint along sin(t) for 2 pi seconds, then 3 s of rest; on its path but for what tests add.
data::LoopSignals loop() {
  const double path = 2 * std::numbers::pi;
  const auto T = static_cast<Eigen::Index>((path + 3) / kDt);
  data::LoopSignals signals;
  signals.joint_names = {"elbow"};
  signals.t = Eigen::VectorXd::LinSpaced(T, 0, static_cast<double>(T - 1) * kDt);
  for (RowMatrix* signal :
       {&signals.q_desired, &signals.v_desired, &signals.q, &signals.v, &signals.tau_feedback})
    signal->setZero(T, 1);
  for (Eigen::Index k = 0; k < T && signals.t[k] < path; ++k) {
    signals.q_desired(k, 0) = std::sin(signals.t[k]);
    signals.v_desired(k, 0) = signals.v(k, 0) = std::cos(signals.t[k]);
  }
  signals.q = signals.q_desired;
  return signals;
}

// The velocity cos(t) changes its sign at pi / 2 and 3 pi / 2.
TEST(Compensation, ErrorsAreOfReversalsOrOfTheRestOfThePath) {
  data::LoopSignals signals = loop();
  for (Eigen::Index k = 0; k < signals.t.size(); ++k) {
    const double t = signals.t[k];
    const bool after = (t > std::numbers::pi / 2 && t < std::numbers::pi / 2 + 0.2) ||
                       (t > 1.5 * std::numbers::pi && t < 1.5 * std::numbers::pi + 0.2);
    const bool rest = t > 2 * std::numbers::pi;
    signals.q(k, 0) += rest ? 7 : after ? 3e-3 : 1e-3;
  }
  const LoopScore score = score_loop(signals, 2 * std::numbers::pi);
  EXPECT_NEAR(score.reversal_rad[0], 3e-3, 0.05e-3);
  EXPECT_NEAR(score.sliding_rad[0], 1e-3, 0.05e-3);
  EXPECT_NEAR(score.peak_rad_s, 1, 1e-12);
}

// A constant torque against sin(t): the integral of |cos| over the period is 4.
TEST(Compensation, EnergyIsThatOfTheFeedbackOnThePath) {
  data::LoopSignals signals = loop();
  signals.tau_feedback.setConstant(2);
  EXPECT_NEAR(score_loop(signals, 2 * std::numbers::pi).feedback_J, 8, 0.05);
}

TEST(Compensation, ALimitCycleGoesOnAtRest) {
  const auto cycles = [](double amplitude, double decay) {
    data::LoopSignals signals = loop();
    for (Eigen::Index k = 0; k < signals.t.size(); ++k)
      signals.q(k, 0) += amplitude * std::exp(-decay * signals.t[k]) * std::sin(20 * signals.t[k]);
    return score_loop(signals, 2 * std::numbers::pi).limit_cycles;
  };
  EXPECT_THAT(cycles(1e-4, 0), ElementsAre("elbow"));
  EXPECT_THAT(cycles(1e-5, 0), IsEmpty()) << "as small as an encoder step";
  EXPECT_THAT(cycles(1e-2, 1), IsEmpty()) << "it decays";
}

CompensationFile two_models() {
  const auto score = [](const char* model, int controller, double gain, double error) {
    LoopScore loop;
    loop.model = loop.label = model;
    loop.gain = gain;
    loop.controller = controller;
    loop.reversal_rad = loop.sliding_rad = {error};
    loop.bandwidth_hz = 2 + 6 * controller;
    return loop;
  };
  return {"reference",
          10,
          {score("none", 0, 0, 8e-3), score("lvm", 0, 1, 1e-3), score("lvm", 0, 1.1, 2e-3),
           score("none", 1, 0, 4e-3), score("lvm", 1, 1, 2e-3)}};
}

TEST(Compensation, RatiosAreMeansOverTheLoopsOfBoth) {
  const CompensationFile file = two_models();
  EXPECT_NEAR(reversal_ratio(file, "lvm", 1, "none"), std::sqrt(1 / 8.0 * 2 / 4.0), 1e-12);
  EXPECT_NEAR(reversal_ratio(file, "lvm", 1.1, "none"), 2 / 8.0, 1e-12);
  EXPECT_TRUE(std::isnan(reversal_ratio(file, "lvm", 1, "truth")));
}

TEST(Compensation, TheTableHasARowPerModel) {
  const std::string text = to_markdown(two_models());
  EXPECT_THAT(text, HasSubstr("| none "));
  EXPECT_THAT(text, HasSubstr("| lvm "));
  EXPECT_THAT(text, HasSubstr("limit cycle, gain 1.1"));
}

TEST(Compensation, TablesShowEveryGain) {
  CompensationFile file = two_models();
  file.loops[2].feedback_J = 77;
  const std::string text = to_markdown(file);
  EXPECT_THAT(text, HasSubstr("gain 1 and 1.1."));
  for (const char* title : {"RMS at reversals [mrad]", "RMS in sliding [mrad]",
                            "energy of the feedback [J]", "joints in a limit cycle"})
    for (const char* gain : {", gain 1 ", ", gain 1.1 "})
      EXPECT_THAT(text, HasSubstr(std::string("| ") + title + gain));
  EXPECT_THAT(text, HasSubstr("77"));

  std::erase_if(file.loops, [](const LoopScore& loop) { return loop.gain == 1.1; });
  EXPECT_THAT(to_markdown(file), HasSubstr("| RMS at reversals [mrad] |"));
}

class CompensationOnDisk : public TemporaryFolder {};

TEST_F(CompensationOnDisk, IsReadAsWritten) {
  const auto file = folder / "compensation.json";
  data::save(two_models(), file);
  EXPECT_EQ(data::to_json(data::load<CompensationFile>(file)), data::to_json(two_models()));
}

}  // namespace
}  // namespace fricid::evaluate
