#include "fricid/render/figures.hpp"

#include <algorithm>

#include "figure_parts.hpp"

namespace fricid::render {
namespace {

constexpr std::ptrdiff_t kMostInASmallPanel = 7;

/// Panels with many models are larger.
void give_room(Figure& figure) {
  const auto labels = [](const Panel& panel) {
    return std::count_if(panel.series.begin(), panel.series.end(),
                         [](const Series& series) { return !series.label.empty(); });
  };
  if (std::none_of(figure.panels.begin(), figure.panels.end(),
                   [&](const Panel& panel) { return labels(panel) > kMostInASmallPanel; }))
    return;
  figure.columns = std::max(1, figure.columns - 1);
  figure.width_cm = Figure().width_cm;
  figure.panel_height_cm *= 1.4;
}

}  // namespace

std::vector<Figure> figures_of_run(const workflow::RunFolder& folder) {
  const Run run = read_run(folder);
  std::vector<Figure> figures{error_time(run), error_horizon(run), error_joint(run), tracking(run),
                              bands(run)};
  for (int j = 0; j < run.n(); ++j) figures.push_back(friction_loop(run, j));
  for (const auto& figure :
       {presliding, reversal, friction_time, friction_error, latent, parameters, training, em,
        filter_health, residual_spectrum, torque_drift, excitation, margins, compensation,
        compensation_time, contact, contact_threshold})
    figures.push_back(figure(run));
  for (const RunModel& model : run.fitted()) {
    figures.push_back(torque(run, model));
    figures.push_back(correlation(run, model));
  }
  std::erase_if(figures, [](const Figure& figure) { return figure.panels.empty(); });
  if (std::ssize(run.fitted()) > kMostInASmallPanel)
    std::for_each(figures.begin(), figures.end(), give_room);
  return figures;
}

}  // namespace fricid::render
