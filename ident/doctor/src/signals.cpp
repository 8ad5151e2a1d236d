#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "checks.hpp"
#include "fricid/base/upper_median.hpp"

namespace fricid::doctor {
namespace {

using data::RowMatrix;

constexpr double kCoarsePosition = 1e-4;  // [rad] a tenth of the travel before sliding
constexpr double kCoarseTorque = 0.02;    // of the range
constexpr double kStuck = 0.5;            // [s] of one and the same value
constexpr double kStill = 5e-3;           // [rad or m] of travel within which friction settles
constexpr double kFinish = 0.02;          // [s] before a run of one value
constexpr int kLeastFinish = 3;           // samples of it
constexpr int kApproach = 4;              // times as long, before the finish
constexpr double kStillFast = 0.6;        // of the speed of the approach
constexpr double kSpike = 15;             // robust standard deviations
constexpr double kLeap = 0.02;            // of the range, within a sample
constexpr int kPlateau = 12;              // samples at the very extreme
constexpr double kClipped = 0.01;         // share of a torque at its limit that misleads
constexpr double kCrowding = 8;           // times as many as just below
constexpr double kPiled = 4;              // times as many as of any value between the extremes
constexpr double kJustBelow = 0.01;       // of the range
constexpr double kStepsBelow = 2.5;       // at least, where a channel has steps
constexpr double kRepeated = 0.005;       // share of rows
constexpr double kWarming = 5;            // [K]
constexpr double kColdest = 200;          // [K] below it a temperature is no kelvin

/// One column with what is needed of it many times.
struct Channel {
  const data::Dataset& d;
  const RowMatrix& x;
  const char* signal;
  int joint;
  double low = 0, high = 0;  // extremes of the finite values
  double least_change = 0;   // between two samples that differ; 0: none do

  Channel(const data::Dataset& dataset, const RowMatrix& values, const char* name, int j)
      : d(dataset), x(values), signal(name), joint(j) {
    low = std::numeric_limits<double>::infinity();
    high = -low;
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      if (!std::isfinite(x(k, j))) continue;
      low = std::min(low, x(k, j));
      high = std::max(high, x(k, j));
    }
    for (Eigen::Index k = 1; k < x.rows(); ++k) {
      const double change = std::abs(x(k, j) - x(k - 1, j));
      if (change > 1e-9 * range() && (least_change == 0 || change < least_change))
        least_change = change;
    }
  }
  double operator[](Eigen::Index k) const { return x(k, joint); }
  int length() const { return static_cast<int>(x.rows()); }
  double range() const { return high - low; }
  bool is_empty() const { return high < low; }  // without a finite value

  Finding finding(FindingKind kind, int first, int last, double size, const char* unit) const {
    return {.kind = kind,
            .signal = signal,
            .joint = joint,
            .begin_s = d.t[first],
            .end_s = d.t[last],
            .size = size,
            .unit = unit};
  }
};

constexpr double kMostMissing = 0.5;  // of a column that was logged

void check_missing(const Channel& c, Findings& findings) {
  Finding missing = c.finding(FindingKind::kMissing, 0, 0, 0, "samples");
  for (int k = 0; k < c.length(); ++k) {
    if (std::isfinite(c[k])) continue;
    if (missing.size++ == 0) missing.begin_s = c.d.t[k];
    missing.end_s = c.d.t[k];
  }
  missing.is_severe = missing.size > kMostMissing * c.length();
  if (missing.size > 0) findings.push_back(missing);
}

// The step that all differences are whole multiples of; 0 when there is none.
double quantisation_step(const Channel& c) {
  const double step = c.least_change;
  int standing = 0;
  for (int k = 1; k < c.length(); ++k)
    if (c[k] == c[k - 1]) ++standing;
  if (step == 0 || standing * 20 < c.length()) return 0;
  int multiples = 0, moves = 0;
  for (int k = 1; k < c.length(); ++k) {
    const double ratio = std::abs(c[k] - c[k - 1]) / step;
    if (!(ratio > 0.5)) continue;
    ++moves;
    if (std::abs(ratio - std::round(ratio)) < 0.01 * std::max(1.0, ratio)) ++multiples;
  }
  return multiples * 10 > moves * 9 ? step : 0;
}

bool check_quantisation(const Channel& c, double coarse, const char* unit, Findings& findings) {
  const double step = quantisation_step(c);
  if (step <= coarse) return false;
  findings.push_back(c.finding(FindingKind::kQuantised, 0, c.length() - 1, step, unit));
  return true;
}

// Whether a position travels between two samples.
bool joint_moves(const Channel& q, int first, int last) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int k = first; k <= last; ++k) {
    if (!std::isfinite(q[k])) continue;
    low = std::min(low, q[k]);
    high = std::max(high, q[k]);
  }
  return high - low > kLeap * q.range();
}

// Whether a position that stays at one value over [first, last] got there at full speed. A joint
// that comes to rest slows down. The step of an encoder that ends the motion is no speed.
bool ends_fast(const Channel& c, int first, int last) {
  const int samples = std::max(kLeastFinish, static_cast<int>(std::lround(kFinish / c.d.dt())));
  const int finish_begin = first - samples, approach_begin = finish_begin - kApproach * samples;
  if (approach_begin <= 0) return false;
  const double finish = (std::abs(c[first] - c[finish_begin]) - c.least_change) / samples;
  const double approach = std::abs(c[finish_begin] - c[approach_begin]) / (kApproach * samples);
  return finish > kStillFast * approach && finish * (last - first) > kLeap * c.range();
}

// Whether samples are missing between k and the next.
bool gap_follows(const Channel& c, int k) {
  return !std::isfinite(c[k + 1]) || c.d.t[k + 1] - c.d.t[k] > 1.5 * c.d.dt();
}

// Whether it was cut off there: it leaps when it comes back, or ended at full speed.
bool is_cut_off(const Channel& c, int first, int last) {
  if (last + 1 < c.length() && !gap_follows(c, last))
    return std::abs(c[last + 1] - c[last]) > kLeap * c.range();
  return ends_fast(c, first, last);
}

// The longest run of one value that is no measurement: noise never stands still, unless the joint
// does.
// @param q  position of the channel's joint
void check_stuck(const Channel& c, const Channel& q, double shortest_s, Findings& findings) {
  const bool is_position = c.signal == std::string_view("q");
  const int shortest = static_cast<int>(std::ceil(shortest_s / c.d.dt()));
  int best = shortest - 1, begin = 0, end = 0;
  for (int k = 0, first = 0; k < c.length(); ++k) {
    if (c[k] != c[first]) first = k;
    const bool run_ends = k + 1 == c.length() || c[k + 1] != c[first];
    if (!run_ends || k - first <= best) continue;
    if (is_position ? !is_cut_off(c, first, k) : !joint_moves(q, first, k)) continue;
    best = k - first;
    begin = first;
    end = k;
  }
  if (end > begin)
    findings.push_back(c.finding(FindingKind::kStuck, begin, end, c.d.t[end] - c.d.t[begin], "s"));
}

// A joint whose whole travel is less than friction needs to settle.
bool check_still(const Channel& c, Findings& findings) {
  if (c.range() > kStill) return false;
  findings.push_back(
      c.finding(FindingKind::kStill, 0, c.length() - 1, std::max(0.0, c.range()), "rad"));
  return true;
}

// How often one value between the extremes occurs at most, in all and in a row; rests of the joint
// apart.
struct MostOfOneValue {
  int in_all = 0, in_a_row = 0;
};

MostOfOneValue most_of_one_value(const Channel& c, const Channel& q) {
  MostOfOneValue most;
  std::vector<double> values;
  for (int k = 0; k < c.length(); ++k) {
    int end = k;  // of the run
    while (end + 1 < c.length() && c[end + 1] == c[k]) ++end;
    const bool rests = (end - k) * c.d.dt() > kStuck && !joint_moves(q, k, end);
    if (const int run = end - k + 1; c[k] > c.low && c[k] < c.high && !rests) {
      most.in_a_row = std::max(most.in_a_row, run);
      values.insert(values.end(), static_cast<std::size_t>(run), c[k]);
    }
    k = end;
  }
  std::ranges::sort(values);
  for (auto first = values.begin(); first != values.end();) {
    const auto next = std::upper_bound(first, values.end(), *first);
    most.in_all = std::max(most.in_all, static_cast<int>(next - first));
    first = next;
  }
  return most;
}

// Many samples at the very extreme and few just below, or of a torque far more than of any other
// value, in all or in a row: an amplifier or a number at its end. A single run that ends in a leap
// is a channel that stuck there; a joint that rests keeps its torque. A fit to a torque of which a
// share lies there is wrong.
// @param q  position of the channel's joint
void check_saturation(const Channel& c, const Channel& q, Findings& findings) {
  const double width = std::max(kJustBelow * c.range(), kStepsBelow * c.least_change);
  const bool is_position = c.signal == std::string_view("q");
  std::optional<MostOfOneValue> other;  // looked for where an extreme may be one too many
  for (const double sign : {1.0, -1.0}) {
    const double extreme = sign > 0 ? c.high : c.low;
    const auto is_top = [&](int k) { return sign * (extreme - c[k]) <= 1e-9 * c.range(); };
    int near = 0, longest = 0, plateaus = 0;
    std::vector<int> at;
    bool leaps = false;
    for (int k = 0; k < c.length(); ++k) {
      if (!is_top(k)) {
        if (sign * (extreme - c[k]) < width) ++near;
        continue;
      }
      int end = k;  // of the run
      while (end + 1 < c.length() && is_top(end + 1)) ++end;
      const int run = end - k + 1;
      const bool rests =
          run * c.d.dt() > kStuck && !(is_position ? ends_fast(c, k, end) : joint_moves(q, k, end));
      if (run > kPlateau) {
        ++plateaus;
        leaps =
            leaps || (end + 1 < c.length() && sign * (extreme - c[end + 1]) > kLeap * c.range());
      }
      if (!rests) {
        for (int i = k; i <= end; ++i) at.push_back(i);
        longest = std::max(longest, run);
      }
      k = end;
    }
    const auto count = static_cast<int>(at.size());
    const bool crowded = longest >= kPlateau && count >= kCrowding * near;
    const auto piled = [&] {
      if (is_position || count < kPlateau) return false;
      if (!other) other = most_of_one_value(c, q);
      return count >= kPiled * other->in_all ||
             (longest >= kPlateau && longest >= kCrowding * other->in_a_row);
    };
    if ((leaps && plateaus == 1) || !(crowded || piled())) continue;
    Finding finding = c.finding(FindingKind::kSaturated, at.front(), at.back(), extreme, "");
    finding.unit = is_position ? "rad" : "N m";
    finding.count = count;
    finding.is_severe = !is_position && count > kClipped * c.length();
    finding.rows = std::move(at);
    findings.push_back(finding);
  }
}

// A sample far off the line between its neighbours, which agree.
void check_spikes(const Channel& c, Findings& findings) {
  std::vector<double> bends;
  for (int k = 1; k + 1 < c.length(); ++k) {
    const double bend = std::abs(c[k] - (c[k - 1] + c[k + 1]) / 2);
    if (bend > 0) bends.push_back(bend);  // not where a limit holds the signal
  }
  const double sigma = std::max(1.48 * upper_median(bends), 1e-6 * c.range());
  Finding spike =
      c.finding(FindingKind::kSpike, 0, 0, 0, c.signal == std::string_view("q") ? "rad" : "N m");
  spike.count = 0;
  for (int k = 2; k + 2 < c.length(); ++k) {
    const double bend = std::abs(c[k] - (c[k - 1] + c[k + 1]) / 2);
    const double across = std::max({std::abs(c[k + 1] - c[k - 1]), std::abs(c[k + 2] - c[k + 1]),
                                    std::abs(c[k - 1] - c[k - 2])});
    if (!(bend > kSpike * sigma && bend > 4 * across && bend > 2e-3 * c.range())) continue;
    if (spike.count++ == 0) spike.begin_s = c.d.t[k];
    spike.end_s = c.d.t[k];
    spike.size = std::max(spike.size, bend);
    spike.rows.push_back(k);
  }
  if (spike.count > 0) findings.push_back(spike);
}

// Whether the step before sample k is none of the motion: far beyond what the steps about it, their
// spread and the bends of the whole log allow.
// @param bend  robust standard deviation of a step from the mean of its neighbours
bool leaps(const Channel& c, int k, double bend) {
  constexpr int kNear = 5;            // steps on either side
  constexpr double kSmallest = 5e-3;  // of the range
  constexpr double kBends = 15, kSpreads = 4;
  if (k - kNear < 1 || k + kNear >= c.length()) return false;
  double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0;
  for (int i = k - kNear; i <= k + kNear; ++i) {
    if (i == k) continue;
    const double step = c[i] - c[i - 1];
    if (!std::isfinite(step)) return false;
    low = std::min(low, step);
    high = std::max(high, step);
    sum += step;
  }
  const double leap = std::abs(c[k] - c[k - 1] - sum / (2 * kNear));
  return leap > kSmallest * c.range() && leap > kBends * bend &&
         leap > kSpreads * (high - low + c.least_change);
}

// A step in the position that stays: a resolver that lost whole turns, an encoder that was reset.
void check_jumps(const Channel& c, Findings& findings) {
  constexpr double kSmallest = 0.2, kAbove = 20;  // [rad], times the usual step
  std::vector<double> steps, bends;
  for (int k = 1; k < c.length(); ++k)
    if (std::isfinite(c[k] - c[k - 1])) steps.push_back(std::abs(c[k] - c[k - 1]));
  for (int k = 2; k + 1 < c.length(); ++k)
    if (const double bend = std::abs(c[k] - c[k - 1] - (c[k + 1] - c[k - 2] - c[k] + c[k - 1]) / 2);
        bend > 0)
      bends.push_back(bend);
  if (steps.empty()) return;
  const double bend = 1.48 * upper_median(bends);
  const auto ninth = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() * 9 / 10);
  std::nth_element(steps.begin(), ninth, steps.end());
  const double usual = *ninth;
  for (int k = 1; k + 1 < c.length(); ++k) {
    const double step = c[k] - c[k - 1];
    if (!(std::abs(step) >= kSmallest && std::abs(step) >= kAbove * usual) && !leaps(c, k, bend))
      continue;
    if (std::abs(c[k + 1] - c[k - 1]) < 0.5 * std::abs(step)) continue;  // a spike
    if (k > 1 && std::abs(c[k] - c[k - 2]) < 0.5 * std::abs(step)) continue;
    if (std::abs(c.d.t[k] - c.d.t[k - 1] - c.d.dt()) > 0.5 * c.d.dt())
      continue;  // a gap, a row twice
    Finding jump = c.finding(FindingKind::kJump, k - 1, k, step, "rad");
    jump.rows = {k};
    findings.push_back(jump);
  }
}

// Rows that repeat the one before in every signal although a joint moves: before them and, of
// several in a row, by a leap after them.
void check_repeats(const data::Dataset& d, Findings& findings) {
  constexpr double kLeaps = 1.5;  // times the step before
  const auto same = [&](int k) {
    return d.q.row(k) == d.q.row(k - 1) && d.tau.row(k) == d.tau.row(k - 1);
  };
  const auto step = [&](int k) { return (d.q.row(k) - d.q.row(k - 1)).cwiseAbs().eval(); };
  std::vector<int> rows;
  for (int first = 2, end = 0; first < d.length(); first = std::max(first + 1, end)) {
    if (!same(first)) continue;
    for (end = first + 1; end < d.length() && same(end);) ++end;
    const bool moves = (step(first - 1).array() > 0).count() * 2 > d.n();
    const bool goes_on =
        end - first == 1 || (end < d.length() && step(end).sum() > kLeaps * step(first - 1).sum());
    for (int k = first; k < end && moves && goes_on; ++k) rows.push_back(k);
  }
  const auto count = static_cast<int>(rows.size());
  if (!(count > kRepeated * d.length())) return;
  findings.push_back({.kind = FindingKind::kRepeated,
                      .signal = "q tau",
                      .begin_s = d.t[rows.front()],
                      .end_s = d.t[rows.back()],
                      .size = 100.0 * count / d.length(),
                      .unit = "% of rows",
                      .count = count,
                      .rows = std::move(rows)});
}

// The factor by which one column is another, to rounding; 0: it is not, or too few of its samples
// change to tell.
double factor_between(const RowMatrix& x, int i, int j) {
  constexpr double kRounding = 1e-14;  // of a sample
  constexpr int kChanges = 10;
  double factor = 0;
  int changes = 0;
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    const double a = x(k, i), b = x(k, j);
    if (std::isfinite(a) != std::isfinite(b)) return 0;
    if (!std::isfinite(a)) continue;
    if ((a == 0) != (b == 0)) return 0;
    if (factor == 0 && a != 0) factor = b / a;
    if (std::abs(b - factor * a) > kRounding * std::abs(b)) return 0;
    if (k > 0 && std::isfinite(x(k - 1, i)) && a != x(k - 1, i)) ++changes;
  }
  return changes >= kChanges ? factor : 0;
}

// One column for two joints. Signs of the contract may differ, of a torque gears and constants too;
// positions in proportion may be those of a straight motion.
void check_same(const data::Dataset& d, const RowMatrix& x, const char* signal,
                Findings& findings) {
  const bool is_position = signal == std::string_view("q");
  for (int j = 1; j < d.n(); ++j)
    for (int i = 0; i < j; ++i) {
      const double factor = factor_between(x, i, j);
      if (factor == 0 || (is_position && std::abs(factor) != 1)) continue;
      if (is_position && Channel(d, x, signal, i).range() <= kStill) continue;
      Finding same =
          Channel(d, x, signal, i)
              .finding(FindingKind::kSame, 0, d.length() - 1, d.t[d.length() - 1] - d.t[0], "s");
      same.other = j;
      if (factor != 1) same.unit += fmt::format(", but for a factor of {:.4g}", factor);
      findings.push_back(same);
      break;
    }
}

void check_temperature(const Channel& c, Findings& findings) {
  if (c.high < kColdest) {
    findings.push_back(c.finding(FindingKind::kTemperatureUnit, 0, c.length() - 1, c.high, "K"));
  } else if (c.range() > kWarming) {
    findings.push_back(
        c.finding(FindingKind::kTemperatureTrend, 0, c.length() - 1, c.range(), "K"));
  }
}

bool found(const Findings& findings, FindingKind kind, const Channel& c) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& f) {
    return f.kind == kind && f.joint == c.joint && f.signal == c.signal;
  });
}

// A torque on one side of zero that comes back from it many times, as an absolute value does.
void check_unsigned(const Channel& tau, Findings& findings) {
  constexpr double kHigh = 0.5, kNear = 0.1;  // of the root mean square
  constexpr int kTimes = 6;
  if (tau.low < 0 && tau.high > 0) return;
  double squares = 0, count = 0;
  for (int k = 0; k < tau.length(); ++k)
    if (std::isfinite(tau[k])) {
      squares += tau[k] * tau[k];
      ++count;
    }
  const double rms = std::sqrt(squares / count);
  bool high = false;
  int times = 0;
  for (int k = 0; k < tau.length(); ++k) {
    const double size = std::abs(tau[k]) / rms;
    if (high && size < kNear) {
      high = false;
      ++times;
    } else if (size > kHigh) {
      high = true;
    }
  }
  if (times >= kTimes)
    findings.push_back(tau.finding(FindingKind::kUnsigned, 0, tau.length() - 1,
                                   tau.low < 0 ? tau.low : tau.high, "N m"));
}

// @param q  position of the channel's joint, which moves unless it is `still`
void check_torque(const Channel& tau, const Channel& q, bool still, Findings& findings) {
  if (tau.range() == 0) {
    if (!still)
      findings.push_back(tau.finding(FindingKind::kConstant, 0, tau.length() - 1, tau.high, "N m"));
    return;
  }
  check_unsigned(tau, findings);
  const bool steps = check_quantisation(tau, kCoarseTorque * tau.range(), "N m", findings);
  if (!steps) {
    check_saturation(tau, q, findings);
    check_spikes(tau, findings);
  }
  if (!found(findings, FindingKind::kSaturated, tau))
    check_stuck(tau, q, steps ? 10 * kStuck : kStuck, findings);
}

}  // namespace

void check_signals(const data::Dataset& d, Findings& findings) {
  for (int j = 0; j < d.n(); ++j) {
    const Channel q(d, d.q, "q", j), tau(d, d.tau, "tau", j);
    for (const Channel& c : {q, tau}) check_missing(c, findings);
    const Channel temperature(d, d.temperature, "temperature", j);
    if (!temperature.is_empty()) check_temperature(temperature, findings);
    if (q.is_empty() || tau.is_empty()) continue;
    const bool coarse = check_quantisation(q, kCoarsePosition, "rad", findings);
    const bool still = check_still(q, findings);
    if (!still) check_stuck(q, q, coarse ? 4 * kStuck : kStuck, findings);
    if (!still && !found(findings, FindingKind::kStuck, q)) {
      check_saturation(q, q, findings);
      check_spikes(q, findings);
      check_jumps(q, findings);
    }
    check_torque(tau, q, still, findings);
  }
  check_same(d, d.q, "q", findings);
  check_same(d, d.tau, "tau", findings);
  check_repeats(d, findings);
}

void find_segments(const data::Dataset& d, Findings& findings) {
  constexpr double kWindow = 0.1;  // [s]
  constexpr double kSlow = 1e-3;   // [rad/s]
  const int width = std::max(1, static_cast<int>(std::lround(kWindow / d.dt())));
  for (int j = 0; j < d.n(); ++j) {
    int moving = 0, windows = 0;
    for (int k = 0; k + width < d.length(); k += width) {
      const double travel = std::abs(d.q(k + width, j) - d.q(k, j));
      if (!std::isfinite(travel)) continue;
      ++windows;
      if (travel > kSlow * width * d.dt()) ++moving;
    }
    if (windows == 0) continue;
    findings.push_back({.kind = FindingKind::kSegments,
                        .signal = "q",
                        .joint = j,
                        .begin_s = d.t[0],
                        .end_s = d.t[d.length() - 1],
                        .size = 100.0 * moving / windows,
                        .unit = "% moving"});
  }
}

}  // namespace fricid::doctor
