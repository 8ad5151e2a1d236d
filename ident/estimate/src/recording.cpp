#include "fricid/estimate/recording.hpp"

#include <cmath>

#include "fricid/base/parallel.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::estimate {

Recording make_recording(const data::Dataset& dataset, const Filtered& filtered) {
  Recording out{dataset.name, filtered.dt, filtered.q_wide,     filtered.v_wide,
                dataset.q,    dataset.tau, filtered.temperature};
  for (Eigen::Index j = 0; j < out.tau.cols(); ++j) {
    double last = 0;
    for (Eigen::Index k = 0; k < out.tau.rows(); ++k)
      last = out.tau(k, j) = std::isfinite(out.tau(k, j)) ? out.tau(k, j) : last;
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
