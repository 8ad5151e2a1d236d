#include "fricid/data/dataset.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "check_times.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/data/sample_times.hpp"
#include "fricid/data/signal_file.hpp"
#include "logs/columns.hpp"

namespace fricid::data {
namespace {

constexpr double kDegrees = 4 * std::numbers::pi;  // no joint turns further between its stops

void check_shape(const Dataset& d, const RowMatrix& values, const char* name,
                 const std::string& where) {
  if (values.rows() != d.length() || values.cols() != d.n())
    throw UserError("{}: {} is {} x {}; allowed: {} samples x {} joints", where, name,
                    values.rows(), values.cols(), d.length(), d.n());
}

// NaN marks a missing value; a joint without any value, and infinity, are errors.
void check_values(const Dataset& d, const RowMatrix& values, const char* name,
                  const std::string& where) {
  for (int j = 0; j < d.n(); ++j) {
    bool any = false;
    for (int k = 0; k < d.length(); ++k) {
      const double value = values(k, j);
      any = any || !std::isnan(value);
      if (std::isinf(value))
        throw UserError("{}: sample {}: {} of {} = {}; allowed: finite, or nan where missing",
                        where, k, name, d.joint_names[static_cast<std::size_t>(j)], value);
    }
    if (!any)
      throw UserError("{}: {} of {} has no value at all", where, name,
                      d.joint_names[static_cast<std::size_t>(j)]);
  }
}

// Smallest step of a position that is logged in coarse steps, else 0. Such a position stands still
// between its steps; friction before sliding needs a tenth of a milliradian.
double coarse_step(const Eigen::VectorXd& q) {
  constexpr double kCoarse = 1e-4, kStanding = 0.05;
  double smallest = 0;
  Eigen::Index standing = 0;
  for (Eigen::Index k = 1; k < q.size(); ++k) {
    const double step = std::abs(q[k] - q[k - 1]);
    if (step == 0) ++standing;
    if (step > 0 && (smallest == 0 || step < smallest)) smallest = step;
  }
  const bool stands = static_cast<double>(standing) > kStanding * static_cast<double>(q.size());
  return stands && smallest > kCoarse ? smallest : 0;
}

}  // namespace

void check_times(const Eigen::VectorXd& t, double rate_hz,
                 const std::function<std::string(int)>& place) {
  const double period = 1 / rate_hz;
  for (int k = 0; k < static_cast<int>(t.size()); ++k) {
    if (!std::isfinite(t[k])) throw UserError("{}: t = {}; allowed: a finite time", place(k), t[k]);
    if (k == 0) continue;
    const double dt = t[k] - t[k - 1];
    if (dt <= 0)
      throw UserError("{}: t = {:.9g} s after {:.9g} s; allowed: rising times", place(k), t[k],
                      t[k - 1]);
    if (!is_one_period(dt, rate_hz))
      throw UserError(
          "{}: {} in time: {:.6g} s after the sample before; allowed: {:.6g} s within {:g} %{}",
          place(k), dt > kGap * period ? "gap" : "jitter", dt, period, 100 * kUnevenness,
          dt > kGap * period ? ""
                             : "; where samples were taken evenly and stamped late, `fricid import "
                               "--fix jitter`");
  }
}

void refuse_twins(const std::vector<std::string>& joints, const std::string& where) {
  for (auto joint = joints.begin(); joint != joints.end(); ++joint)
    if (std::find(joints.begin(), joint, *joint) != joint)
      throw UserError("{}: joint_names has {} twice; allowed: every joint once", where,
                      in_quotes(*joint));
}

std::vector<std::string> check_dataset(const Dataset& d, const std::string& where) {
  if (d.length() < 2) throw UserError("{}: {} samples; allowed: at least 2", where, d.length());
  if (d.n() < 1) throw UserError("{}: no joints", where);
  if (d.joint_names.size() != static_cast<std::size_t>(d.n()))
    throw UserError("{}: {} joint names for {} joints", where, d.joint_names.size(), d.n());
  refuse_twins(d.joint_names, where);
  if (!(d.rate_hz > 0) || !std::isfinite(d.rate_hz))
    throw UserError("{}: rate_hz = {}; allowed: a positive number", where, d.rate_hz);
  if (!(d.torque_delay_sd >= 0) || !std::isfinite(d.torque_delay_sd))
    throw UserError("{}: torque_delay_sd = {}; allowed: 0 or a positive number", where,
                    d.torque_delay_sd);
  check_times(d.t, d.rate_hz, [&](int k) { return fmt::format("{}: sample {}", where, k); });
  check_shape(d, d.q, "q", where);
  check_shape(d, d.tau, "tau", where);
  if (d.v.size() > 0) check_shape(d, d.v, "v", where);
  if (d.temperature.size() > 0) check_shape(d, d.temperature, "temperature", where);
  check_values(d, d.q, "q", where);
  check_values(d, d.tau, "tau", where);
  if (d.v.size() > 0) check_values(d, d.v, "v", where);
  if (d.temperature.size() > 0) check_values(d, d.temperature, "temperature", where);

  std::vector<std::string> warnings;
  for (int j = 0; j < d.n(); ++j)
    if (const double step = coarse_step(d.q.col(j)); step > 0)
      warnings.push_back(
          fmt::format("{}: q of {} moves in steps of {:.3g}: log it with more digits", where,
                      d.joint_names[static_cast<std::size_t>(j)], step));
  for (int j = 0; j < d.n(); ++j) {
    double largest = 0;
    for (int k = 0; k < d.length(); ++k)
      if (std::abs(d.q(k, j)) > largest) largest = std::abs(d.q(k, j));
    if (largest > kDegrees)
      warnings.push_back(
          fmt::format("{}: |q| of {} reaches {:.4g}, more than 4 pi: degrees, or millimetres?",
                      where, d.joint_names[static_cast<std::size_t>(j)], largest));
  }
  return warnings;
}

void save_dataset(const Dataset& d, const std::filesystem::path& path) {
  check_dataset(d, path.string());
  save_signals(d, path);
}

Dataset load_dataset(const std::filesystem::path& path) {
  const std::string name = path.stem().string();
  require_name(Named::kTrajectory, name, path.string());
  auto d = load_signals<Dataset>(path);
  d.name = name;
  d.source = printable(d.source);
  check_dataset(d, path.string());
  return d;
}

Dataset held_between_samples(Dataset log) {
  const Eigen::Index intervals = log.length() - 1;
  RowMatrix held(intervals, log.n());
  for (Eigen::Index j = 0; j < held.cols(); ++j)
    for (Eigen::Index k = 0; k < intervals; ++k) {
      const auto tau = [&](Eigen::Index i) { return log.tau(k + i, j); };
      held(k, j) = (tau(0) + tau(1)) / 2;
      if (k == 0 || k + 1 == intervals) continue;
      const double bend = (tau(0) + tau(1) - tau(-1) - tau(2)) / 24;
      if (std::isfinite(bend)) held(k, j) += bend;
    }
  Dataset out = rows_of(log, 0, intervals);
  out.tau = std::move(held);
  out.source += ", tau measured at its samples";
  out.torque_delay_sd = 0;
  return out;
}

}  // namespace fricid::data
