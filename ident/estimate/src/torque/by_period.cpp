#include "fricid/estimate/torque/by_period.hpp"

#include <algorithm>

#include "fricid/data/log_part.hpp"
#include "fricid/signals/periods.hpp"

namespace fricid::estimate {
namespace {

signals::Recording part_of(const signals::Recording& r, int begin, int length) {
  const auto rows = [&](const RowMatrix& x) -> RowMatrix {
    return x.size() > 0 ? RowMatrix(x.middleRows(begin, length)) : RowMatrix();
  };
  const auto motion = [&](const signals::Motion& m) {
    return signals::Motion{rows(m.q), rows(m.v), rows(m.a)};
  };
  signals::Recording part{.log = data::rows_of(r.log, begin, length),
                          .dt = r.dt,
                          .narrow = motion(r.narrow),
                          .wide = motion(r.wide),
                          .held_tau = rows(r.held_tau),
                          .filtered_tau = rows(r.filtered_tau),
                          .load = rows(r.load),
                          .temperature = rows(r.temperature),
                          .use = r.use.middleRows(begin, length),
                          .noise_sd = r.noise_sd,
                          .step = r.step};
  signals::leave_out_run_in(part);
  return part;
}

}  // namespace

ByPeriod by_period(std::span<const signals::Recording> recordings) {
  ByPeriod out;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const signals::Recording& r = recordings[i];
    out.longest_s = std::max(out.longest_s, r.period * r.dt);
    const int length = r.period > 0 ? r.period : r.length();
    for (int begin = 0; begin + length <= r.length(); begin += length) {
      out.recordings.push_back(r.period > 0 ? part_of(r, begin, length) : r);
      out.origins.push_back({static_cast<int>(i), begin});
    }
  }
  for (signals::Recording& r : out.recordings) r.period = 0;
  signals::number_motions(out.recordings);
  return out;
}

}  // namespace fricid::estimate
