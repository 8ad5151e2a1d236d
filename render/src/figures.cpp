#include "fricid/render/figures.hpp"

#include "figure_parts.hpp"

namespace fricid::render {

std::vector<Figure> figures_of_run(const std::filesystem::path& folder) {
  const Run run = read_run(folder);
  std::vector<Figure> figures{error_time(run), error_horizon(run), error_joint(run), tracking(run),
                              bands(run)};
  for (int j = 0; j < run.n(); ++j) figures.push_back(friction_loop(run, j));
  for (const auto& figure :
       {presliding, reversal, friction_time, friction_error, latent, parameters, training,
        filter_health, residual_spectrum, torque_drift, excitation, margins})
    figures.push_back(figure(run));
  for (const RunModel& model : run.fitted()) {
    figures.push_back(torque(run, model));
    figures.push_back(correlation(run, model));
  }
  std::erase_if(figures, [](const Figure& figure) { return figure.panels.empty(); });
  return figures;
}

}  // namespace fricid::render
