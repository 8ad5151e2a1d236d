#include "fricid/evaluate/compensation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/evaluate/reversals.hpp"
#include "fricid/evaluate/statistics.hpp"
#include "markdown.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kSwing = 5e-5;   // [rad] of a limit cycle, from turn to turn
constexpr double kWatched = 2;    // [s] at the end of the rest
constexpr int kFewestSwings = 4;  // in that time

/// Mean of squares.
struct Squares {
  double sum = 0;
  int count = 0;
  void add(double x) {
    sum += x * x;
    ++count;
  }
  double root() const {
    return count > 0 ? std::sqrt(sum / count) : std::numeric_limits<double>::quiet_NaN();
  }
};

/// Turns of a signal that are at least `swing` apart.
int turns(const Eigen::Ref<const Eigen::VectorXd>& x, double swing) {
  int count = 0;
  double extreme = x.size() > 0 ? x[0] : 0, direction = 0;
  for (const double now : x) {
    const double away = now - extreme;
    if (direction == 0 ? std::abs(away) >= swing : away * direction <= -swing) {
      if (direction != 0) ++count;
      direction = away > 0 ? 1 : -1;
      extreme = now;
    } else if (away * direction > 0) {
      extreme = now;
    }
  }
  return count;
}

/// The loops of a table in their order: one per column.
struct Condition {
  int path, controller;
  double bandwidth_hz, peak_rad_s;
};

std::vector<Condition> conditions(const CompensationFile& file) {
  std::vector<Condition> found;
  for (const LoopScore& loop : file.loops)
    if (std::ranges::none_of(found, [&](const Condition& c) {
          return c.path == loop.path && c.controller == loop.controller;
        }))
      found.push_back({loop.path, loop.controller, loop.bandwidth_hz, loop.peak_rad_s});
  return found;
}

template <class Value>
std::vector<Value> distinct(const CompensationFile& file, Value LoopScore::*field) {
  std::vector<Value> found;
  for (const LoopScore& loop : file.loops)
    if (std::ranges::find(found, loop.*field) == found.end()) found.push_back(loop.*field);
  return found;
}

const LoopScore* find(const CompensationFile& file, std::string_view model, double gain,
                      const Condition& at) {
  for (const LoopScore& loop : file.loops)
    if (loop.model == model && (loop.model == kNoModel || loop.gain == gain) &&
        loop.path == at.path && loop.controller == at.controller)
      return &loop;
  return nullptr;
}

std::string_view label_of(const CompensationFile& file, std::string_view model) {
  return std::ranges::find(file.loops, model, &LoopScore::model)->label;
}

/// One row per model, one column per path and bandwidth.
Markdown table(const CompensationFile& file, double gain, const Markdown& title,
               Markdown (*cell)(const LoopScore&), bool with_ratios) {
  std::vector<Cells> rows{{title}};
  for (const Condition& at : conditions(file))
    rows[0].push_back(Markdown::of("{:.2g} rad/s, {:g} Hz", at.peak_rad_s, at.bandwidth_hz));
  if (with_ratios) {
    rows[0].push_back(Markdown::of("/ none"));
    rows[0].push_back(Markdown::of("/ truth"));
  }
  for (const std::string& model : distinct(file, &LoopScore::model)) {
    Cells& row = rows.emplace_back(Cells{escaped(label_of(file, model))});
    for (const Condition& at : conditions(file)) {
      const LoopScore* loop = find(file, model, gain, at);
      row.push_back(loop == nullptr  ? Markdown::of("–")
                    : loop->diverged ? Markdown::of("diverged")
                                     : cell(*loop));
    }
    if (!with_ratios) continue;
    for (const char* other : {kNoModel, kTruthModel})
      row.push_back(digits(reversal_ratio(file, model, gain, other)));
  }
  return markdown_table(rows);
}

}  // namespace

double rms(const std::vector<double>& of_joints) {
  Squares squares;
  for (const double value : of_joints)
    if (std::isfinite(value)) squares.add(value);
  return squares.root();
}

LoopScore score_loop(const data::LoopSignals& loop, double path_s) {
  const Eigen::Index T = loop.t.size();
  const double dt = T > 1 ? loop.t[1] - loop.t[0] : 1;
  const auto path = std::min<Eigen::Index>(T, std::lround(path_s / dt));
  LoopScore score;
  if (path > 0) score.peak_rad_s = loop.v_desired.topRows(path).cwiseAbs().maxCoeff();
  for (Eigen::Index j = 0; j < loop.q.cols(); ++j) {
    Squares reversal, sliding;
    const std::vector<bool> after = after_reversals(loop.v_desired.topRows(path), j, dt);
    for (Eigen::Index k = 0; k < path; ++k)
      (after[static_cast<std::size_t>(k)] ? reversal : sliding)
          .add(loop.q(k, j) - loop.q_desired(k, j));
    score.reversal_rad.push_back(reversal.root());
    score.sliding_rad.push_back(sliding.root());
    const auto watched = std::min<Eigen::Index>(std::lround(kWatched / dt), T - path);
    if (turns(loop.q.col(j).tail(watched), kSwing) >= kFewestSwings)
      score.limit_cycles.push_back(loop.joint_names[static_cast<std::size_t>(j)]);
  }
  score.feedback_J =
      dt * (loop.tau_feedback.topRows(path).array() * loop.v.topRows(path).array()).abs().sum();
  return score;
}

double reversal_ratio(const CompensationFile& file, std::string_view model, double gain,
                      std::string_view other) {
  std::vector<double> ratios;
  for (const Condition& at : conditions(file)) {
    const LoopScore *own = find(file, model, gain, at), *base = find(file, other, gain, at);
    if (own == nullptr || base == nullptr || own->diverged || base->diverged) continue;
    ratios.push_back(rms(own->reversal_rad) / rms(base->reversal_rad));
  }
  return geometric_mean(ratios);
}

std::string to_markdown(const CompensationFile& file) {
  const auto all_gains = distinct(file, &LoopScore::gain);
  std::vector<double> gains;
  for (const double gain : all_gains)
    if (std::ranges::any_of(file.loops, [&](const LoopScore& loop) {
          return loop.model != kNoModel && loop.gain == gain;
        }))
      gains.push_back(gain);
  if (gains.empty()) return {};
  Markdown all;
  for (const double gain : gains)
    all += Markdown::of("{}{:g}", gain == gains.front() ? Markdown() : Markdown::of(" and "), gain);
  Markdown text = Markdown::of(
      "Friction fed forward, its states driven by the {} motion, gain {}. Columns: fastest speed "
      "of the path, bandwidth of the controller. Ratios at reversals: geometric mean over "
      "them.\n\n",
      escaped(file.drive), all);
  const auto at = [&](double gain) {
    return gains.size() > 1 ? Markdown::of(", gain {:g}", gain) : Markdown();
  };
  for (const double gain : gains) {
    text += table(
        file, gain, Markdown::of("RMS at reversals [mrad]{}", at(gain)),
        [](const LoopScore& loop) { return digits(1e3 * rms(loop.reversal_rad)); }, true);
    text += Markdown::of("\n");
  }
  for (const double gain : gains) {
    text += table(
        file, gain, Markdown::of("RMS in sliding [mrad]{}", at(gain)),
        [](const LoopScore& loop) { return digits(1e3 * rms(loop.sliding_rad)); }, false);
    text += Markdown::of("\n");
  }
  for (const double gain : gains) {
    if (gain != gains.front()) text += Markdown::of("\n");
    text += table(
        file, gain, Markdown::of("energy of the feedback [J]{}", at(gain)),
        [](const LoopScore& loop) { return digits(loop.feedback_J); }, false);
  }
  for (const double gain : gains) {
    text += Markdown::of("\n");
    text += table(
        file, gain, Markdown::of("joints in a limit cycle, gain {:g}", gain),
        [](const LoopScore& loop) { return Markdown::of("{}", loop.limit_cycles.size()); }, false);
  }
  return text.text();
}

}  // namespace fricid::evaluate
