#include "fricid/evaluate/unexplained.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace fricid::evaluate {
namespace {

constexpr double kWindow_s = 0.5;
constexpr int kFewestSamples = 10;    // of a window
constexpr double kBeyondWorst = 4.5;  // times the worst window of the training data
constexpr double kShare = 0.5;        // of the deviation of the training torque
constexpr double kPushed = 0.4;       // the same for the best judge alone
constexpr double kPoor = 0.5;         // R2
constexpr double kSeveral = 4;        // times the residual of the training data
constexpr double kThroughout = 0.8;   // of a recording

/// Squares of the error of one joint, over the samples with a measured torque.
struct Squares {
  double sum = 0;
  int count = 0;

  void add(double e) {
    if (!std::isfinite(e)) return;
    sum += e * e;
    ++count;
  }
  double rms() const { return std::sqrt(sum / count); }
};

int window_of(const data::Dataset& d) {
  return std::max(kFewestSamples, static_cast<int>(std::lround(kWindow_s / d.dt())));
}

Squares squares_of(const data::Dataset& d, const TorquePrediction& prediction, Eigen::Index j,
                   Eigen::Index begin, Eigen::Index end) {
  Squares squares;
  for (Eigen::Index k = begin; k < end; ++k) squares.add(d.tau(k, j) - prediction.tau(k, j));
  return squares;
}

/// RMS of every whole window; NaN where more than half of the samples are missing.
std::vector<double> windows(const data::Dataset& d, const TorquePrediction& prediction,
                            Eigen::Index j) {
  std::vector<double> rms;
  const int size = window_of(d);
  for (int begin = 0; begin + size <= d.length(); begin += size) {
    const Squares squares = squares_of(d, prediction, j, begin, begin + size);
    rms.push_back(2 * squares.count < size ? std::numeric_limits<double>::quiet_NaN()
                                           : squares.rms());
  }
  return rms;
}

double deviation(std::span<const Trajectory> recordings, Eigen::Index j) {
  double sum = 0, squares = 0;
  int count = 0;
  for (const Trajectory& recording : recordings)
    for (const double tau : recording.data.tau.col(j))
      if (std::isfinite(tau)) {
        sum += tau;
        squares += tau * tau;
        ++count;
      }
  return std::sqrt(std::max(0.0, squares / count - sum / count * sum / count));
}

/// How a judge explains the training torque of one joint.
struct Known {
  double rms = 0, worst = 0;  ///< over all, and of the worst window [N m]
};

Known known_of(std::span<const Trajectory> training, const Judge& judge, Eigen::Index j) {
  Known known;
  Squares all;
  for (std::size_t i = 0; i < training.size(); ++i) {
    const data::Dataset& d = training[i].data;
    const Squares own = squares_of(d, judge.training[i], j, 0, d.length());
    all.sum += own.sum;
    all.count += own.count;
    for (const double rms : windows(d, judge.training[i], j))
      known.worst = std::fmax(known.worst, rms);
  }
  known.rms = all.rms();
  known.worst = std::max(known.worst, known.rms);
  return known;
}

}  // namespace

std::string Unexplained::in_words() const {
  if (!difference.empty()) return difference;
  const std::string size = fmt::format(
      "{:.3g} N m of its torque are unexplained, {:.0f} times the residual on the "
      "training data (R2 {:.2g} of the whole recording)",
      residual, residual / training_residual, r2);
  return throughout ? size : fmt::format("from {:.4g} to {:.4g} s {}", begin_s, end_s, size);
}

namespace {

/// What the judges leave of joint j of a recording; nothing where one of them explains it.
/// @param deviates  the training torque [N m]
std::optional<Unexplained> look_at(const Trajectory& recording, std::size_t i, Eigen::Index j,
                                   double deviates, std::span<const Judge> judges,
                                   std::span<const Known> known) {
  const data::Dataset& d = recording.data;
  const auto joint = static_cast<std::size_t>(j);
  const int size = window_of(d);
  std::vector<bool> strange(static_cast<std::size_t>(d.length() / size), true);
  bool poor = true;
  std::size_t best = 0;  // judge
  for (std::size_t m = 0; m < judges.size(); ++m) {
    const TorquePrediction& prediction = judges[m].held_out[i];
    const double rms = squares_of(d, prediction, j, 0, d.length()).rms();
    poor = poor && prediction.r2[joint] < kPoor && rms > kSeveral * known[m].rms;
    if (prediction.r2[joint] > judges[best].held_out[i].r2[joint]) best = m;
    const std::vector<double> in_windows = windows(d, prediction, j);
    for (std::size_t w = 0; w < strange.size(); ++w)
      strange[w] =
          strange[w] && in_windows[w] > std::max(kBeyondWorst * known[m].worst, kShare * deviates);
  }
  const std::vector<double> of_best = windows(d, judges[best].held_out[i], j);
  for (std::size_t w = 0; w < strange.size(); ++w)
    strange[w] =
        strange[w] || of_best[w] > std::max(kBeyondWorst * known[best].worst, kPushed * deviates);
  const auto first = std::ranges::find(strange, true);
  if (first == strange.end() && !poor) return std::nullopt;

  const TorquePrediction& prediction = judges[best].held_out[i];
  Eigen::Index begin = 0, end = d.length();
  Squares there = squares_of(d, prediction, j, begin, end);
  if (first != strange.end()) {
    const auto last = std::find(strange.rbegin(), strange.rend(), true);
    begin = size * (first - strange.begin());
    end = size * (strange.rend() - last);
    there = {};
    for (Eigen::Index k = begin; k < end; ++k)
      if (strange[static_cast<std::size_t>(k / size)])
        there.add(d.tau(k, j) - prediction.tau(k, j));
  }
  const bool throughout =
      static_cast<double>(end - begin) > kThroughout * static_cast<double>(d.length());
  return Unexplained{.recording = d.name,
                     .joint = d.joint_names[joint],
                     .difference = {},
                     .throughout = throughout,
                     .begin_s = d.t[begin],
                     .end_s = d.t[end - 1],
                     .r2 = prediction.r2[joint],
                     .residual = there.rms(),
                     .training_residual = known[best].rms};
}

}  // namespace

std::vector<Unexplained> find_unexplained(std::span<const Trajectory> held_out,
                                          std::span<const Trajectory> training,
                                          std::span<const Judge> judges) {
  std::vector<Unexplained> found;
  if (judges.empty() || training.empty() || held_out.empty()) return found;
  const int n = held_out.front().data.n();
  std::vector<std::vector<Known>> known(static_cast<std::size_t>(n));  // [joint][judge]
  std::vector<double> deviates;
  for (int j = 0; j < n; ++j) {
    for (const Judge& judge : judges)
      known[static_cast<std::size_t>(j)].push_back(known_of(training, judge, j));
    deviates.push_back(deviation(training, j));
  }
  for (std::size_t i = 0; i < held_out.size(); ++i)
    for (int j = 0; j < n; ++j) {
      const auto at = static_cast<std::size_t>(j);
      if (auto torque = look_at(held_out[i], i, j, deviates[at], judges, known[at]))
        found.push_back(*std::move(torque));
    }
  return found;
}

}  // namespace fricid::evaluate
