#include "fricid/render/report.hpp"

#include "html.hpp"
#include "json_files.hpp"
#include "report_parts.hpp"
#include "svg.hpp"

namespace fricid::render {
namespace {

namespace fs = std::filesystem;

std::string symbols_of_page(const fs::path& folder) {
  if (!fs::exists(folder / "plots")) return {};
  for (const auto& entry : fs::directory_iterator(folder / "plots"))
    if (entry.path().extension() == ".svg") return svg_symbols(read_svg(entry.path()));
  return {};
}

std::string navigation(const std::string& body) {
  std::string text = "<nav aria-label=\"Contents\">";
  for (std::size_t at = 0; (at = body.find("<h2 id=\"", at)) != std::string::npos;) {
    at += 8;
    const std::size_t quote = body.find('"', at), close = body.find("</h2>", quote);
    text += fmt::format("<a href=\"#{}\">{}</a> ", body.substr(at, quote - at),
                        body.substr(quote + 2, close - quote - 2));
  }
  return text + "</nav>\n";
}

}  // namespace

Record read_record(const fs::path& folder) {
  Record record{read_run(folder), {}, {}, {}, {}};
  record.manifest = read_json_if_there(folder / "manifest.json");
  record.excitation = read_json_if_there(folder / "excitation.json");
  if (fs::exists(folder / "scene.toml")) record.scene = read_file(folder / "scene.toml");
  for (const RunModel& model : record.run.fitted())
    for (const int seed : model.seeds) {
      const std::string name = fmt::format("{}_s{}.json", model.name, seed);
      FittedModel fitted{model, seed, read_json_if_there(folder / "fit" / name),
                         read_json_if_there(folder / "models" / name)};
      if (fitted.fit.is_null()) fitted.fit = nlohmann::json::object();
      record.fits.push_back(std::move(fitted));
    }
  return record;
}

std::string report_of_run(const fs::path& folder) {
  const Record record = read_record(folder);
  const std::string name = html::escaped(record.run.evaluation.value("scene", "run"));
  std::string body = table_section(record) + torque_section(record) + video_section(record) +
                     figure_section(record) + model_section(record) +
                     warning_section(warnings_of(record)) + data_section(record) +
                     reproduce_section(record);
  const auto text_of = [&](const char* key) {
    return html::escaped(record.manifest.is_object() ? record.manifest.value(key, "") : "");
  };
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n"
      "<title>{0} – friction identification</title>\n<style>{1}</style>\n</head>\n<body>\n"
      "{2}<header>\n<h1>{0}</h1>\n<p class=\"byline\">{3}fricid {4}, commit {5}</p>\n{6}{7}"
      "</header>\n<main>\n{8}</main>\n</body>\n</html>\n",
      name, kReportStyle, symbols_of_page(folder),
      describe_scene(record).empty() ? "" : describe_scene(record) + " · ", text_of("version"),
      text_of("commit"), summary_section(record), navigation(body), body);
}

void write_report(const fs::path& folder) {
  write_file_atomically(folder / "report.html", report_of_run(folder));
}

}  // namespace fricid::render
