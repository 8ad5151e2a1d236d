#include "fricid/evaluate/contact.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/not_finite.hpp"
#include "fricid/evaluate/compensation.hpp"
#include "fricid/evaluate/reversals.hpp"
#include "fricid/evaluate/statistics.hpp"
#include "markdown.hpp"

namespace fricid::evaluate {
namespace {

/// Value that a share of the sorted values does not exceed.
double least_not_exceeded(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return kNan;
  const auto i = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(i, 1, sorted.size()) - 1];
}

Markdown milliseconds(double delay) {
  return std::isfinite(delay) ? Markdown::of("{:.0f}", 1e3 * delay) : Markdown::of("missed");
}

}  // namespace

void QuietTorque::add(ConstRowMatrix tau_ext, double rate_hz) {
  const Eigen::Index second = std::lround(rate_hz);
  if (squares_.size() == 0) squares_.setZero(tau_ext.cols());
  for (Eigen::Index k = 0; k + second <= tau_ext.rows(); k += second) {
    const auto block = tau_ext.middleRows(k, second);
    peaks_.emplace_back(block.cwiseAbs().colwise().maxCoeff());
    squares_ += block.cwiseAbs2().colwise().sum().transpose();
    samples_ += static_cast<double>(second);
  }
}

void QuietTorque::add(const QuietTorque& other) {
  if (squares_.size() == 0) squares_.setZero(other.squares_.size());
  peaks_.insert(peaks_.end(), other.peaks_.begin(), other.peaks_.end());
  if (other.squares_.size() > 0) squares_ += other.squares_;
  samples_ += other.samples_;
}

Eigen::VectorXd QuietTorque::sd() const { return (squares_ / samples_).cwiseSqrt(); }

double QuietTorque::threshold() const {
  const Eigen::VectorXd scale = sd();
  std::vector<double> s;
  for (const Eigen::VectorXd& peak : peaks_) s.push_back(peak.cwiseQuotient(scale).maxCoeff());
  std::ranges::sort(s, std::greater<>());
  const auto allowed = static_cast<std::size_t>(std::floor(hours() + 1e-9));
  return s.at(std::min(allowed, s.size() - 1));
}

void TorqueErrors::add(ConstRowMatrix estimate, ConstRowMatrix truth, ConstRowMatrix v_desired,
                       double dt) {
  if (squares_.size() == 0) {
    squares_.setZero(estimate.cols(), 3);
    counts_.setZero(estimate.cols(), 3);
  }
  for (Eigen::Index j = 0; j < estimate.cols(); ++j) {
    const std::vector<bool> reversal = after_reversals(v_desired, j, dt);
    for (Eigen::Index k = 0; k < estimate.rows(); ++k) {
      const double error = estimate(k, j) - truth(k, j);
      for (const int regime : {0, reversal[static_cast<std::size_t>(k)] ? 1 : 2}) {
        squares_(j, regime) += error * error;
        counts_(j, regime) += 1;
      }
    }
  }
}

void TorqueErrors::write(ContactScore& score) const {
  const Eigen::MatrixXd rmse = squares_.cwiseQuotient(counts_).cwiseSqrt();
  const auto column = [&](int regime) {
    return std::vector<double>(rmse.col(regime).begin(), rmse.col(regime).end());
  };
  score.rmse_Nm = column(0);
  score.rmse_reversal_Nm = column(1);
  score.rmse_sliding_Nm = column(2);
}

std::vector<double> delays(ConstRowMatrix tau_ext, std::span<const PushSpan> pushes, double rate_hz,
                           std::span<const double> threshold_Nm) {
  const auto alarm = [&](Eigen::Index k) {
    for (Eigen::Index j = 0; j < tau_ext.cols(); ++j)
      if (std::abs(tau_ext(k, j)) > threshold_Nm[static_cast<std::size_t>(j)]) return true;
    return false;
  };
  std::vector<double> found;
  for (const PushSpan& push : pushes) {
    double delay = kInfinity;
    for (int k = push.begin; k < std::min<int>(push.end, static_cast<int>(tau_ext.rows())); ++k)
      if (alarm(k)) {
        delay = (k - push.begin) / rate_hz;
        break;
      }
    found.push_back(delay);
  }
  return found;
}

PushScore score_pushes(double force_N, std::vector<double> delays) {
  std::ranges::sort(delays);
  PushScore score{.force_N = force_N, .pushes = static_cast<int>(delays.size())};
  score.missed =
      static_cast<int>(std::ranges::count_if(delays, [](double d) { return !std::isfinite(d); }));
  score.delay_median_s = least_not_exceeded(delays, 0.5);
  score.delay_90_s = least_not_exceeded(delays, 0.9);
  return score;
}

double mean_threshold(const ContactScore& score) { return geometric_mean(score.threshold_Nm); }

std::string to_markdown(const ContactFile& file) {
  if (file.models.empty()) return {};
  const auto truth = std::ranges::find_if(
      file.models, [](const ContactScore& score) { return score.model == kTruthModel; });
  std::vector<Cells> rows{{Markdown::of("external torque"), Markdown::of("RMSE [N m]"),
                           Markdown::of("at reversals"), Markdown::of("in sliding"),
                           Markdown::of("threshold [N m]"), Markdown::of("/ truth")}};
  for (const PushScore& force : file.models.front().forces) {
    rows[0].push_back(Markdown::of("{:g} N: delay [ms]", force.force_N));
    rows[0].push_back(Markdown::of("90 % [ms]"));
    rows[0].push_back(Markdown::of("missed"));
  }
  for (const ContactScore& score : file.models) {
    const double threshold = mean_threshold(score);
    Cells& row = rows.emplace_back(
        Cells{escaped(score.label), digits(rms(score.rmse_Nm)), digits(rms(score.rmse_reversal_Nm)),
              digits(rms(score.rmse_sliding_Nm)), digits(threshold),
              truth == file.models.end() ? Markdown::of("–")
                                         : digits(threshold / mean_threshold(*truth))});
    for (const PushScore& force : score.forces) {
      row.push_back(milliseconds(force.delay_median_s));
      row.push_back(milliseconds(force.delay_90_s));
      row.push_back(Markdown::of("{}/{}", force.missed, force.pushes));
    }
  }
  return (Markdown::of(
              "External torque by a momentum observer of {:g} Hz with the friction of each model. "
              "RMSE over joints, while pushes come and go. Threshold of one false alarm per hour, "
              "from {:.2g} h without contact: geometric mean over joints. Delay from the begin of "
              "a push to its alarm: median, and nine of ten are faster.\n\n",
              file.bandwidth_hz, file.hours) +
          markdown_table(rows))
      .text();
}

}  // namespace fricid::evaluate
