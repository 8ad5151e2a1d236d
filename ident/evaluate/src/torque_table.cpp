#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/evaluate/evaluate.hpp"
#include "markdown.hpp"

namespace fricid::evaluate {
namespace {

Markdown four_digits(double value) {
  return std::isnan(value) ? Markdown::of("–") : Markdown::of("{:.4g}", value);
}

Markdown r2_digits(double value) {
  return std::isnan(value) ? Markdown::of("–") : Markdown::of("{:.4f}", value);
}

using Joints = std::span<const dynamics::Joint>;

Cells with_joints(Cells cells, Joints joints) {
  for (const dynamics::Joint& joint : joints)
    cells.push_back(slides(joint) ? Markdown::of("{} (N)", escaped(joint.name))
                                  : escaped(joint.name));
  return cells;
}

/// One row per recording, model and seed; `cells` makes the joints' of a prediction.
template <class MakeCells>
Markdown by_joint(const Markdown& title, const Evaluation& report, Joints joints,
                  const MakeCells& cells) {
  std::vector<Cells> rows{with_joints({title, Markdown::of("recording")}, joints)};
  for (std::size_t i = 0; i < report.trajectories.size(); ++i)
    for (const ModelResult& model : report.models) {
      if (model.torque.empty()) continue;
      const Markdown label = model.seed > 1
                                 ? Markdown::of("{} seed {}", escaped(model.label), model.seed)
                                 : escaped(model.label);
      Cells& row = rows.emplace_back(Cells{label, escaped(report.trajectories[i])});
      const Cells values = cells(model.torque[i]);
      row.insert(row.end(), values.begin(), values.end());
    }
  return markdown_table(rows) + Markdown::of("\n");
}

Markdown repeats_table(const Evaluation& report, Joints joints) {
  std::vector<Cells> rows{
      with_joints({Markdown::of("sd of one passage [N m]"), Markdown::of("period [s]")}, joints)};
  for (std::size_t i = 0; i < report.trajectories.size(); ++i)
    if (const Repeats& repeats = report.repeats[i]; repeats.period_s > 0)
      append(
          rows.emplace_back(Cells{escaped(report.trajectories[i]), four_digits(repeats.period_s)}),
          repeats.tau_sd, digits);
  if (rows.size() == 1)
    return Markdown::of(
        "No motion repeats in these recordings, so the noise part of the error is unknown.\n");
  return Markdown::of(
             "Where the motion repeats: standard deviation of the torque between one passage and "
             "the next. No function of the motion can have a smaller error.\n\n") +
         markdown_table(rows);
}

}  // namespace

std::string to_torque_markdown(const Evaluation& report, Joints joints) {
  Markdown text = Markdown::of(
      "# {}: motor torque along the measured motion of held-out data\n\n"
      "Friction is in open loop: driven by the measured motion, the measured torque never corrects "
      "it.\n\n",
      escaped(report.scene));
  const auto table = [&](const Markdown& title, Markdown (*format)(double), const auto& values) {
    text += by_joint(title, report, joints, [&](const TorquePrediction& prediction) {
      Cells cells;
      append(cells, values(prediction), format);
      return cells;
    });
  };
  table(Markdown::of("R2"), r2_digits, [](const TorquePrediction& p) { return p.r2; });
  table(Markdown::of("RMSE [N m]"), four_digits,
        [](const TorquePrediction& p) { return p.rmse.all; });
  table(Markdown::of("% of RMS"), digits,
        [](const TorquePrediction& p) { return p.percent_of_rms; });
  text += Markdown::of(
      "Error by regime [N m]: within 50 ms of a reversal; presliding, below 0.05 rad/s or within "
      "5 mrad of a reversal; sliding, the rest.{}\n\n",
      std::ranges::any_of(joints, dynamics::slides)
          ? Markdown::of(" Of joints that slide (N): 5 mm/s, 0.5 mm.")
          : Markdown::of(""));
  table(Markdown::of("at reversals"), digits,
        [](const TorquePrediction& p) { return p.rmse.reversal; });
  table(Markdown::of("presliding"), digits,
        [](const TorquePrediction& p) { return p.rmse.presliding; });
  table(Markdown::of("sliding"), digits, [](const TorquePrediction& p) { return p.rmse.sliding; });
  text += Markdown::of(
      "One-step-ahead error: the error less its lag-one autocorrelation times that of the last "
      "sample. Far below the RMSE: correlated residuals.\n\n");
  table(Markdown::of("one step [N m]"), digits,
        [](const TorquePrediction& p) { return p.one_step; });
  text += Markdown::of(
      "Drift of the residual over the recording: rise of a straight line through the means of "
      "its twentieths, with one standard error.\n\n");
  text += by_joint(Markdown::of("drift [N m]"), report, joints, [](const TorquePrediction& p) {
    Cells cells;
    for (std::size_t j = 0; j < p.drift.size(); ++j)
      cells.push_back(Markdown::of("{:.2g} ± {:.1g}", p.drift[j], p.drift_error[j]));
    return cells;
  });
  return (text + repeats_table(report, joints)).text();
}

}  // namespace fricid::evaluate
