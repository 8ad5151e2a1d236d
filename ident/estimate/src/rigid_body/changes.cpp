#include "rigid_body/changes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "rigid_body/information.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPiece = 6;         // length of a piece [s]
constexpr int kMostPieces = 60;      // of all logs
constexpr double kChangeGain = 2.5;  // log of the variance of a joint
constexpr double kWorth = 0.01;      // of the joint's torque, root mean square
constexpr double kMuch = 1.25;  // factor of friction, which warms and cools a little in any log
// Friction that changes for seconds: of shorter pieces, by more, and explained less well by them.
constexpr double kShortPiece = 3, kShortGain = 0.5, kVeryMuch = 1.5;
constexpr double kChance = 160;  // over the rows of a joint: gains by chance where it slides little
constexpr double kKnown = 0.05;  // largest standard error of a change that is named
constexpr int kReweighings = 6;  // by the noise of the joints

/// A stretch of one recording, and its rows by joint.
struct Piece {
  int sequence = 0;
  double begin_s = 0, end_s = 0;
  std::vector<JointRows> joints;
};

/// Every recording in pieces of equal length, some `piece_s` long.
std::vector<Piece> cut_in_pieces(const StackedByJoint& all,
                                 std::span<const signals::Recording> recordings, double piece_s) {
  double seconds = 0;
  for (const signals::Recording& r : recordings) seconds += r.dt * r.length();
  const double length = std::max(piece_s, seconds / kMostPieces);
  std::vector<int> first, count;
  std::vector<Piece> pieces;
  for (std::size_t s = 0; s < recordings.size(); ++s) {
    const double of_log = recordings[s].dt * recordings[s].length();
    first.push_back(static_cast<int>(pieces.size()));
    count.push_back(std::max(1, static_cast<int>(std::lround(of_log / length))));
    for (int i = 0; i < count[s]; ++i)
      pieces.push_back(
          {static_cast<int>(s), of_log * i / count[s], of_log * (i + 1) / count[s], {}});
  }
  const auto piece_of = [&](Eigen::Index row) {
    const auto r = static_cast<std::size_t>(row);
    const auto s = static_cast<std::size_t>(all.sequence[r]);
    return static_cast<std::size_t>(first[s] + static_cast<int>(std::int64_t{all.sample[r]} *
                                                                count[s] / recordings[s].length()));
  };
  for (const JointRows& joint : all.joints) {
    std::vector<Columns> chosen(pieces.size());
    for (std::size_t i = 0; i < joint.at.size(); ++i)
      chosen[piece_of(joint.at[i])].push_back(static_cast<Eigen::Index>(i));
    for (std::size_t p = 0; p < pieces.size(); ++p)
      pieces[p].joints.push_back(normal_equations(joint, chosen[p], all.plain));
  }
  return pieces;
}

/// All pieces as one.
Piece joined(std::span<const Piece> pieces) {
  Piece whole = pieces[0];
  for (const Piece& piece : pieces.subspan(1))
    for (std::size_t j = 0; j < whole.joints.size(); ++j) whole.joints[j].add(piece.joints[j]);
  return whole;
}

/// Of each joint the columns (plain, m) in which a piece may differ from the others by theta (m).
using Freedom = std::vector<Eigen::MatrixXd>;

/// A fit of all pieces.
struct PiecewiseFit {
  std::vector<Eigen::VectorXd> theta;  ///< of each piece, about their mean
  std::vector<Eigen::MatrixXd> H;      ///< information on theta
  Eigen::ArrayXd variance;             ///< (n) that it leaves, unknowns spent
};

/// Least squares in common parameters x and the theta of each piece, which are taken out of its
/// normal equations (Schur complement).
PiecewiseFit fit_pieces(const StackedByJoint& all, std::span<const Piece> pieces,
                        const Freedom& freedom, const Eigen::VectorXd& sigma) {
  const Eigen::Index m = freedom[0].cols();
  const auto n = static_cast<std::size_t>(all.n());
  Eigen::VectorXd weight = sigma.cwiseAbs2().cwiseInverse(), squares;
  PiecewiseFit fit;
  double spent = 0;
  for (int pass = 0; pass < kReweighings; ++pass) {
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(all.plain, all.plain);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(all.plain), size = g;
    std::vector<Eigen::MatrixXd> inverses, across;
    std::vector<Eigen::VectorXd> own;
    spent = static_cast<double>(all.plain);
    fit.H.clear();
    for (const Piece& piece : pieces) {
      Eigen::MatrixXd A = Eigen::MatrixXd::Zero(m, m), C = Eigen::MatrixXd::Zero(m, all.plain);
      Eigen::VectorXd b = Eigen::VectorXd::Zero(m);
      for (std::size_t j = 0; j < n; ++j) {
        const JointRows& rows = piece.joints[j];
        const double w = weight[static_cast<Eigen::Index>(j)];
        const Eigen::MatrixXd BX = w * (freedom[j].transpose() * rows.XX);
        A += BX * freedom[j];
        C += BX;
        b += w * (freedom[j].transpose() * rows.Xy);
        H += w * rows.XX;
        g += w * rows.Xy;
        size += w * rows.XX.diagonal();
      }
      inverses.push_back(pseudo_inverse(A, A.diagonal()));
      spent += (inverses.back() * A).trace();
      H -= C.transpose() * inverses.back() * C;
      g -= C.transpose() * (inverses.back() * b);
      fit.H.push_back(std::move(A));
      across.push_back(std::move(C));
      own.push_back(std::move(b));
    }
    const Eigen::VectorXd x = pseudo_inverse(H, size) * g;
    squares = Eigen::VectorXd::Zero(all.n());
    fit.theta.clear();
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      fit.theta.push_back(inverses[p] * (own[p] - across[p] * x));
      for (std::size_t j = 0; j < n; ++j)
        squares[static_cast<Eigen::Index>(j)] +=
            pieces[p].joints[j].squares(x + freedom[j] * fit.theta[p]);
    }
    for (std::size_t j = 0; j < n; ++j) {
      const auto at = static_cast<Eigen::Index>(j);
      weight[at] = std::pow(sigma_of(squares[at], all.joints[j]), -2);
    }
  }
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(m);
  for (const Eigen::VectorXd& theta : fit.theta) mean += theta / static_cast<double>(pieces.size());
  for (Eigen::VectorXd& theta : fit.theta) theta -= mean;
  const double left = 1 - spent / static_cast<double>(all.rows);
  fit.variance = left > 0 ? Eigen::ArrayXd(weight.array().inverse() / left)
                          : Eigen::ArrayXd::Constant(all.n(), HUGE_VAL);
  return fit;
}

/// @param x  common parameters of a fit without changes
Freedom freedom_of(Change what, const StackedByJoint& all, const Eigen::VectorXd& x) {
  const int n = all.n();
  if (what == Change::kLoad) {
    Eigen::MatrixXd load = Eigen::MatrixXd::Zero(all.plain, 10);
    load.topRows(all.base) = all.K.middleCols(10 * (n - 1), 10);
    return Freedom(static_cast<std::size_t>(n), load);
  }
  Freedom freedom(static_cast<std::size_t>(n), Eigen::MatrixXd::Zero(all.plain, n));
  for (int j = 0; j < n; ++j) {
    const auto at = static_cast<std::size_t>(j);
    auto column = freedom[at].col(j);
    if (what == Change::kFactor) column = x.head(all.plain);
    if (what == Change::kOffset && all.offset[at] >= 0) column[all.offset[at]] = 1;
    if (what == Change::kFriction) {
      for (const Eigen::Index k : {all.Fc[at], all.Fv[at]})
        if (k >= 0) column[k] = x[k];
      const Eigen::Index curve = all.plain - all.curves * (n - j);
      column.segment(curve, all.curves) = x.segment(curve, all.curves);
    }
  }
  return freedom;
}

/// A change of pieces, and what it explains.
struct Compared {
  PiecewiseFit fit;
  Eigen::ArrayXd before;  ///< (n) variance without it
  Eigen::ArrayXd gain;    ///< (n) log of the factor by which that falls
};

/// @param one  fit of all pieces without changes
Compared compare(Change what, const StackedByJoint& all, std::span<const Piece> pieces,
                 const Piece& whole, const Solution& one) {
  const Freedom freedom = freedom_of(what, all, one.x);
  // a joint's factor that is wrong throughout does not change
  Compared out{.fit = fit_pieces(all, pieces, freedom, one.sigma),
               .before = fit_pieces(all, {&whole, 1}, freedom, one.sigma).variance,
               .gain = {}};
  out.gain = (out.before / out.fit.variance).log();
  return out;
}

/// The pieces in which theta of joint j is least and most.
struct Extremes {
  std::size_t least = 0, most = 0;
};

/// Of the pieces that know a change themselves: one in which a joint stands says nothing of its
/// friction.
Extremes extremes_of(Change what, const PiecewiseFit& fit, int j) {
  Extremes out;
  bool any = false;
  for (std::size_t p = 0; p < fit.theta.size(); ++p) {
    const double least = what == Change::kOffset ? 0 : 1 / (kKnown * kKnown);
    if (!(fit.H[p](j, j) > least)) continue;
    if (!any || fit.theta[p][j] < fit.theta[out.least][j]) out.least = p;
    if (!any || fit.theta[p][j] > fit.theta[out.most][j]) out.most = p;
    any = true;
  }
  return out;
}

/// Largest over smallest friction of joint j among the pieces.
double range_of(const PiecewiseFit& fit, int j) {
  const auto [least, most] = extremes_of(Change::kFriction, fit, j);
  return (1 + fit.theta[most][j]) / std::max(1e-9, 1 + fit.theta[least][j]);
}

std::string span_of(const Piece& piece, std::span<const signals::Recording> recordings) {
  const signals::Recording& r = recordings[static_cast<std::size_t>(piece.sequence)];
  return fmt::format("{:.3g} to {:.3g} s of {}", r.log.t[0] + piece.begin_s,
                     r.log.t[0] + piece.end_s, r.log.name);
}

constexpr const char* kParts =
    "train on what lies between changes: train = [\"LOG[:a]\"] in [data]";
constexpr const char* kApart = "fit logs that differ apart";

const char* remedy_of(const Piece& one, const Piece& other) {
  return one.sequence == other.sequence ? kParts : kApart;
}

/// The pieces in which joint j differs most.
Fault name_change(Change what, const dynamics::Joint& joint, int j, const PiecewiseFit& fit,
                  std::span<const Piece> pieces, std::span<const signals::Recording> recordings,
                  bool has_temperature) {
  const auto [least, most] = extremes_of(what, fit, j);
  const auto [before, after] = std::minmax(least, most);
  const auto at = [&](std::size_t piece) { return span_of(pieces[piece], recordings); };
  const char* parts = remedy_of(pieces[before], pieces[after]);
  const double factor = (1 + fit.theta[after][j]) / (1 + fit.theta[before][j]);
  switch (what) {
    case Change::kOffset:
      return {joint.name,
              fmt::format("a constant torque comes and goes: {:.3g} {} from {} against {}",
                          fit.theta[after][j] - fit.theta[before][j], slides(joint) ? "N" : "N m",
                          at(after), at(before)),
              fmt::format("an offset of its torque that jumps or drifts; {}", parts)};
    case Change::kFactor:
      return {joint.name,
              fmt::format("its torque changes its scale: by a factor of {:.3g} from {} to {}",
                          factor, at(before), at(after)),
              fmt::format("its torque constant or the scale of its column is not one; {}", parts)};
    default:
      return {joint.name,
              fmt::format("its friction changes by a factor of {:.3g} from {} to {}", factor,
                          at(before), at(after)),
              has_temperature
                  ? "fit friction that depends on the temperature: the lvm, or "
                    "modifiers = [\"temperature\"]"
                  : fmt::format("look for a brake that drags or gears that warm (log their "
                                "temperature), or {}",
                                parts)};
  }
}

/// Whether friction would push in a piece: something else is fitted there.
bool pushes(const PiecewiseFit& fit, int j) {
  return !(1 + fit.theta[extremes_of(Change::kFriction, fit, j).least][j] > 0);
}

/// The two pieces, one after the other, between which the load changes most.
Fault name_load(const dynamics::RobotModel& robot, const PiecewiseFit& fit,
                std::span<const Piece> pieces, std::span<const signals::Recording> recordings) {
  double most = -1;
  std::size_t before = 0, after = 0, last = pieces.size();
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    if (!(fit.H[p].trace() > 0)) continue;  // the arm stands
    if (last < p) {
      const Eigen::VectorXd step = fit.theta[p] - fit.theta[last];
      const double torque = std::min(step.dot(fit.H[p] * step), step.dot(fit.H[last] * step));
      if (torque > most) most = torque, before = last, after = p;
    }
    last = p;
  }
  return {"",
          fmt::format("the load on {} changes, as between {} and {}", robot.joints.back().link,
                      span_of(pieces[before], recordings), span_of(pieces[after], recordings)),
          fmt::format("`fricid payload` finds a load from two logs, without and with it; {}",
                      remedy_of(pieces[before], pieces[after]))};
}

}  // namespace

Changes find_changes(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
                     std::span<const signals::Recording> recordings) {
  const StackedByJoint all = with_curves_under_load(stacked);
  Changes found;
  const std::vector<Piece> pieces = cut_in_pieces(all, recordings, kPiece);
  if (pieces.size() < 2) return found;
  const Solution one = solve(all, all.plain);
  const Piece whole = joined(pieces);
  double best = 0;
  for (const Change what : {Change::kOffset, Change::kFactor, Change::kFriction, Change::kLoad}) {
    const auto [fit, before, gain] = compare(what, all, pieces, whole, one);
    std::vector<int> joints;
    for (int j = 0; j < all.n(); ++j) {
      const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
      const double torque = rows.yy / std::max(1.0, rows.count);
      if (gain[j] > kChangeGain && before[j] - fit.variance[j] > kWorth * kWorth * torque)
        joints.push_back(j);
    }
    if (joints.empty() || !(gain.sum() > best)) continue;
    best = gain.sum();
    found = {what, {}};
    // friction that warms and cools a little is no fault, and no other change stands for it
    if (what == Change::kFriction)
      std::erase_if(joints, [&](int j) { return !(range_of(fit, j) > kMuch) || pushes(fit, j); });
    if (what == Change::kLoad) {
      found.faults = {name_load(robot, fit, pieces, recordings)};
      continue;
    }
    const bool has_temperature = std::ranges::all_of(
        recordings, [](const signals::Recording& r) { return r.log.temperature.size() > 0; });
    for (const int j : joints) {
      found.faults.push_back(name_change(what, robot.joints[static_cast<std::size_t>(j)], j, fit,
                                         pieces, recordings, has_temperature));
      found.faults.back().without_temperature = what == Change::kFriction && has_temperature;
    }
  }
  return found;
}

std::vector<Fault> find_changing_friction(const dynamics::RobotModel& robot,
                                          const StackedByJoint& stacked,
                                          std::span<const signals::Recording> recordings) {
  const StackedByJoint all = with_curves_under_load(stacked);
  const std::vector<Piece> pieces = cut_in_pieces(all, recordings, kShortPiece);
  if (pieces.size() < 2) return {};
  const auto [fit, before, gain] =
      compare(Change::kFriction, all, pieces, joined(pieces), solve(all, all.plain));
  std::vector<Fault> faults;
  for (int j = 0; j < all.n(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    if (gain[j] > std::max(kShortGain, kChance / all.joints[at].count) &&
        range_of(fit, j) > kVeryMuch && !pushes(fit, j))
      faults.push_back(
          name_change(Change::kFriction, robot.joints[at], j, fit, pieces, recordings, false));
  }
  return faults;
}

}  // namespace fricid::estimate
