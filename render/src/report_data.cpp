#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/workflow/recordings.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using html::Row, html::Style;

/// What can be said of one joint of a recording without any model.
struct JointFacts {
  double low = INFINITY, high = -INFINITY;  ///< of q [rad]
  double fastest = 0;                       ///< [rad/s]
  double torque_rms = 0, torque_peak = 0;   ///< [N m]
  double noise = 0;                         ///< sd of q that smooth motion cannot explain [rad]
  int reversals = 0, missing = 0;
};

/// Noise from fourth differences, whose variance is 70 times the noise's and which smooth motion
/// hardly moves; the median keeps corners out.
double noise_of(const Eigen::Ref<const Eigen::VectorXd>& q) {
  constexpr double kMedianToSd = 1.4826, kGain = 70;
  std::vector<double> differences;
  for (Eigen::Index k = 0; k + 4 < q.size(); ++k) {
    const double d = q[k] - 4 * q[k + 1] + 6 * q[k + 2] - 4 * q[k + 3] + q[k + 4];
    if (std::isfinite(d)) differences.push_back(std::abs(d));
  }
  if (differences.empty()) return kNaN;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return kMedianToSd * *middle / std::sqrt(kGain);
}

JointFacts facts_of(const data::Dataset& set, int joint) {
  JointFacts facts;
  const Eigen::VectorXd q = set.q.col(joint), tau = set.tau.col(joint);
  double squares = 0, direction = 0;
  int torques = 0;
  const double moved = 20 * noise_of(q);  // smaller turns may be noise
  double turn = q[0];
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    facts.missing += !std::isfinite(q[k]) || !std::isfinite(tau[k]);
    if (std::isfinite(tau[k])) {
      squares += tau[k] * tau[k];
      facts.torque_peak = std::max(facts.torque_peak, std::abs(tau[k]));
      ++torques;
    }
    if (!std::isfinite(q[k])) continue;
    facts.low = std::min(facts.low, q[k]);
    facts.high = std::max(facts.high, q[k]);
    if (k >= 2 && std::isfinite(q[k - 2]))
      facts.fastest = std::max(facts.fastest, std::abs(q[k] - q[k - 2]) / (2 * set.dt()));
    // A reversal: away from the last extreme by more than the noise, against the last direction.
    if (direction * (q[k] - turn) >= 0) turn = direction == 0 ? turn : q[k];
    if (std::abs(q[k] - turn) > moved) {
      const double now = q[k] > turn ? 1 : -1;
      if (direction != 0 && now != direction) ++facts.reversals;
      direction = now;
      turn = q[k];
    }
  }
  facts.torque_rms = torques > 0 ? std::sqrt(squares / torques) : kNaN;
  facts.noise = noise_of(q);
  return facts;
}

Html joint_table(const data::Dataset& set) {
  std::vector<Row> rows;
  for (int j = 0; j < set.n(); ++j) {
    const JointFacts facts = facts_of(set, j);
    rows.push_back(
        {{{html::escaped(set.joint_names[static_cast<std::size_t>(j)])},
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
    joints += joint_table(set);
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
