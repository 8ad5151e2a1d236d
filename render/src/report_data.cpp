#include <fmt/format.h>

#include "fricid/signals/overview.hpp"
#include "fricid/workflow/recordings.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using html::Row, html::Style;

Html joint_table(const Run& run, const data::Dataset& set) {
  std::vector<Row> rows;
  for (int j = 0; j < set.n(); ++j) {
    const signals::JointOverview facts = signals::overview(set, j);
    rows.push_back(
        {{{html::escaped(run.heading(j))},
          {Html::of("{} … {}", html::number(facts.low, 3), html::number(facts.high, 3))},
          {html::number(facts.fastest, 3)},
          {Html::of("{}", facts.reversals)},
          {html::number(1e6 * facts.noise)},
          {html::number(facts.torque_rms, 3)},
          {html::number(facts.torque_peak, 3)},
          {Html::of("{}", facts.missing), facts.missing > 0 ? Style::kBad : Style::kPlain}}});
  }
  return html::table(
      html::headings({"joint", "q [rad]", "fastest [rad/s]", "reversals", "noise of q [µrad]",
                      "torque RMS [N m]", "peak [N m]", "missing"}),
      rows,
      Html::of("{}: noise from fourth differences of the logged position.",
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

Html data_section(const Record& record) {
  std::vector<Row> rows;
  Html joints;
  std::vector<data::Dataset> sets;
  for (const auto name : {workflow::RunFolder::training, workflow::RunFolder::validation})
    for (data::Dataset& set : workflow::load_recordings(record.run.folder, name))
      sets.push_back(std::move(set));
  for (const data::Dataset& set : sets) {
    rows.push_back({{{html::escaped(set.name)},
                     {Html::of("{}", set.length())},
                     {html::number((set.length() - 1) * set.dt(), 3)},
                     {html::number(set.rate_hz, 3)},
                     {html::escaped(set.source), Style::kText}}});
    joints += joint_table(record.run, set);
  }
  if (rows.empty()) return {};
  return Html::of("<h2 id=\"data\">Data</h2>\n") +
         html::table(html::headings({"recording", "samples", "length [s]", "rate [Hz]", "source"}),
                     rows) +
         html::details("Joint by joint", Html::of("\n") + joints);
}

Html reproduce_section(const Record& record) {
  Html text = Html::of(
      "<h2 id=\"reproduce\">How to reproduce</h2>\n"
      "<pre>fricid run scene.toml -o again</pre>\n<p>with the <code>scene.toml</code> of this "
      "folder gives the same files to the last byte, for any number of threads.</p>\n<dl>");
  const workflow::Manifest& manifest = record.manifest;
  const auto item = [&](const char* name, const std::string& value) {
    if (!value.empty())
      text += Html::of("<dt>{}</dt><dd>{}</dd>", html::escaped(name), html::escaped(value));
  };
  item("Version", manifest.version);
  item("Commit", manifest.commit);
  item("Seed", fmt::format("{}", manifest.seed));
  item("Machine", fmt::format("{}, {} cores", manifest.machine.cpu, manifest.machine.cores));
  text += Html::of("</dl>\n");
  std::vector<Row> stages;
  std::string outputs;
  for (const workflow::StageRecord& stage : manifest.stages) {
    stages.push_back({{{html::escaped(stage.name)}, {html::number(stage.seconds)}}});
    outputs += hashes(results_of(stage, record.run.folder));
  }
  const auto preformatted = [](const std::string& content) {
    return content.empty() ? Html() : Html::of("<pre>{}</pre>", html::escaped(content));
  };
  text +=
      html::details("Time per stage", html::table(html::headings({"stage", "seconds"}), stages));
  text += html::details("SHA-256 of the inputs", preformatted(hashes(manifest.sources)));
  text += html::details("SHA-256 of the results", preformatted(outputs));
  return text + Html::of("<details id=\"scene\"><summary>Scene as run</summary>{}</details>\n",
                         preformatted(scene::to_toml(record.scene)));
}

}  // namespace fricid::render
