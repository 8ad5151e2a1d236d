// What fits leave out in turn, and which of them held-out data choose.
#include "fricid/estimate/torque/folds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fricid/estimate/torque/candidate.hpp"

namespace fricid::estimate {
namespace {

std::vector<signals::Recording> recordings_of(const std::vector<int>& lengths) {
  std::vector<signals::Recording> made(lengths.size());
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    made[i].dt = 0.1;
    made[i].held_tau.setZero(lengths[i], 1);
    made[i].use.setConstant(lengths[i], 1, true);
  }
  return made;
}

// Every sample is left out once, and no fold fits what it leaves out.
TEST(Folds, LeaveOutEverySampleOnce) {
  for (const std::size_t count : {1u, 2u, 3u, 6u}) {
    const auto recordings = recordings_of(std::vector<int>(count, 253));
    const std::vector<Fold> folds = folds_of(recordings);
    EXPECT_EQ(folds.size(), count == 1 ? 5 : std::min<std::size_t>(count, 4));
    Eigen::Index used = 0;
    for (const Fold& fold : folds) {
      Eigen::Index left_out = 0;
      for (std::size_t i = 0; i < count; ++i)
        if (const auto out = fold.left_out_of(static_cast<int>(i)))
          left_out += out->end - out->begin;
      Eigen::Index fitted = 0;
      for (const signals::Recording& rest : without(fold, recordings)) fitted += rest.use.count();
      EXPECT_EQ(fitted + left_out, 253 * std::ssize(recordings));
      used += fitted;
    }
    EXPECT_EQ(used, 253 * std::ssize(recordings) * (std::ssize(folds) - 1));
  }
  const auto two = recordings_of({250, 90});
  const std::vector<Fold> of_two = folds_of(two);
  for (const Stretch& stretch : of_two[0].left_out)
    EXPECT_EQ(stretch.end - stretch.begin, 125);  // 25 s in stretches of at least 10 s
}

Candidate candidate(std::vector<double> seconds, double whole, double torque) {
  Candidate made;
  made.rollouts = {std::move(seconds), {whole, whole}};
  made.held_out = std::exp(made.rollouts.mean());
  made.torque = torque;
  return made;
}

/// A dozen rollouts of four kinds.
Candidate dozen(const std::vector<double>& four, double whole, double torque) {
  std::vector<double> seconds;
  for (int i = 0; i < 3; ++i) seconds.insert(seconds.end(), four.begin(), four.end());
  return candidate(std::move(seconds), whole, torque);
}

// Rollouts that differ by more than their standard error decide, else the torque does.
TEST(Choose, TheTorqueDecidesBetweenRolloutsThatAreAlike) {
  const Candidate best = dozen({-9, -11, -10, -10}, -8, 2);
  const Candidate alike = dozen({-8.5, -11.5, -9, -10.5}, -8, 1);
  const Candidate worse = dozen({-8, -10, -9, -9}, -7, 0.5);
  EXPECT_NEAR(between(alike.rollouts, best.rollouts).mean, 0.0625, 1e-12);
  EXPECT_NEAR(between(alike.rollouts, best.rollouts).error, std::sqrt(5.0625 / 11 / 12) / 2, 1e-12);
  EXPECT_EQ(between(worse.rollouts, best.rollouts).error, 0);
  EXPECT_EQ(choose(std::vector{worse, best, alike}), 2u);
  EXPECT_EQ(choose(std::vector{worse, best}), 1u);
}

// A torque two percent less is none less.
TEST(Choose, TheSimplerOfTwoThatAreAlikeIsTaken) {
  Candidate sum = dozen({-9, -11, -10, -10}, -8, 1),
            law = dozen({-8.9, -11.1, -9.9, -10}, -8, 1.02);
  sum.parameters = 60, law.parameters = 20;
  EXPECT_EQ(choose(std::vector{sum, law}), 1u);
  law.torque = 1.1;
  EXPECT_EQ(choose(std::vector{sum, law}), 0u);
}

// A network is taken only where it betters the rollouts beyond their standard error.
TEST(Choose, ANetworkHasToBeNeeded) {
  Candidate plain = dozen({-9, -11, -10, -10}, -8, 2);
  Candidate network = dozen({-9.1, -10.9, -10.05, -9.95}, -8, 1);
  for (const auto& [of, law] : {std::pair{&plain, "stribeck"}, {&network, "memory_network"}})
    of->arm.friction.model = friction::RobotFriction({friction::JointSpec{{{law, 1, {}}}}});
  EXPECT_EQ(choose(std::vector{plain, network}), 0u);
  network.rollouts.seconds = dozen({-12, -14.1, -13, -13.1}, -8, 1).rollouts.seconds;
  network.held_out = std::exp(network.rollouts.mean());
  EXPECT_EQ(choose(std::vector{plain, network}), 1u);
}

// Three rollouts cannot tell a factor of two from chance.
TEST(Choose, RolloutsAndTorqueDecideWhereRolloutsAreFew) {
  const Candidate best = candidate({-9, -11, -10}, -8, 2);
  const Candidate near = candidate({-8.3, -10.3, -9.3}, -7.3, 0.9);
  const Candidate far = candidate({-7.5, -9.5, -8.5}, -6.5, 0.1);
  EXPECT_EQ(choose(std::vector{best, near, far}), 1u);
  EXPECT_EQ(choose(std::vector{best, candidate({-8.3, -10.3, -9.3}, -7.3, 1.1)}), 0u);
}

// A law that the sum contains has to be better beyond chance.
TEST(Choose, ARivalHasToBeTwiceAsGoodWhereRolloutsAreFew) {
  const Candidate sum = candidate({-9, -11, -10}, -8, 2);
  Candidate rival = candidate({-8.9, -10.9, -9.9}, -7.9, 1.1);
  EXPECT_EQ(choose(std::vector{sum, rival}), 1u);
  rival.rival = true;
  EXPECT_EQ(choose(std::vector{sum, rival}), 0u);
  rival.torque = 0.9;
  EXPECT_EQ(choose(std::vector{sum, rival}), 1u);
  Candidate better = candidate({-9.1, -11.1, -10.1}, -8.1, 1.9);  // in both
  better.rival = true;
  EXPECT_EQ(choose(std::vector{sum, better}), 1u);
}

// One rollout has no standard error: the torque decides.
TEST(Choose, TheTorqueDecidesWhereThereIsOneRollout) {
  Candidate best = candidate({-10}, -8, 2), other = candidate({-7}, -7, 0.05);
  for (Candidate* one : {&best, &other}) one->rollouts.whole.pop_back();
  EXPECT_EQ(choose(std::vector{best, other}), 1u);
  Candidate fell = candidate({0}, -7, 1);  // log kFallenSquare
  fell.rollouts.whole.pop_back();
  EXPECT_EQ(choose(std::vector{best, fell}), 0u);
  other.held_out = std::numeric_limits<double>::infinity();  // it fell
  EXPECT_EQ(choose(std::vector{best, other}), 0u);
}

}  // namespace
}  // namespace fricid::estimate
