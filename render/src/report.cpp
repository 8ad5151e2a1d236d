#include "fricid/render/report.hpp"

#include "fricid/base/files.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/workflow/recordings.hpp"
#include "html.hpp"
#include "report_parts.hpp"
#include "svg.hpp"

namespace fricid::render {
namespace {

namespace fs = std::filesystem;

Html symbols_of_page(const workflow::RunFolder& folder) {
  const std::vector<fs::path> plots = folder.files_in(folder.plots(), ".svg");
  return plots.empty() ? Html() : svg_symbols(read_svg(plots.front()));
}

}  // namespace

Record read_record(const workflow::RunFolder& folder, const scene::Scene& scene,
                   const workflow::Manifest& manifest) {
  using workflow::if_there;
  Record record{read_run(folder), scene, manifest, {}, {}};
  if (const auto excitation = if_there(folder.excitation(), data::load<sim::ExcitationFile>))
    record.trajectories = excitation->trajectories;
  for (const RunModel& model : record.run.fitted())
    for (const int seed : model.seeds) {
      const workflow::FitId id{model.name, seed};
      record.fits.push_back({model, id, record.run.fit(id), record.run.model_file(id)});
    }
  return record;
}

std::string report_of_run(const workflow::RunFolder& folder, const scene::Scene& scene,
                          const workflow::Manifest& manifest) {
  const Record record = read_record(folder, scene, manifest);
  const Html name = html::escaped(record.run.evaluation.scene);
  const Html description = html::escaped(scene.description);
  const Html body = table_section(record) + torque_section(record) + payload_section(record) +
                    compensation_section(record) + contact_section(record) + video_section(record) +
                    figure_section(record) + model_section(record) + warning_section(record) +
                    data_section(record) + reproduce_section(record);
  const Html page = Html::of(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n"
      "<title>{0} – friction identification</title>\n<style>{1}</style>\n</head>\n<body>\n"
      "{2}<header>\n<h1>{0}</h1>\n<p class=\"byline\">{3}fricid {4}, commit {5}</p>\n{6}{7}"
      "</header>\n<main>\n{8}</main>\n</body>\n</html>\n",
      name, report_style(), symbols_of_page(folder),
      description.empty() ? Html() : Html::of("{} · ", description),
      html::escaped(manifest.version), html::escaped(manifest.commit), summary_section(record),
      html::navigation(body), body);
  return page.text();
}

void write_report(const workflow::RunFolder& folder, const scene::Scene& scene,
                  const workflow::Manifest& manifest, const fs::path& file) {
  write_file_atomically(file, report_of_run(folder, scene, manifest));
}

}  // namespace fricid::render
