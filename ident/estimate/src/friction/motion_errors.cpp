#include "fricid/estimate/friction/motion_errors.hpp"

#include "fricid/base/parallel.hpp"

namespace fricid::estimate {
namespace {

constexpr int kSteps = 4;       // of friction in a sample, between them
constexpr double kShown = 0.5;  // share of the error that the two variants show

}  // namespace

MotionErrors::MotionErrors(std::span<const signals::Recording> recordings, double cutoff_hz,
                           int jobs)
    : recordings_(recordings), again_(recordings.size()), cutoff_hz_(cutoff_hz) {
  parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    again_[s] = signals::filtered_again(recordings[s], cutoff_hz);
  });
}

Eigen::VectorXd MotionErrors::of(const JointFrictionData& data, int joint,
                                 const friction::RobotFriction& friction,
                                 std::span<const double> theta,
                                 std::span<const std::vector<int>> row) const {
  const auto predict = [&](const FrictionDrive& how) {
    JointFrictionData variant(recordings_, {}, joint, cutoff_hz_, {}, {}, how);
    variant.begin_springs_at(data.springs());
    return variant.predict(friction, theta);
  };
  const PerSample again = predict({.steps = 1, .motion = again_}),
                  between = predict({.steps = kSteps});
  Eigen::Index rows = 0;
  for (const std::vector<int>& samples : row) rows += std::ssize(samples);
  Eigen::VectorXd errors(rows);
  Eigen::Index r = 0;
  for (std::size_t s = 0; s < row.size(); ++s)
    for (const int sample : row[s]) {
      const auto k = static_cast<std::size_t>(sample);
      errors[r++] = (between[s][k] - again[s][k]) / kShown;
    }
  return errors;
}

}  // namespace fricid::estimate
