#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "checks.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/text.hpp"
#include "fricid/data/sample_times.hpp"
#include "fricid/data/uneven_times.hpp"
#include "fricid/doctor/doctor.hpp"

namespace fricid::doctor {
namespace {

using data::Dataset;
using data::RowMatrix;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr double kTurn = 2 * std::numbers::pi;

/// Every table of a data set that it has.
std::vector<RowMatrix*> tables(Dataset& d) {
  std::vector<RowMatrix*> all{&d.q, &d.tau};
  for (RowMatrix* optional : {&d.v, &d.temperature})
    if (optional->size() > 0) all.push_back(optional);
  return all;
}

bool names_signal(const Finding& f, std::string_view signal) {
  std::string_view rest = f.signal;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == signal) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

/// Puts row `from[i]` of the old log at row i; -1: a row of missing values.
void choose_rows(Dataset& d, const std::vector<int>& from) {
  const auto length = static_cast<Eigen::Index>(from.size());
  for (RowMatrix* table : tables(d)) {
    RowMatrix chosen(length, table->cols());
    for (Eigen::Index i = 0; i < length; ++i) {
      const int k = from[static_cast<std::size_t>(i)];
      if (k >= 0)
        chosen.row(i) = table->row(k);
      else
        chosen.row(i).setConstant(kMissing);
    }
    *table = chosen;
  }
}

// Lost samples and repeated rows stay what they are, for the reader to refuse.
void make_uniform(Dataset& d) {
  const std::vector<int> rising = data::rising_rows(d.t);
  const std::vector<int> lost = data::lost_before(d.t(rising), d.rate_hz);
  double at = -1;
  std::size_t next = 0;
  for (int k = 0; k < d.length(); ++k) {
    if (next < rising.size() && rising[next] == k) at += 1 + lost[next++];
    d.t[k] = at / d.rate_hz;
  }
}

void drop_duplicates(Dataset& d) {
  const std::vector<int> kept = data::rising_rows(d.t);
  choose_rows(d, kept);
  d.t = Eigen::VectorXd(d.t(kept));
}

/// Rows of missing values before each row, as many as were lost there; times become even.
void insert_lost(Dataset& d, const std::vector<int>& lost_before) {
  double samples = d.length();
  for (const int count : lost_before) samples += count;
  const std::string where = d.source.empty() ? d.name : fmt::format("{} ({})", d.name, d.source);
  require_within(limits::kFilledSamples, static_cast<std::uint64_t>(std::clamp(samples, 0.0, 1e18)),
                 where);
  require_memory(8 * samples * static_cast<double>(2 * tables(d).size() * d.joint_names.size()),
                 where, "the log with its gaps filled");
  std::vector<int> rows;
  for (int k = 0; k < d.length(); ++k) {
    rows.insert(rows.end(), static_cast<std::size_t>(lost_before[static_cast<std::size_t>(k)]), -1);
    rows.push_back(k);
  }
  const double begin = d.t[0];
  choose_rows(d, rows);
  d.t = begin +
        Eigen::VectorXd::LinSpaced(d.q.rows(), 0, static_cast<double>(d.q.rows() - 1)).array() /
            d.rate_hz;
}

// Samples lost are counted gap by gap, so that a drifting clock adds up nowhere.
void fill_gaps(Dataset& d) { insert_lost(d, data::lost_before(d.t, d.rate_hz)); }

void let_time_run_on(Dataset& d, const Finding& lost) {
  std::vector<int> before(static_cast<std::size_t>(d.length()), 0);
  for (const int k : lost.rows) ++before[static_cast<std::size_t>(k)];
  insert_lost(d, before);
}

void keep_rows_of_source(Dataset& d, const Finding& held) {
  choose_rows(d, held.rows);
  d.t = Eigen::VectorXd(d.t(held.rows));
  d.rate_hz /= held.size;
}

void sort_by_time(Dataset& d) {
  const std::vector<int> order = data::order_by_time(d.t);
  choose_rows(d, order);
  d.t = Eigen::VectorXd(d.t(order));
}

void let_time_go_on(Dataset& d, const Finding& wrap) {
  for (const int k : wrap.rows) d.t.tail(d.length() - k).array() += wrap.size;
}

void interpolate(Dataset& d) { d = data::at_even_times(std::move(d)); }

// Whether `f` concerns joint j.
bool concerns(const Finding& f, int j) { return f.joint < 0 || f.joint == j; }

// Torque at t_k taken from t_k + delay.
void advance_torque(Dataset& d, const Finding& f) {
  const RowMatrix old = d.tau;
  const int whole = static_cast<int>(std::floor(f.size));
  const double share = f.size - whole;
  const int T = d.length();
  for (int k = 0; k < T; ++k) {
    const int i = std::clamp(k + whole, 0, T - 1), next = std::clamp(k + whole + 1, 0, T - 1);
    for (int j = 0; j < d.n(); ++j)
      if (concerns(f, j)) d.tau(k, j) = (1 - share) * old(i, j) + share * old(next, j);
  }
}

void scale(Dataset& d, const Finding& f, double factor) {
  for (int j = 0; j < d.n(); ++j) {
    if (!concerns(f, j)) continue;
    if (names_signal(f, "q")) {
      d.q.col(j) *= factor;
      if (d.v.size() > 0 && names_signal(f, "v")) d.v.col(j) *= factor;
    }
    if (names_signal(f, "tau")) d.tau.col(j) *= factor;
  }
}

void apply(Dataset& d, const Finding& f) {
  if (f.kind == FindingKind::kGap) return fill_gaps(d);
  if (f.kind == FindingKind::kLost) return let_time_run_on(d, f);
  if (f.kind == FindingKind::kDuplicate) return drop_duplicates(d);
  if (f.kind == FindingKind::kJitter || f.kind == FindingKind::kClockDrift) return make_uniform(d);
  if (f.kind == FindingKind::kUneven) return interpolate(d);
  if (f.kind == FindingKind::kDelay) return advance_torque(d, f);
  if (f.kind == FindingKind::kOutOfOrder) return sort_by_time(d);
  if (f.kind == FindingKind::kWrap) return let_time_go_on(d, f);
  if (f.kind == FindingKind::kHeld) return keep_rows_of_source(d, f);
  if (f.kind == FindingKind::kVelocity) return d.v.resize(0, 0);
  if (f.kind == FindingKind::kSign) return scale(d, f, -1);
  if (f.kind == FindingKind::kAngleUnit) return scale(d, f, std::numbers::pi / 180);
  if (f.kind == FindingKind::kTemperatureUnit) {
    d.temperature.col(f.joint).array() += 273.15;
  } else if (f.kind == FindingKind::kSwapped) {
    if (names_signal(f, "q")) {
      d.q.col(f.joint).swap(d.q.col(f.other));
      if (d.v.size() > 0 && names_signal(f, "v")) d.v.col(f.joint).swap(d.v.col(f.other));
    }
    if (names_signal(f, "tau")) d.tau.col(f.joint).swap(d.tau.col(f.other));
  } else if (f.kind == FindingKind::kJump) {
    d.q.col(f.joint).tail(d.length() - f.rows[0]).array() -= kTurn * std::round(f.size / kTurn);
  } else if (f.kind == FindingKind::kSpike || f.kind == FindingKind::kSaturated) {
    for (const int k : f.rows) (names_signal(f, "q") ? d.q : d.tau)(k, f.joint) = kMissing;
  } else if (f.kind == FindingKind::kRepeated) {
    for (const int k : f.rows)
      for (RowMatrix* table : tables(d)) table->row(k).setConstant(kMissing);
  }
}

// Rows are sorted first, then a wrapped counter and rows that are held, since what else was found
// is of the log without; then repairs of given rows, then those that change the rows, then those
// that need even times. Lost rows are those of the log that is even.
int order_of(FindingKind kind) {
  switch (kind) {
    case FindingKind::kOutOfOrder:
      return 0;
    case FindingKind::kWrap:
      return 1;
    case FindingKind::kHeld:
      return 2;
    case FindingKind::kDuplicate:
      return 4;
    case FindingKind::kGap:
      return 5;
    case FindingKind::kJitter:
    case FindingKind::kUneven:
    case FindingKind::kClockDrift:
    case FindingKind::kDelay:
      return 6;
    case FindingKind::kLost:
      return 7;
    default:
      return 3;
  }
}

}  // namespace

std::vector<FindingKind> fixes_of(std::span<const std::string> names) {
  std::vector<std::string> fixable;
  for (const std::string& name : all_names<FindingKind>())
    if (info_of(*value_named<FindingKind>(name)).fixable) fixable.push_back(name);
  std::vector<FindingKind> kinds;
  for (const std::string& name : names) {
    if (std::ranges::count(fixable, name) == 0)
      throw UserError("--fix {}: allowed: {}", name, fmt::join(fixable, " "));
    kinds.push_back(*value_named<FindingKind>(name));
  }
  return kinds;
}

bool can_be_repaired(const Finding& f) {
  constexpr double kMotion = 0.2;  // [rad] of the joint during the jump, at most
  if (f.kind != FindingKind::kJump) return info_of(f.kind).fixable;
  const double turns = std::round(f.size / kTurn);
  return turns != 0 && std::abs(f.size - kTurn * turns) < kMotion;
}

Dataset repair(Dataset d, std::span<const Finding> findings, std::span<const FindingKind> kinds) {
  const auto restart = std::ranges::find(findings, FindingKind::kRestart, &Finding::kind);
  if (restart != findings.end())
    throw UserError("the clock goes {:.4g} {}: two recordings in one file; {}", restart->size,
                    restart->unit, info_of(restart->kind).remedy);
  std::vector<const Finding*> chosen;
  for (const Finding& f : findings)
    if (std::ranges::count(kinds, f.kind) > 0 && can_be_repaired(f)) chosen.push_back(&f);
  const auto is_chosen = [&](FindingKind kind) {
    return std::ranges::count(chosen, kind, &Finding::kind) > 0;
  };
  for (const FindingKind kind : kinds)
    if (!is_chosen(kind) && kind != FindingKind::kJitter)
      throw UserError("--fix {}: nothing of that name was found that can be repaired",
                      name_of(kind));
  const auto require_first = [&](FindingKind first, const Finding& f) {
    if (std::ranges::count(findings, first, &Finding::kind) > 0 && !is_chosen(first))
      throw UserError("--fix {0}: was looked for with {1} mended; allowed: {1},{0}",
                      name_of(f.kind), name_of(first));
  };
  for (const Finding* f : chosen) {
    if (f->kind == FindingKind::kOutOfOrder) continue;
    require_first(FindingKind::kOutOfOrder, *f);
    if (f->kind != FindingKind::kHeld && f->kind != FindingKind::kWrap)
      require_first(FindingKind::kHeld, *f);
    if (f->kind == FindingKind::kLost)
      for (const FindingKind first :
           {FindingKind::kDuplicate, FindingKind::kGap, FindingKind::kUneven})
        require_first(first, *f);
  }
  std::ranges::stable_sort(chosen, {}, [](const Finding* f) { return order_of(f->kind); });

  Dataset repaired = std::move(d);
  std::optional<FindingKind> last;  // findings of one kind that are mended by one sweep
  for (const Finding* f : chosen) {
    const bool sweeps = f->kind == FindingKind::kGap || f->kind == FindingKind::kVelocity;
    if (sweeps && f->kind == last) continue;
    apply(repaired, *f);
    last = f->kind;
  }
  for (const FindingKind kind : kinds)
    if (is_chosen(kind)) repaired.source += fmt::format("; fixed {}", name_of(kind));
  return repaired;
}

}  // namespace fricid::doctor
