// Prints the table of docs/doctor.md: what the doctor finds of damage put into simulated logs.
//
//     fricid_doctor_table [LOGS_PER_KIND] [TEXT] [-v]
//
// With TEXT: the kinds alone that have it in their name. Arms and rates go round, so that every
// kind of damage meets every arm; -v lists what was missed and what was said of nothing.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string_view>
#include <vector>

#include "doctor/injected.hpp"
#include "fricid/base/parallel.hpp"

namespace fricid::doctor {
namespace {

constexpr int kEvery[] = {1, 2, 4, 8, 10};  // of 1 kHz

/// One row of the table.
struct Row {
  int logs = 0, found = 0, alarmed = 0;
};

/// Delays put into logs of one rate.
struct Delays {
  int logs = 0;
  std::vector<double> errors;  // of those found, their size [samples]
};

struct Case {
  std::string text;
  Injected truth;
  Judged judged;
  double rate_hz = 0;
  bool counts = false;  // the log can have this damage
};

Case examine(std::size_t kind, int number, const std::vector<CleanLog>& logs) {
  const auto place = static_cast<std::size_t>(number) + kind;
  const CleanLog& clean = logs[place % logs.size()];
  const int every = kEvery[(place / logs.size() + place) % std::size(kEvery)];
  data::Dataset d = decimated(clean.data, every);
  dynamics::RobotModel robot = clean.robot;
  Rng rng(17, 1000 * kind + static_cast<std::uint64_t>(number));
  Case one;
  one.truth = injections()[kind].apply(d, robot, rng);
  one.rate_hz = d.rate_hz;
  one.counts = !one.truth.name.empty() || injections()[kind].harmless;
  // A torque that is held over a sample has no delay; every so many-th of them has.
  if (one.truth.name == "delay") one.truth.samples += 0.5 * (1 - 1. / every);
  one.judged = judge(d, robot, one.truth);
  one.text = fmt::format("{} at {:g} Hz, {}", clean.what, d.rate_hz, injections()[kind].what);
  if (one.truth.joint >= 0)
    one.text += " of " + d.joint_names[static_cast<std::size_t>(one.truth.joint)];
  if (one.truth.samples > 0) one.text += fmt::format(", {:.4g} samples", one.truth.samples);
  return one;
}

std::vector<CleanLog> clean_logs() {
  std::vector<CleanLog> logs(static_cast<std::size_t>(number_of_clean_logs()));
  parallel_for(number_of_clean_logs(), 0,
               [&](int i) { logs[static_cast<std::size_t>(i)] = simulate_log(i); });
  return logs;
}

void print_delays(const std::map<double, Delays>& of_rate) {
  if (of_rate.empty()) return;
  fmt::print(
      "\n| rate [Hz] | delays | found | within half a sample | median error [ms] | largest [ms] "
      "|\n|--:|--:|--:|--:|--:|--:|\n");
  for (const auto& [rate, delays] : of_rate) {
    std::vector<double> errors;
    for (const double error : delays.errors) errors.push_back(std::abs(error));
    std::ranges::sort(errors);
    const auto within = std::ranges::count_if(errors, [](double x) { return x <= 0.5; });
    const double ms = 1e3 / rate;
    fmt::print("| {:g} | {} | {} | {} | {} | {} |\n", rate, delays.logs, errors.size(), within,
               errors.empty() ? "" : fmt::format("{:.2f}", ms * errors[errors.size() / 2]),
               errors.empty() ? "" : fmt::format("{:.2f}", ms * errors.back()));
  }
}

int print_table(int per_kind, bool verbose, const std::string& only) {
  const std::vector<CleanLog> logs = clean_logs();
  const auto& kinds = injections();
  fmt::print("| damage | logs | found | other damage named |\n|---|--:|--:|--:|\n");
  std::map<double, Delays> delays;
  int count = 0;
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    if (kinds[kind].what.find(only) == std::string::npos) continue;
    const int number = kinds[kind].harmless ? 2 * per_kind : per_kind;
    std::vector<Case> cases(static_cast<std::size_t>(number));
    parallel_for(number, 0,
                 [&](int i) { cases[static_cast<std::size_t>(i)] = examine(kind, i, logs); });
    Row row;
    for (const Case& one : cases) {
      if (!one.counts) continue;
      ++row.logs;
      row.found += one.judged.found;
      row.alarmed += one.judged.others > 0;
      if (one.truth.name == "delay") {
        Delays& of_rate = delays[one.rate_hz];
        ++of_rate.logs;
        if (one.judged.found) of_rate.errors.push_back(one.judged.delay_error);
      }
      const bool right = one.judged.others == 0 && (one.judged.found || kinds[kind].harmless);
      if (verbose && !right) fmt::print(stderr, "{}:\n{}", one.text, one.judged.said);
    }
    count += row.logs;
    fmt::print("| {} | {} | {} | {} |\n", kinds[kind].what, row.logs,
               kinds[kind].harmless ? "" : std::to_string(row.found), row.alarmed);
  }
  print_delays(delays);
  fmt::print("\n{} logs.\n", count);
  return 0;
}

}  // namespace
}  // namespace fricid::doctor

int main(int argc, char** argv) {
  int per_kind = 8;
  bool verbose = false;
  std::string only;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "-v")
      verbose = true;
    else if (const int number = std::atoi(argv[i]); number > 0)
      per_kind = number;
    else
      only = argv[i];
  }
  return fricid::doctor::print_table(per_kind, verbose, only);
}
