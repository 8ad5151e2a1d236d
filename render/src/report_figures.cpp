#include "fricid/base/files.hpp"
#include "fricid/workflow/recordings.hpp"
#include "html.hpp"
#include "report_parts.hpp"
#include "svg.hpp"

namespace fricid::render {
namespace {

namespace fs = std::filesystem;

/// A heading and the names of its plots; a name that ends in "_" means all that begin with it.
struct Group {
  const char *id, *title;
  std::vector<const char*> names;
};

const std::vector<Group>& groups() {
  static const std::vector<Group> kGroups{
      {"open-loop",
       "Open loop",
       {"error_horizon", "error_time", "error_joint", "tracking", "bands"}},
      {"friction",
       "Friction",
       {"friction_", "presliding", "reversal", "friction_time", "friction_error", "latent"}},
      {"identification",
       "Identification",
       {"parameters", "training", "em", "filter_health", "residual_spectrum", "torque_drift"}},
      {"excitation", "Excitation", {"excitation", "margins"}},
      {"closed-loop",
       "Closed loop",
       {"compensation", "compensation_time", "contact", "contact_threshold"}}};
  return kGroups;
}

/// The caption in the first line of a plot's script.
std::string caption_of(const fs::path& script) {
  const std::string text = workflow::if_there(script, read_file).value_or("");
  return text.starts_with("# ") ? text.substr(2, text.find('\n') - 2) : std::string();
}

}  // namespace

Html plot_html(const Record& record, const std::string& name) {
  const workflow::RunFolder& folder = record.run.folder;
  const fs::path picture = folder.plot(name, "svg");
  if (!workflow::is_there(picture)) return {};
  const std::string caption = caption_of(folder.plot(name, "gp"));
  Html files;
  for (const char* extension : {"pdf", "svg", "png", "gp"})
    if (const fs::path file = folder.plot(name, extension); workflow::is_there(file))
      files += Html::of(" <a href=\"{}\">{}</a>", html::escaped(folder.name_of(file)),
                        html::escaped(extension));
  return Html::of(
      "<figure id=\"plot-{0}\"><input class=\"zoom\" type=\"checkbox\" id=\"zoom-{0}\" "
      "aria-label=\"enlarge\"><div class=\"plot\"><label for=\"zoom-{0}\">{1}</label></div>"
      "<figcaption>{2} <span class=\"files\">{3}</span></figcaption></figure>\n",
      html::escaped(name), inline_svg(read_svg(picture), caption), html::escaped(caption), files);
}

Html figure_section(const Record& record) {
  const workflow::RunFolder& folder = record.run.folder;
  Html text;
  for (const Group& group : groups()) {
    Html figures;
    for (const std::string_view name : group.names) {
      if (!name.ends_with('_')) {
        figures += plot_html(record, std::string(name));
        continue;
      }
      // The first joint is open, the others collapsed.
      Html first, others;
      for (int j = 0; j < record.run.n(); ++j) {
        const Html figure = plot_html(record, std::string(name) + record.run.joint(j));
        (first.empty() ? first : others) += figure;
      }
      figures += first;
      if (!others.empty()) figures += html::details("The other joints", Html::of("\n") + others);
    }
    if (!figures.empty())
      text += Html::of("<h2 id=\"{}\">{}</h2>\n{}", html::escaped(group.id),
                       html::escaped(group.title), figures);
  }
  if (folder.files_in(folder.plots(), ".svg").empty())
    text += Html::of(
        "<p class=\"note\">This folder holds no plots; <code>fricid render</code> draws "
        "them where gnuplot is installed.</p>\n");
  return text;
}

}  // namespace fricid::render
