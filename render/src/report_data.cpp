#include <fmt/format.h>

#include "fricid/signals/overview.hpp"
#include "fricid/workflow/recordings.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using html::Row;

std::string joint_table(const data::Dataset& set) {
  std::vector<Row> rows;
  for (int j = 0; j < set.n(); ++j) {
    const signals::JointOverview facts = signals::overview(set, j);
    rows.push_back(
        {{{html::escaped(set.joint_names[static_cast<std::size_t>(j)])},
          {fmt::format("{} … {}", html::number(facts.low, 3), html::number(facts.high, 3))},
          {html::number(facts.fastest, 3)},
          {fmt::format("{}", facts.reversals)},
          {html::number(1e6 * facts.noise)},
          {html::number(facts.torque_rms, 3)},
          {html::number(facts.torque_peak, 3)},
          {fmt::format("{}", facts.missing), facts.missing > 0 ? "bad" : ""}}});
  }
  return html::table({"joint", "q [rad]", "fastest [rad/s]", "reversals", "noise of q [µrad]",
                      "torque RMS [N m]", "peak [N m]", "missing"},
                     rows,
                     fmt::format("{}: noise from fourth differences of the logged position.",
                                 html::escaped(set.name)));
}

std::string hashes(const std::vector<workflow::Content>& contents) {
  std::string text;
  for (const workflow::Content& content : contents)
    text += fmt::format("{}  {}\n", content.sha256, content.name);
  return text;
}

/// Files that other figures are made from: all but plots, videos and the report.
std::vector<workflow::Content> results_of(const workflow::StageRecord& stage,
                                          const workflow::RunFolder& folder) {
  std::vector<workflow::Content> results;
  for (const workflow::Content& output : stage.outputs)
    if (!output.name.starts_with(folder.name_of(folder.plots()) + "/") &&
        !output.name.starts_with(folder.name_of(folder.videos()) + "/") &&
        output.name != folder.name_of(folder.report()))
      results.push_back(output);
  return results;
}

}  // namespace

std::string data_section(const Record& record) {
  std::vector<Row> rows;
  std::string joints;
  std::vector<data::Dataset> sets;
  for (const auto name : {workflow::RunFolder::training, workflow::RunFolder::validation})
    for (data::Dataset& set : workflow::load_recordings(record.run.folder, name))
      sets.push_back(std::move(set));
  for (const data::Dataset& set : sets) {
    rows.push_back({{{html::escaped(set.name)},
                     {fmt::format("{}", set.length())},
                     {html::number((set.length() - 1) * set.dt(), 3)},
                     {html::number(set.rate_hz, 3)},
                     {html::escaped(set.source), "text"}}});
    joints += joint_table(set);
  }
  if (rows.empty()) return {};
  return "<h2 id=\"data\">Data</h2>\n" +
         html::table({"recording", "samples", "length [s]", "rate [Hz]", "source"}, rows) +
         "<details><summary>Joint by joint</summary>\n" + joints + "</details>\n";
}

std::string reproduce_section(const Record& record) {
  std::string text = "<h2 id=\"reproduce\">How to reproduce</h2>\n";
  text +=
      "<pre>fricid run scene.toml -o again</pre>\n<p>with the <code>scene.toml</code> of this "
      "folder gives the same files to the last byte, for any number of threads.</p>\n";
  const workflow::Manifest& manifest = record.manifest;
  text += "<dl>";
  const auto item = [&](const char* name, const std::string& value) {
    if (!value.empty()) text += fmt::format("<dt>{}</dt><dd>{}</dd>", name, html::escaped(value));
  };
  item("Version", manifest.version);
  item("Commit", manifest.commit);
  item("Seed", fmt::format("{}", manifest.seed));
  item("Machine", fmt::format("{}, {} cores", manifest.machine.cpu, manifest.machine.cores));
  text += "</dl>\n";
  std::vector<Row> stages;
  std::string outputs;
  for (const workflow::StageRecord& stage : manifest.stages) {
    stages.push_back({{{html::escaped(stage.name)}, {html::number(stage.seconds)}}});
    outputs += hashes(results_of(stage, record.run.folder));
  }
  const auto details = [&](const char* summary, const std::string& content) {
    if (!content.empty())
      text += fmt::format("<details><summary>{}</summary>{}</details>\n", summary, content);
  };
  const auto preformatted = [](const std::string& content) {
    return content.empty() ? content : "<pre>" + html::escaped(content) + "</pre>";
  };
  details("Time per stage", html::table({"stage", "seconds"}, stages));
  details("SHA-256 of the inputs", preformatted(hashes(manifest.sources)));
  details("SHA-256 of the results", preformatted(outputs));
  text += "<details id=\"scene\"><summary>Scene as run</summary>" +
          preformatted(scene::to_toml(record.scene)) + "</details>\n";
  return text;
}

}  // namespace fricid::render
