#include "fricid/data/log_part.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "fricid/base/error.hpp"

namespace fricid::data {

LogPart log_part(const std::string& text) {
  const std::size_t open = text.rfind('['), colon = text.rfind(':');
  if (!text.ends_with(']') || open == std::string::npos) return {.file = text};
  LogPart part{.file = text.substr(0, open)};
  const auto read = [&](std::size_t begin, std::size_t end, double& seconds) {
    if (begin == end) return true;
    const auto [last, error] = std::from_chars(text.data() + begin, text.data() + end, seconds);
    return error == std::errc() && last == text.data() + end && seconds >= 0;
  };
  const bool readable = colon != std::string::npos && colon > open &&
                        read(open + 1, colon, part.from_s) &&
                        read(colon + 1, text.size() - 1, part.to_s);
  if (!readable || !(part.from_s < part.to_s))
    throw UserError("{}: {} is no part of a log; allowed: seconds [FROM:TO], FROM below TO", text,
                    text.substr(open));
  return part;
}

Dataset of_joints(const Dataset& d, const std::vector<std::string>& joints,
                  const std::map<std::string, double>& welds, const std::string& where) {
  constexpr double kStill = 0.02;  // [rad or m] from where a joint is welded
  if (d.joint_names == joints) return d;
  std::vector<Eigen::Index> columns;
  for (const std::string& joint : joints) {
    const auto column = std::ranges::find(d.joint_names, joint);
    if (column == d.joint_names.end())
      throw UserError(
          "{}: joints {}; {} of the robot is not logged: allowed: all that move; where it rests, "
          "fix = {{{} = POSITION}} in [robot] of a scene, or type=\"fixed\" in the URDF",
          where, fmt::join(d.joint_names, " "), joint, joint);
    columns.push_back(column - d.joint_names.begin());
  }
  for (std::size_t j = 0; j < d.joint_names.size(); ++j) {
    const std::string& name = d.joint_names[j];
    const auto column = static_cast<Eigen::Index>(j);
    const auto weld = welds.find(name);
    if (weld == welds.end()) continue;
    for (const double q : d.q.col(column))
      if (std::abs(q - weld->second) > kStill)
        throw UserError(
            "{}: {} is welded at {:.4g} and here at {:.4g}; allowed: within {:g} rad or m; use a "
            "part of the log where it rests (\"{}[FROM:TO]\"), or let it move",
            where, name, weld->second, q, kStill, where);
  }
  Dataset out = d;
  out.joint_names = joints;
  for (RowMatrix* table : {&out.q, &out.tau, &out.v, &out.temperature})
    if (table->rows() > 0) *table = RowMatrix((*table)(Eigen::all, columns));
  return out;
}

Dataset rows_of(const Dataset& d, Eigen::Index first, Eigen::Index length) {
  Dataset out{.name = d.name,
              .joint_names = d.joint_names,
              .rate_hz = d.rate_hz,
              .source = d.source,
              .t = d.t.segment(first, length),
              .q = {},
              .tau = {},
              .v = {},
              .temperature = {},
              .torque_delay_sd = d.torque_delay_sd};
  for (RowMatrix Dataset::*signal :
       {&Dataset::q, &Dataset::tau, &Dataset::v, &Dataset::temperature})
    if ((d.*signal).rows() > 0) out.*signal = (d.*signal).middleRows(first, length);
  return out;
}

Dataset cut(const Dataset& d, const LogPart& part, const std::string& where) {
  if (d.length() == 0) return d;
  constexpr double kPastEnd = 0.01;  // of the log's length: lengths are rounded
  const double seconds_of_log = d.t[d.length() - 1] - d.t[0] + d.dt();
  if (std::isfinite(part.to_s) && part.to_s > (1 + kPastEnd) * seconds_of_log)
    throw UserError("{}: a part that ends at {} s; the log has {:.4g} s", where, part.to_s,
                    seconds_of_log);
  // half a sample of tolerance: times are rounded
  const double begin = d.t[0] - d.dt() / 2;
  const auto row_at = [&](double seconds) {
    return std::lower_bound(d.t.begin(), d.t.end(), begin + seconds) - d.t.begin();
  };
  const Eigen::Index first = row_at(part.from_s), length = row_at(part.to_s) - first;
  if (length < 2)
    throw UserError("{}: {} samples from {} to {} s; the log has {:.4g} s", where, length,
                    part.from_s, part.to_s, d.t[d.length() - 1] - d.t[0]);
  return rows_of(d, first, length);
}

}  // namespace fricid::data
