#include <cmath>

#include <fmt/format.h>

#include "fricid/evaluate/evaluate.hpp"
#include "markdown.hpp"

namespace fricid::evaluate {
namespace {

std::string four_digits(double value) {
  return std::isnan(value) ? "–" : fmt::format("{:.4g}", value);
}

std::string r2_digits(double value) {
  return std::isnan(value) ? "–" : fmt::format("{:.4f}", value);
}

Cells with_joints(Cells cells, const std::vector<std::string>& joints) {
  cells.insert(cells.end(), joints.begin(), joints.end());
  return cells;
}

/// One row per recording, model and seed; `cells` makes the joints' of a prediction.
template <class MakeCells>
std::string by_joint(const char* title, const EvaluationReport& report,
                     const std::vector<std::string>& joints, const MakeCells& cells) {
  std::vector<Cells> rows{with_joints({title, "recording"}, joints)};
  for (std::size_t i = 0; i < report.trajectories.size(); ++i)
    for (const ModelResult& model : report.models) {
      if (model.torque.empty()) continue;
      const std::string label =
          model.seed > 1 ? fmt::format("{} seed {}", model.label, model.seed) : model.label;
      rows.push_back(with_joints({label, report.trajectories[i]}, cells(model.torque[i])));
    }
  return markdown_table(rows) + "\n";
}

std::string repeats_table(const EvaluationReport& report, const std::vector<std::string>& joints) {
  std::vector<Cells> rows{with_joints({"sd of one passage [N m]", "period [s]"}, joints)};
  for (std::size_t i = 0; i < report.trajectories.size(); ++i)
    if (const Repeats& repeats = report.repeats[i]; repeats.period_s > 0)
      append(rows.emplace_back(Cells{report.trajectories[i], four_digits(repeats.period_s)}),
             repeats.tau_sd, digits);
  if (rows.size() == 1)
    return "No motion repeats in these recordings, so what of the error is noise is not known.\n";
  return "Where the motion repeats, the torque of one passage differs from that of the next by the "
         "following standard deviation: no function of the motion can err by less.\n\n" +
         markdown_table(rows);
}

}  // namespace

std::string to_torque_markdown(const EvaluationReport& report,
                               std::span<const Trajectory> trajectories) {
  const std::vector<std::string>& joints = trajectories.front().data.joint_names;
  std::string text = fmt::format(
      "# {}: motor torque along the measured motion of held-out data\n\n"
      "Friction runs free: the measured motion drives it, the measured torque never corrects "
      "it.\n\n",
      report.scene);
  const auto table = [&](const char* title, std::string (*format)(double), const auto& values) {
    text += by_joint(title, report, joints, [&](const TorquePrediction& prediction) {
      Cells cells;
      append(cells, values(prediction), format);
      return cells;
    });
  };
  table("R2", r2_digits, [](const TorquePrediction& p) { return p.r2; });
  table("RMSE [N m]", four_digits, [](const TorquePrediction& p) { return p.rmse.all; });
  table("% of RMS", digits, [](const TorquePrediction& p) { return p.percent_of_rms; });
  text +=
      "Error by regime [N m]: within 50 ms of a reversal; presliding, below 0.05 rad/s or within "
      "5 mrad of a reversal; sliding, the rest.\n\n";
  table("at reversals", digits, [](const TorquePrediction& p) { return p.rmse.reversal; });
  table("presliding", digits, [](const TorquePrediction& p) { return p.rmse.presliding; });
  table("sliding", digits, [](const TorquePrediction& p) { return p.rmse.sliding; });
  text +=
      "One step ahead, with the error of the last sample known and its lag-one autocorrelation: "
      "what white noise leaves.\n\n";
  table("one step [N m]", digits, [](const TorquePrediction& p) { return p.one_step; });
  text +=
      "Drift of what is left, from begin to end of the recording: a straight line through the "
      "means "
      "of its twentieths, with one standard error.\n\n";
  text += by_joint("drift [N m]", report, joints, [](const TorquePrediction& p) {
    Cells cells;
    for (std::size_t j = 0; j < p.drift.size(); ++j)
      cells.push_back(fmt::format("{:.2g} ± {:.1g}", p.drift[j], p.drift_error[j]));
    return cells;
  });
  return text + repeats_table(report, joints);
}

}  // namespace fricid::evaluate
