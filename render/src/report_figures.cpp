#include <algorithm>

#include "html.hpp"
#include "json_files.hpp"
#include "report_parts.hpp"
#include "svg.hpp"

namespace fricid::render {
namespace {

namespace fs = std::filesystem;

/// A heading and the names of its plots; one that ends in "_" stands for all that begin so.
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
       {"parameters", "training", "filter_health", "residual_spectrum", "torque_drift"}},
      {"excitation", "Excitation", {"excitation", "margins"}}};
  return kGroups;
}

std::vector<std::string> plots_of(const fs::path& folder) {
  std::vector<std::string> names;
  if (fs::exists(folder / "plots"))
    for (const auto& entry : fs::directory_iterator(folder / "plots"))
      if (entry.path().extension() == ".svg") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The caption that the script of a plot carries in its first line.
std::string caption_of(const fs::path& script) {
  if (!fs::exists(script)) return {};
  const std::string text = read_file(script);
  const std::string first = text.substr(0, text.find('\n'));
  return first.starts_with("# ") ? first.substr(2) : std::string();
}

}  // namespace

std::string plot_html(const Record& record, const std::string& name) {
  const fs::path plots = record.run.folder / "plots";
  if (!fs::exists(plots / (name + ".svg"))) return {};
  const std::string caption = caption_of(plots / (name + ".gp"));
  std::string files;
  for (const char* extension : {"pdf", "svg", "png", "gp"})
    if (fs::exists(plots / (name + "." + extension)))
      files += fmt::format(" <a href=\"plots/{0}.{1}\">{1}</a>", html::escaped(name), extension);
  return fmt::format(
      "<figure id=\"plot-{0}\"><input class=\"zoom\" type=\"checkbox\" id=\"zoom-{0}\" "
      "aria-label=\"enlarge\"><div class=\"plot\"><label for=\"zoom-{0}\">{1}</label></div>"
      "<figcaption>{2} <span class=\"files\">{3}</span></figcaption></figure>\n",
      html::escaped(name), inline_svg(read_svg(plots / (name + ".svg")), caption),
      html::escaped(caption), files);
}

std::string figure_section(const Record& record) {
  const std::vector<std::string> plots = plots_of(record.run.folder);
  std::string text;
  for (const Group& group : groups()) {
    std::string figures;
    for (const std::string_view name : group.names) {
      if (!name.ends_with('_')) {
        figures += plot_html(record, std::string(name));
        continue;
      }
      // One joint in sight, the others on demand.
      std::string first, others;
      for (int j = 0; j < record.run.n(); ++j) {
        const std::string figure = plot_html(record, std::string(name) + record.run.joint(j));
        (first.empty() ? first : others) += figure;
      }
      figures += first;
      if (!others.empty())
        figures += "<details><summary>The other joints</summary>\n" + others + "</details>\n";
    }
    if (!figures.empty())
      text += fmt::format("<h2 id=\"{}\">{}</h2>\n{}", group.id, group.title, figures);
  }
  if (plots.empty())
    text +=
        "<p class=\"note\">This folder holds no plots; <code>fricid render</code> draws "
        "them where gnuplot is installed.</p>\n";
  return text;
}

}  // namespace fricid::render
