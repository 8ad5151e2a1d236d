#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include "check_times.hpp"
#include "columns_of_joints.hpp"
#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_reader.hpp"
#include "fricid/data/sample_times.hpp"
#include "fricid/data/uneven_times.hpp"
#include "logs/columns.hpp"
#include "units.hpp"

namespace fricid::data {

using Names = std::vector<std::string>;

Names expand_pattern(const Names& columns, const Names& joint_names) {
  if (columns.size() != 1) return columns;
  const std::string& pattern = columns[0];
  for (const std::string_view hole : {"{}", "{0}", "{name}"}) {
    const std::size_t at = pattern.find(hole);
    if (at == std::string::npos) continue;
    Names expanded;
    for (std::size_t j = 0; j < joint_names.size(); ++j) {
      const std::string filling = hole == "{}"    ? std::to_string(j + 1)
                                  : hole == "{0}" ? std::to_string(j)
                                                  : joint_names[j];
      expanded.push_back(pattern.substr(0, at) + filling + pattern.substr(at + hole.size()));
    }
    return expanded;
  }
  return columns;
}

bool at_motor(std::string_view unit) { return unit.starts_with("motor_"); }
bool counts_at_motor(std::string_view kind) { return kind == "motor_torque" || kind == "current"; }

namespace {

constexpr const char* kTorqueFrom = ", tau from ";  // in a source, before the kind

constexpr double kMeasured = 0.5;  // probability, before the data are looked at

// Rates at which the motion of a robot is logged [Hz]: beyond them the unit of the times is wrong.
constexpr double kSlowest = 1, kFastest = 1e5;

double per_second(std::string_view unit) {
  return unit == "s" ? 1 : unit == "ms" ? 1e3 : unit == "us" ? 1e6 : 1e9;
}

void require_plausible_rate(double rate_hz, const TimeColumn& time, const std::string& where) {
  if (rate_hz > kSlowest && rate_hz <= kFastest) return;
  if (!std::isfinite(rate_hz))
    throw UserError(
        "{}: most rows have the time of the one before, and too few have a new one to tell the "
        "rate; allowed: a time with more digits",
        where);
  constexpr double kUsual = 1e4;  // [Hz]
  std::string remedy;
  for (const char* unit : {"s", "ms", "us", "ns"})
    if (const double rate = rate_hz * per_second(unit) / per_second(time.unit);
        remedy.empty() && rate > kSlowest && rate <= kUsual)
      remedy = fmt::format("; if {} is in {}, say [time] unit = \"{}\" in the contract",
                           time.column, unit, unit);
  throw UserError("{}: samples {:.4g} s apart; allowed: more than 1e-05 s, less than 1 s{}", where,
                  1 / rate_hz, remedy);
}

double radians(std::string_view unit) {
  return unit.ends_with("deg") ? std::numbers::pi / 180 : 1.0;
}

char separator_of(const std::string& name) {
  return name == "comma"       ? ','
         : name == "semicolon" ? ';'
         : name == "tab"       ? '\t'
         : name == "space"     ? ' '
                               : '\0';
}

// A rate, exactly whole where it is within a part in a million.
double whole_rate(double rate) {
  const double whole = std::round(rate);
  return std::abs(rate - whole) < 1e-6 * whole ? whole : rate;
}

// The most rows in which the clock does not begin again.
Eigen::VectorXd longest_rise(const Eigen::VectorXd& t) {
  constexpr double kBack = 0.1;  // [s]
  Eigen::Index first = 0, begin = 0, count = 0;
  for (Eigen::Index k = 1; k <= t.size(); ++k) {
    if (k < t.size() && t[k - 1] - t[k] <= kBack) continue;
    if (k - first > count) begin = first, count = k - first;
    first = k;
  }
  return t.segment(begin, count);
}

/// Whether most rows with the time of the row before are copies of it.
bool repeats_are_copies(const Dataset& d) {
  Eigen::Index repeats = 0, copies = 0;
  for (Eigen::Index k = 1; k < d.t.size(); ++k) {
    if (d.t[k] != d.t[k - 1]) continue;
    ++repeats;
    copies += d.q.row(k) == d.q.row(k - 1) && d.tau.row(k) == d.tau.row(k - 1);
  }
  return 2 * copies > repeats;
}

// Rate of the samples.
double rate_of(const Dataset& d) {
  const Eigen::VectorXd& t = d.t;
  std::vector<double> periods;
  for (int k = 1; k < t.size(); ++k) periods.push_back(t[k] - t[k - 1]);
  const auto usual = [&] {
    const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
    std::nth_element(periods.begin(), middle, periods.end());
    return periods.empty() ? 0 : *middle;
  };
  double period = usual();
  if (period == 0 && repeats_are_copies(d)) {  // rows that are no samples of their own
    std::erase(periods, 0);
    period = usual();
  }
  // Stamps may be rounded, 3, 3, 4, 3, 3, 4 ms at 300 Hz: what is no gap and no repeat counts in
  // the mean.
  constexpr int kPasses = 2;
  for (int pass = 0; pass < kPasses; ++pass) {
    double sum = 0, count = 0;
    for (const double dt : periods)
      if (std::abs(dt - period) < 0.5 * period) sum += dt, ++count;
    if (count > 0) period = sum / count;
  }
  return whole_rate(period > 0 ? rate_by_line(longest_rise(t), 1 / period) : 1 / period);
}

bool has(const Names& names, const std::string& name) {
  return std::any_of(names.begin(), names.end(), [&](const std::string& known) {
    return lower_case(known) == lower_case(name);
  });
}

// The first of the alternatives "a{}|b{}" whose columns the file has; else the first.
Names columns_by_default(std::string_view alternatives, const Names& joints, const Names& names) {
  Names first;
  while (!alternatives.empty()) {
    const std::size_t end = std::min(alternatives.find('|'), alternatives.size());
    const Names columns = expand_pattern({std::string(alternatives.substr(0, end))}, joints);
    if (std::all_of(columns.begin(), columns.end(),
                    [&](const std::string& c) { return has(names, c); }))
      return columns;
    if (first.empty()) first = columns;
    alternatives.remove_prefix(std::min(end + 1, alternatives.size()));
  }
  return first;
}

// The contract with the columns that the format has of its own filled in.
Contract completed(Contract contract, const LogReader& reader, const Names& names,
                   const std::string& file) {
  const LogDefaults& own = reader.defaults;
  if (!own.time.empty() && contract.time.column == TimeColumn{}.column &&
      !has(names, contract.time.column)) {
    contract.time.column = columns_by_default(own.time, {"t"}, names)[0];
    contract.time.unit = own.time_unit;
  }
  if (contract.position.columns.empty()) {
    contract.position.columns = columns_by_default(own.position, contract.joint_names, names);
    contract.position.unit = own.position_unit;
    const bool geared = std::any_of(contract.gear_ratio.begin(), contract.gear_ratio.end(),
                                    [](double ratio) { return ratio != 1; });
    if (at_motor(contract.position.unit) && !geared)
      throw UserError("{}: gear_ratio is missing in the contract; {} gives motor angles", file,
                      reader.name);
  }
  if (contract.velocity.columns.empty() && !own.velocity.empty()) {
    const Names columns = columns_by_default(own.velocity, contract.joint_names, names);
    if (std::all_of(columns.begin(), columns.end(),
                    [&](const std::string& c) { return has(names, c); })) {
      contract.velocity.columns = columns;
      contract.velocity.unit = own.velocity_unit;
    }
  }
  return contract;
}

/// Takes the columns of a table, group by group, and frees them.
class Columns {
 public:
  Columns(LogTable& table, const Names& wanted, const std::string& file)
      : table_(table), wanted_(wanted), file_(file) {}

  std::string place_of(int k) const {
    return table_.lines.empty()
               ? fmt::format("{}: sample {}", file_, k)
               : fmt::format("{}:{}", file_, table_.lines[static_cast<std::size_t>(k)]);
  }
  /// (T, n) with value = factor_j raw + offset_j.
  template <class Factor, class Offset>
  RowMatrix take(int n, const Factor& factor, const Offset& offset) {
    const auto length = static_cast<Eigen::Index>(table_.columns[next_].size());
    RowMatrix values(length, n);
    for (int j = 0; j < n; ++j) {
      const auto joint = static_cast<std::size_t>(j);
      std::vector<double>& column = table_.columns[next_];
      for (int k = 0; k < static_cast<int>(length); ++k) {
        const double raw = column[static_cast<std::size_t>(k)];
        if (std::isinf(raw))
          throw UserError("{}: {} = {}; allowed: finite, or nan where missing", place_of(k),
                          wanted_[next_], raw);
        values(k, j) = factor(joint) * raw + offset(joint);
      }
      column = {};
      ++next_;
    }
    return values;
  }

 private:
  LogTable& table_;
  const Names& wanted_;
  const std::string& file_;
  std::size_t next_ = 0;
};

/// The torque at t_k becomes that logged at t_k + delay, on a straight line between two samples,
/// missing across a gap. Rows whose torque was not logged go.
/// @param lines  of the rows, or empty
void move_torque_back(Dataset& d, double delay, std::vector<int>& lines) {
  const double first = d.t.minCoeff(), last = d.t.maxCoeff();
  const RowMatrix logged = d.tau;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < d.t.size(); ++k) {
    const double wanted = d.t[k] + delay;
    if (wanted < first || wanted > last) continue;
    kept.push_back(k);
    Eigen::Index i = std::min(k, d.t.size() - 2);  // the sample at or before `wanted`
    while (i > 0 && d.t[i] > wanted) --i;
    while (i + 2 < d.t.size() && d.t[i + 1] <= wanted) ++i;
    const double period = d.t[i + 1] - d.t[i], share = (wanted - d.t[i]) / period;
    if (share == 0)
      d.tau.row(k) = logged.row(i);
    else if (share > 0 && share <= 1 && period <= kGap / d.rate_hz)
      d.tau.row(k) = (1 - share) * logged.row(i) + share * logged.row(i + 1);
    else
      d.tau.row(k).setConstant(kNan);
  }
  for (RowMatrix* table : {&d.q, &d.v, &d.tau, &d.temperature})
    if (table->size() > 0) *table = RowMatrix((*table)(kept, Eigen::all));
  d.t = Eigen::VectorXd(d.t(kept));
  d.t.array() -= d.t[0];
  if (!lines.empty()) {
    for (std::size_t i = 0; i < kept.size(); ++i)
      lines[i] = lines[static_cast<std::size_t>(kept[i])];
    lines.resize(kept.size());
  }
}

void make_even(Dataset& d) {
  d.t = Eigen::VectorXd::LinSpaced(d.length(), 0, d.length() - 1) / d.rate_hz;
}

// Makes the times of a clock that is coarser than the samples even.
// @return whether it is one
bool even_out_steps(Dataset& d, const std::string& file, const Warn& warn) {
  const std::optional<CoarseClock> clock = coarse_clock(d);
  if (!clock) return false;
  const std::string size = fmt::format("{:.4g} ms", 1e3 * clock->step_s);
  if (!clock->fits_even)
    throw UserError(
        "{}: time stamps in steps of {}, coarser than the samples, of which some are missed or "
        "uneven; allowed: a time with more digits",
        file, size);
  d.rate_hz = whole_rate(clock->rate_hz);
  make_even(d);
  d.source += fmt::format(", times in steps of {} made even", size);
  if (warn)
    warn(
        fmt::format("{}: time stamps in steps of {}, coarser than the samples: these are taken as "
                    "even, {:.7g} Hz; log the time with more digits",
                    file, size, d.rate_hz));
  return true;
}

// Makes times that jitter a little even. Samples that were taken at their stamps are interpolated.
// @return whether rows are still those of the file
bool even_out(Dataset& d, const std::string& file, const Warn& warn) {
  if (!is_slight_jitter(d.t, d.rate_hz)) return true;
  const std::string size =
      fmt::format("{:.2g} % rms", 100 * d.rate_hz * quality_of_clock(d.t, d.rate_hz).jitter_s);
  const bool at_stamps = taken(d) == Taken::kAtStamps;
  if (at_stamps)
    d = at_even_times(std::move(d));
  else
    make_even(d);
  d.source +=
      fmt::format(", periods that varied by {} {}", size, at_stamps ? "interpolated" : "made even");
  if (warn)
    warn(fmt::format("{}: periods vary by {}: {}", file, size,
                     at_stamps ? "the motion is smooth by the stamps, interpolated at even times"
                               : "samples are taken as even"));
  return !at_stamps;
}

Dataset read(const std::filesystem::path& path, const Contract& given, std::vector<int>& lines,
             const Warn& warn) {
  const std::string file = path.string();
  const LogReader& reader = reader_for(path, given.format, given.skip_rows);
  const LogStyle style{separator_of(given.separator), given.decimal_comma, given.topic,
                       given.skip_rows};
  const Names names = reader.names(path, style);
  const Contract contract = completed(given, reader, names, file);
  const int n = contract.n();
  Names wanted{contract.time.column};
  for (const Names* columns : {&contract.position.columns, &contract.torque.columns,
                               &contract.velocity.columns, &contract.temperature.columns})
    wanted.insert(wanted.end(), columns->begin(), columns->end());
  LogTable table = reader.read(path, wanted, style);
  check_units(table, contract, file);
  const int length = static_cast<int>(table.columns[0].size());
  if (length < 2) throw UserError("{}: {} rows of numbers; allowed: at least 2", file, length);

  Dataset d;
  d.name = path.stem().string();
  require_name(Named::kTrajectory, d.name, path.string());
  d.joint_names = contract.joint_names;
  d.source = "import " + path.filename().string();
  if (contract.torque.kind != "joint_torque") d.source += kTorqueFrom + contract.torque.kind;
  Columns columns(table, wanted, file);
  const double second = per_second(contract.time.unit);
  d.t = Eigen::Map<const Eigen::VectorXd>(table.columns[0].data(), length);
  d.t = ((d.t.array() - d.t[0]) / second).eval();
  for (int k = 0; k < length; ++k)
    if (!std::isfinite(d.t[k]))
      throw UserError("{}: t = {}; allowed: a finite time", columns.place_of(k), d.t[k]);
  const auto zero = [](std::size_t) { return 0.0; };
  columns.take(
      1, [](std::size_t) { return 1.0; }, zero);

  // joint angles from motor angles in joint units: q = A m
  const Eigen::MatrixXd A = dynamics::joints_of_motors(couplings_of(contract), n);
  const bool coupled = !contract.couplings.empty();
  const auto take_motion = [&](const MotionColumns& motion) {
    const bool motor = at_motor(motion.unit);
    RowMatrix values = columns.take(
        n,
        [&](std::size_t j) {
          return motion.sign[j] * motion.scale[j] * radians(motion.unit) /
                 (motor ? contract.gear_ratio[j] : 1.0);
        },
        zero);
    if (motor && coupled) values = (values * A.transpose()).eval();
    return values;
  };
  d.q = take_motion(contract.position);
  for (int j = 0; j < n; ++j)
    if (const double offset = contract.position.offset_rad[static_cast<std::size_t>(j)];
        offset != 0)
      d.q.col(j).array() += offset;
  const TorqueColumns& torque = contract.torque;
  const bool motor = counts_at_motor(torque.kind);
  d.tau = columns.take(
      n,
      [&](std::size_t j) {
        const double constant = torque.kind == "current" ? torque.torque_constant[j] : 1.0;
        return torque.sign[j] * torque.scale[j] * (torque.percent_of[j] / 100) * constant *
               (motor ? contract.gear_ratio[j] : 1.0);
      },
      zero);
  if (motor && coupled) d.tau = (d.tau * A.inverse()).eval();
  if (!contract.velocity.columns.empty()) d.v = take_motion(contract.velocity);
  if (!contract.temperature.columns.empty())
    d.temperature = columns.take(
        n, [](std::size_t) { return 1.0; },
        [&](std::size_t) { return contract.temperature.unit == "C" ? 273.15 : 0.0; });
  const bool was_coarse = even_out_steps(d, file, warn);
  if (!was_coarse) d.rate_hz = rate_of(d);
  require_plausible_rate(d.rate_hz, contract.time, columns.place_of(1));
  if (was_coarse || even_out(d, file, warn)) lines = std::move(table.lines);
  if (torque.delay_s != 0) {
    if (std::abs(torque.delay_s) > (d.t.maxCoeff() - d.t.minCoeff()) / 2)
      throw UserError("{}: [torque] delay_s = {} of a log of {:.4g} s; allowed: at most half of it",
                      file, torque.delay_s, d.t.maxCoeff() - d.t.minCoeff());
    move_torque_back(d, torque.delay_s, lines);
    d.source += fmt::format(", tau moved back by {} s", torque.delay_s);
  }
  if (torque.timing == "measured") d = held_between_samples(std::move(d));
  if (torque.timing == "auto" && torque.delay_s == 0)
    d.torque_delay_sd = delay_sd_if_measured(kMeasured, d.dt());
  return d;
}

bool is_of_kind(const Dataset& dataset, const char* kind) {
  return dataset.source.find(kTorqueFrom + std::string(kind)) != std::string::npos;
}

/// Limits of a fit to torque of this kind; empty: none.
std::string_view warning_of_kind(std::string_view kind) {
  if (kind == "gear_torque_less_friction")
    return "the controller's friction model is not in the torque: what is identified is the "
           "friction that it lacks";
  if (kind == "link_torque")
    return "the torque is measured beyond the gear: what is identified is the friction beyond the "
           "sensor, not that of the gear";
  return "";
}

/// Words of the name of a column, in small letters: "target" and "q" of target_q_3 and TargetQ3.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words;
  bool in_word = false, after_small = false;
  for (const char c : name) {
    const bool capital = c >= 'A' && c <= 'Z', small = c >= 'a' && c <= 'z';
    if ((capital || small) && (!in_word || (capital && after_small))) words.emplace_back();
    in_word = capital || small;
    after_small = small;
    if (in_word) words.back() += capital ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return words;
}

/// The first column that by its name holds a position that was commanded; empty: none.
std::string commanded_position(const Contract& contract) {
  constexpr auto kCommanded =
      std::to_array<std::string_view>({"target", "cmd", "command", "commanded", "desired", "des",
                                       "setpoint", "reference", "ref", "soll", "goal", "planned"});
  for (const std::string& column : contract.position.columns)
    for (const std::string& word : words_of(column))
      if (std::ranges::count(kCommanded, word) > 0) return column;
  return "";
}

}  // namespace

std::vector<std::string> meaning_in_words(const Contract& contract, const std::string& file) {
  const std::string_view warning = warning_of_kind(contract.torque.kind);
  std::vector<std::string> lines{
      fmt::format("{}: torque.kind = \"{}\": {}", file, contract.torque.kind,
                  warning.empty() ? "taken as motor torque times gear ratio" : warning)};
  if (const std::string column = commanded_position(contract); !column.empty())
    lines.push_back(fmt::format(
        "{}: position.columns has \"{}\", by its name a position that was commanded: along it the "
        "friction of slow motion comes out wrong; name the columns of the measured position",
        file, column));
  return lines;
}

std::string_view warning_of_torque(const Dataset& dataset) {
  for (const char* kind : {"gear_torque_less_friction", "link_torque"})
    if (is_of_kind(dataset, kind)) return warning_of_kind(kind);
  return "";
}

bool is_link_torque(const Dataset& dataset) { return is_of_kind(dataset, "link_torque"); }

Dataset read_log(const std::filesystem::path& path, const Contract& contract, const Warn& warn) {
  std::vector<int> lines;
  return read(path, contract, lines, warn);
}

Dataset import_log(const std::filesystem::path& path, const Contract& contract, const Warn& warn) {
  std::vector<int> lines;
  Dataset d = read(path, contract, lines, warn);
  try {
    check_times(d.t, d.rate_hz, [&](int k) {
      return lines.empty()
                 ? fmt::format("{}: sample {}", path.string(), k)
                 : fmt::format("{}:{}", path.string(), lines[static_cast<std::size_t>(k)]);
    });
  } catch (const UserError& error) {
    throw UserError("{}; `fricid check` lists what `fricid import --fix` repairs", error.what());
  }
  check_dataset(d, path.string());
  return d;
}

}  // namespace fricid::data
