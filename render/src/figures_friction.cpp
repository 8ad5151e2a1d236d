#include "figure_parts.hpp"
#include "json_files.hpp"

namespace fricid::render {

Figure torque(const Run& run, const RunModel& model) {
  Figure figure{.name = "torque_" + model.name};
  figure.caption = fmt::format(
      "Motor torque on {} as {} predicts it along the measured motion, and what is left.",
      run.trajectory, model.label);
  const auto path = run.file("predictions", model);
  if (path.empty()) return figure;
  const data::H5Reader file(path, "fricid.prediction/1");
  const Eigen::VectorXd t = file.vector("/t");
  const RowMatrix measured = file.matrix("/tau"), predicted = file.matrix("/tau_predicted");
  for (int j = 0; j < measured.cols(); ++j) {
    Panel panel{.title = run.joint(j), .x_label = "t [s]", .y_label = "tau [N m]"};
    panel.series = {
        curve("measured - predicted", kTruthColour, t, measured.col(j) - predicted.col(j), 0.8),
        curve("measured", kMeasuredColour, t, measured.col(j), 0.8),
        curve(model, t, predicted.col(j))};
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Figure friction_loop(const Run& run, int joint) {
  const std::string& name = run.joint(joint);
  Figure figure{.name = "friction_" + name};
  figure.caption = fmt::format(
      "Friction characteristic of {} on {}: torque of each model driven by the measured motion, "
      "against velocity.{}",
      name, run.trajectory, run.truth ? " Grey: the injected friction." : "");
  for (const RunModel& model : run.fitted()) {
    const auto path = run.file("predictions", model);
    if (path.empty()) continue;
    const data::H5Reader file(path, "fricid.prediction/1");
    Panel panel{.title = model.label, .x_label = "v [rad/s]", .y_label = "friction [N m]"};
    if (run.truth)
      panel.series.push_back(
          curve("truth", kTruthColour, run.truth->v.col(joint), run.truth->tau_f.col(joint), 2.2));
    panel.series.push_back(
        curve(model, file.matrix("/v").col(joint), file.matrix("/tau_f").col(joint)));
    panel.series.back().dash = 1;  // alone in its panel
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace fricid::render
