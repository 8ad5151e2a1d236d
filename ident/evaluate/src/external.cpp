#include "fricid/evaluate/external.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/csv.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/json.hpp"
#include "fricid/base/lines.hpp"
#include "fricid/base/names.hpp"
#include "fricid/data/log_reader.hpp"

namespace fricid::evaluate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::string_view kFormat = "fricid.external/1";
constexpr std::string_view kKeys[] = {"format", "label", "parameters", "fit_seconds"};
constexpr double kSameTime = 0.01;   // of a sample period, as in data sets
constexpr double kSameState = 1e-6;  // [rad], [rad/s]: what six decimals of a text file keep

std::string rollout_name(const Trajectory& trajectory, const Start& start) {
  return fmt::format("{}_{}", trajectory.data.name, start.begin);
}

/// "q1", "q2", ...; "q" of a single joint.
std::string column(const char* signal, int joint, int n) {
  return n > 1 ? fmt::format("{}{}", signal, joint + 1) : signal;
}

// ---- model.json

/// "file:line" of a key; the file alone where it has no such key.
std::string place(const std::string& file, std::string_view text, std::string_view key) {
  const std::size_t at = text.find(fmt::format("\"{}\"", key));
  return at == std::string_view::npos ? file : fmt::format("{}:{}", file, line_at(text, at));
}

ExternalModel read_description(const fs::path& path) {
  const std::string file = path.string(), text = read_file(path);
  const auto root = parse_json<Json>(text, file);
  if (!root.is_object())
    throw UserError("{}: found no object; allowed keys: {}", file, fmt::join(kKeys, ", "));
  const auto refuse = [&](std::string_view key, const char* allowed) {
    throw UserError("{}: {} = {}; allowed: {}", place(file, text, key), key,
                    root.contains(key) ? shown(root.at(std::string(key))) : "nothing", allowed);
  };
  for (const auto& [key, value] : root.items())
    if (std::find(std::begin(kKeys), std::end(kKeys), key) == std::end(kKeys))
      throw UserError("{}: unknown key \"{}\"; allowed: {}", place(file, text, key), key,
                      fmt::join(kKeys, ", "));
  if (root.value("format", Json()) != kFormat) refuse("format", "\"fricid.external/1\"");

  ExternalModel model;
  model.name = path.parent_path().filename().string();
  require_name(Named::kModel, model.name, file);
  const Json label = root.value("label", Json()), parameters = root.value("parameters", Json()),
             seconds = root.value("fit_seconds", Json());
  if (label.is_string()) model.label = label.get<std::string>();
  if (model.label.empty()) refuse("label", "a line of text");
  require_label(model.label, "label", place(file, text, "label"));
  if (!parameters.is_number_unsigned() || parameters.get<std::uint64_t>() > 1'000'000'000)
    refuse("parameters", "a whole number from 0 to 1e9");
  if (!seconds.is_number() || !(seconds.get<double>() >= 0)) refuse("fit_seconds", "0 or more [s]");
  model.parameters = parameters.get<int>();
  model.fit_seconds = seconds.get<double>();
  return model;
}

// ---- rollouts

/// Signals of a file as they are there; `lines` is empty where they have none.
struct Signals {
  std::string file;
  Eigen::VectorXd t;
  RowMatrix q, v;
  RowMatrix tau_f;  ///< or empty
  std::vector<int> lines;

  std::string at(Eigen::Index row) const {
    return lines.empty() ? fmt::format("{}: row {}", file, row + 1)
                         : fmt::format("{}:{}", file, lines[static_cast<std::size_t>(row)]);
  }
};

Signals read_csv(const fs::path& path, int n) {
  const data::LogReader& reader = data::reader_for(path, "csv");
  const std::vector<std::string> names = reader.names(path, {});
  const bool has_friction =
      std::find(names.begin(), names.end(), column("tau_f", 0, n)) != names.end();
  std::vector<std::string> wanted{"t"};
  for (const char* signal : {"q", "v", "tau_f"})
    for (int j = 0; j < n && (has_friction || *signal != 't'); ++j)
      wanted.push_back(column(signal, j, n));
  const data::LogTable table = reader.read(path, wanted, {});
  const auto rows = static_cast<Eigen::Index>(table.lines.size());
  const auto columns = [&](int first, int count) {
    RowMatrix values(rows, count);
    for (int j = 0; j < count; ++j)
      values.col(j) = Eigen::Map<const Eigen::VectorXd>(
          table.columns[static_cast<std::size_t>(first + j)].data(), rows);
    return values;
  };
  return {path.string(),
          columns(0, 1),
          columns(1, n),
          columns(1 + n, n),
          has_friction ? columns(1 + 2 * n, n) : RowMatrix(),
          table.lines};
}

Signals read_hdf5(const fs::path& path, int n) {
  RolloutSignals rollout = load_rollout(path, n);
  return {path.string(),        std::move(rollout.t),     std::move(rollout.q),
          std::move(rollout.v), std::move(rollout.tau_f), {}};
}

Signals read_signals(const fs::path& stem, int n) {
  const fs::path csv = stem.string() + ".csv", hdf5 = stem.string() + ".h5";
  if (fs::exists(csv) && fs::exists(hdf5))
    throw UserError("{}: found beside {}; allowed: one of them", csv.string(),
                    hdf5.filename().string());
  if (fs::exists(csv)) return read_csv(csv, n);
  if (fs::exists(hdf5)) return read_hdf5(hdf5, n);
  throw UserError("{}: no such file, nor {}; allowed: one rollout per line of starts.csv",
                  csv.string(), hdf5.filename().string());
}

void check_times(const Signals& signals, const Trajectory& trajectory, const Start& start) {
  const data::Dataset& data = trajectory.data;
  const Eigen::Index rows = start.steps + 1, found = signals.t.size();
  if (found != rows)
    throw UserError("{}: {} rows; allowed: {}, as starts.csv says",
                    found > 0 && !signals.lines.empty() ? signals.at(found - 1) : signals.file,
                    found, rows);
  for (Eigen::Index k = 0; k < rows; ++k)
    if (const double t = data.t[start.begin + k];
        !(std::abs(signals.t[k] - t) <= kSameTime * data.dt()))
      throw UserError("{}: t = {:.10g} s; allowed: {:.10g}, as in {}", signals.at(k), signals.t[k],
                      t, data.name);
}

void check_start(const char* signal, const RowMatrix& values, const RowMatrix& planned,
                 const Signals& signals, const Start& start) {
  const auto n = static_cast<int>(values.cols());
  for (int j = 0; j < n; ++j)
    if (const double wanted = planned(start.begin, j);
        !(std::abs(values(0, j) - wanted) <= kSameState))
      throw UserError("{}: {} = {:.10g}; allowed: {:.10g}, where starts.csv says to start",
                      signals.at(0), column(signal, j, n), values(0, j), wanted);
}

/// Before a rollout diverges, a friction torque that is given must be there.
void check_friction(const Signals& signals) {
  for (Eigen::Index k = 0; k < signals.q.rows(); ++k) {
    if (!signals.q.row(k).allFinite() || !signals.v.row(k).allFinite()) return;
    for (int j = 0; j < signals.tau_f.cols(); ++j)
      if (!std::isfinite(signals.tau_f(k, j)))
        throw UserError("{}: {} = {}; allowed: a number", signals.at(k),
                        column("tau_f", j, static_cast<int>(signals.tau_f.cols())),
                        signals.tau_f(k, j));
  }
}

Rollout planned_rollout(const fs::path& folder, const Trajectory& trajectory, const Start& start) {
  Signals signals = read_signals(folder / rollout_name(trajectory, start), trajectory.data.n());
  check_times(signals, trajectory, start);
  check_start("q", signals.q, trajectory.start_q(), signals, start);
  check_start("v", signals.v, trajectory.start_v(), signals, start);
  check_friction(signals);
  return {start, false, std::move(signals.q), std::move(signals.v), std::move(signals.tau_f)};
}

}  // namespace

std::string starts_csv(std::span<const Trajectory> trajectories, std::span<const Start> starts) {
  const int n = trajectories.empty() ? 0 : trajectories.front().data.n();
  std::string text = "rollout,trajectory,begin,t,rows";
  for (const char* signal : {"q", "v"})
    for (int j = 0; j < n; ++j) text += fmt::format(",{}", column(signal, j, n));
  for (const Start& start : starts) {
    const Trajectory& trajectory = trajectories[static_cast<std::size_t>(start.trajectory)];
    text += fmt::format("\n{},{},{},{},{}", csv_cell(rollout_name(trajectory, start), false),
                        csv_cell(trajectory.data.name, false), start.begin,
                        trajectory.data.t[start.begin], start.steps + 1);
    for (const RowMatrix* state : {&trajectory.start_q(), &trajectory.start_v()})
      for (int j = 0; j < n; ++j) text += fmt::format(",{}", (*state)(start.begin, j));
  }
  return text + "\n";
}

ExternalModel load_external_model(const fs::path& folder, std::span<const Trajectory> trajectories,
                                  std::span<const Start> starts) {
  ExternalModel model = read_description(folder / "model.json");
  for (const Start& start : starts)
    model.rollouts.push_back(
        planned_rollout(folder, trajectories[static_cast<std::size_t>(start.trajectory)], start));
  return model;
}

}  // namespace fricid::evaluate
