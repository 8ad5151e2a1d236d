#include "fricid/estimate/recording.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/parallel.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::estimate {
namespace {

constexpr int kFrequencies = 1000;        // of the sum over the band
constexpr double kNormalMedian = 0.6745;  // median of |x|, x ~ N(0, 1)

}  // namespace

Recording make_recording(const data::Dataset& dataset, const Filtered& filtered, double cutoff_hz) {
  Recording out{dataset.name, filtered.dt, filtered.q_wide,      filtered.v_wide,
                dataset.q,    dataset.tau, filtered.temperature, {}};
  for (Eigen::Index j = 0; j < out.tau.cols(); ++j) {
    double last = 0;
    for (Eigen::Index k = 0; k < out.tau.rows(); ++k)
      last = out.tau(k, j) = std::isfinite(out.tau(k, j)) ? out.tau(k, j) : last;
  }

  // white noise leaves this share of its variance above the band; the median forgives reversals
  const double rate = 1 / filtered.dt;
  const ZeroPhaseButterworth low_pass(kWideBand * cutoff_hz, rate);
  double share = 0;
  for (int i = 0; i < kFrequencies; ++i) {
    const double above = 1 - low_pass.gain((i + 0.5) / kFrequencies * rate / 2);
    share += above * above / kFrequencies;
  }
  out.noise_sd.resize(out.q.cols());
  std::vector<double> residual;
  for (Eigen::Index j = 0; j < out.q.cols(); ++j) {
    residual.clear();
    for (Eigen::Index k = 0; k < out.q.rows(); ++k) {
      const double e = std::abs(out.q_measured(k, j) - out.q(k, j));
      if (std::isfinite(e)) residual.push_back(e);
    }
    const auto middle = residual.begin() + std::ssize(residual) / 2;
    std::nth_element(residual.begin(), middle, residual.end());
    out.noise_sd[j] = *middle / kNormalMedian / std::sqrt(share);
  }
  return out;
}

std::vector<data::RowMatrix> wash_out(const friction::Friction& friction,
                                      std::span<const Recording> recordings, int jobs) {
  std::vector<data::RowMatrix> z(recordings.size());
  parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
    const Recording& r = recordings[static_cast<std::size_t>(i)];
    z[static_cast<std::size_t>(i)] =
        drive_friction(friction, r.dt, r.q, r.v, r.tau, r.temperature).z;
  });
  return z;
}

}  // namespace fricid::estimate
