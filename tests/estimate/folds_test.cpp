// What fits leave out in turn, and which of them held-out data choose.
#include "fricid/estimate/torque/folds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "arm_data.hpp"
#include "fricid/estimate/time_blocks.hpp"
#include "fricid/estimate/torque/by_period.hpp"
#include "fricid/estimate/torque/candidate.hpp"
#include "fricid/signals/periods.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {
namespace {

std::vector<signals::Recording> recordings_of(const std::vector<int>& lengths) {
  std::vector<signals::Recording> made(lengths.size());
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    made[i].dt = 0.1;
    made[i].held_tau.setZero(lengths[i], 1);
    made[i].use.setConstant(lengths[i], 1, true);
    made[i].narrow.q = RowMatrix::Random(lengths[i], 1);  // each another motion
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

// make_log's reference repeats after 12 s: three periods and what is left over.
TEST(ByPeriod, CutsAMotionThatRepeats) {
  const Arm arm = coulomb_arm(5e-3);
  std::vector<signals::Recording> whole{
      signals::make_recording(make_log(arm, {.seconds = 40}), 10),
      signals::make_recording(make_log(arm, {.seconds = 12, .seed = 2}), 10)};
  signals::mark_repeats(whole, 1);
  const ByPeriod cut = by_period(whole);
  EXPECT_NEAR(cut.longest_s, 12, 0.01);
  ASSERT_EQ(cut.recordings.size(), 4u);
  for (std::size_t i = 0; i < 3; ++i) {
    const signals::Recording& part = cut.recordings[i];
    const Origin origin = cut.origins[i];
    EXPECT_EQ(origin.recording, 0);
    EXPECT_EQ(origin.begin, static_cast<int>(i) * part.length());
    EXPECT_EQ(part.wide.v, whole[0].wide.v.middleRows(origin.begin, part.length()));
    EXPECT_EQ(part.log.q, whole[0].log.q.middleRows(origin.begin, part.length()));
    EXPECT_FALSE(part.use.row(0).any());  // friction has a state that is not known
  }
  EXPECT_EQ(cut.recordings[3].length(), whole[1].length());

  // of two motions, each fold leaves one out in all its periods
  const std::vector<Fold> folds = folds_of(cut.recordings);
  ASSERT_EQ(folds.size(), 2u);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(folds[0].left_out_of(i) && !folds[1].left_out_of(i));
  // of a single one, the same phase of all its periods
  const std::vector<Fold> of_one = folds_of(std::span(cut.recordings).first(3));
  ASSERT_EQ(of_one.size(), 5u);
  const int length = cut.recordings[0].length();
  for (int k = 0; k < 5; ++k)
    for (int i = 0; i < 3; ++i) {
      const auto out = of_one[static_cast<std::size_t>(k)].left_out_of(i);
      ASSERT_TRUE(out);
      EXPECT_EQ(out->begin, k * length / 5);
      EXPECT_EQ(out->end, (k + 1) * length / 5);
    }
}

// Periods of a recording, its last cut off, and recordings that repeat it.
TEST(TimeBlocks, OfOneStretchOfAMotionAreOnePassage) {
  std::vector<signals::Recording> recordings = recordings_of({75, 30, 30, 30});
  recordings[0].period = 30;
  for (std::size_t i = 0; i < 3; ++i) recordings[i].motion_number = 0;
  recordings[3].motion_number = 1;
  const TimeBlocks time(recordings, 1);  // ten samples
  int last = -1;
  for (std::size_t s = 0; s < recordings.size(); ++s)
    for (int k = 0; k < recordings[s].length(); ++k) {
      EXPECT_GE(time.of(s, k), last);
      last = time.of(s, k);
      EXPECT_EQ(time.passage_of(s, k), (s == 3 ? 3 : 0) + k % 30 / 10) << s << " " << k;
    }
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

// A torque two percent less is none less; of as many parameters the better rollouts count.
TEST(Choose, TheSimplerOfTwoThatAreAlikeIsTaken) {
  Candidate sum = dozen({-9, -11, -10, -10}, -8, 1),
            law = dozen({-8.9, -11.1, -9.9, -10}, -8, 1.02),
            refined = dozen({-8.95, -11.05, -9.95, -10}, -8, 1.01);
  sum.parameters = 60, law.parameters = refined.parameters = 20;
  EXPECT_EQ(choose(std::vector{sum, law}), 1u);
  EXPECT_EQ(choose(std::vector{sum, law, refined}), 2u);
  law.torque = 1.1;
  EXPECT_EQ(choose(std::vector{sum, law}), 0u);
}

// Three rollouts cannot tell a factor of two from chance.
TEST(Choose, RolloutsAndTorqueDecideWhereRolloutsAreFew) {
  const Candidate best = candidate({-9, -11, -10}, -8, 2);
  const Candidate near = candidate({-8.3, -10.3, -9.3}, -7.3, 0.9);
  const Candidate far = candidate({-7.5, -9.5, -8.5}, -6.5, 0.6);
  EXPECT_EQ(choose(std::vector{best, near, far}), 1u);
  EXPECT_EQ(choose(std::vector{best, candidate({-8.3, -10.3, -9.3}, -7.3, 1.1)}), 0u);
}

// Of laws that leave about the same torque the simplest stands for them, whichever rollouts are
// better by chance.
TEST(Choose, TheSimplestLawStandsForThemWhereRolloutsAreFew) {
  Candidate lugre = candidate({-9, -11, -10}, -8, 1.05),
            gms = candidate({-9.5, -11.5, -10.5}, -8.5, 1);
  lugre.rival = gms.rival = true;
  lugre.parameters = 30, gms.parameters = 66;
  EXPECT_EQ(choose(std::vector{lugre, gms}), 0u);
  lugre.torque = 1.1;
  EXPECT_EQ(choose(std::vector{lugre, gms}), 1u);
  lugre.torque = 1.05;
  Candidate sum = candidate({-9.2, -11.2, -10.2}, -8.2, 0.95);
  sum.parameters = 120;
  EXPECT_EQ(choose(std::vector{sum, lugre, gms}), 0u);
  sum.torque = 1.4;
  EXPECT_EQ(choose(std::vector{sum, lugre, gms}), 1u);
}

// Good rollouts of a law that leaves four times the torque of another are chance.
TEST(Choose, RolloutsOfALawThatLeavesTheTorqueDoNotCount) {
  const Candidate chance = candidate({-9, -11, -10}, -8, 9), sum = candidate({-7, -9, -8}, -6, 1),
                  law = candidate({-7.2, -9.2, -8.2}, -6.2, 1.05);
  EXPECT_EQ(choose(std::vector{chance, sum, law}), 2u);
  EXPECT_EQ(eligible(std::vector{chance, sum, law}), (std::vector{false, true, true}));
  const Candidate fell = candidate({-7, -9, 0}, -6, 1);  // the one that explains the torque
  EXPECT_EQ(choose(std::vector{chance, fell}), 0u);
  Candidate departed = candidate({-7, -9, -8}, -6, 1);
  departed.rollouts.whole = {0, -6};  // at full length, once
  EXPECT_EQ(choose(std::vector{chance, departed}), 1u);
}

// Networks need not roll better than a law that leaves four times their torque.
TEST(Choose, SomeExplainFarMore) {
  const Candidate law = dozen({-9, -11, -10, -10}, -8, 9),
                  net = dozen({-9.2, -10.8, -10, -10}, -8, 1);
  EXPECT_TRUE(explains_far_more(net, law));
  EXPECT_FALSE(explains_far_more(law, net));
  EXPECT_FALSE(explains_far_more(dozen({-7, -9, -8, -8}, -6, 1), law));
  EXPECT_FALSE(explains_far_more(dozen({-9.2, -10.8, -10, -10}, -8, 3), law));
  EXPECT_FALSE(explains_far_more(dozen({-9.2, -12.8, -12, 0}, -8, 1), law));  // fell
}

// A torque of no use for rollouts is no measure for that of others.
TEST(Choose, TheTorqueOfALawWithoutRolloutsDoesNotCount) {
  const Candidate sum = candidate({-4, -5, -5}, -3, 1), law = candidate({-9, -11, -10}, -8, 9),
                  linear = candidate({-7.5, -9.5, -8.5}, -6.5, 4);
  EXPECT_EQ(choose(std::vector{sum, law, linear}), 1u);
  EXPECT_EQ(eligible(std::vector{sum, law}), (std::vector{false, true}));
}

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
