#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "json_files.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

namespace fs = std::filesystem;
using html::Row;
using nlohmann::json;

std::vector<fs::path> recordings(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::exists(folder / "data"))
    for (const auto& entry : fs::directory_iterator(folder / "data"))
      if (entry.path().extension() == ".h5") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

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

std::string joint_table(const data::Dataset& set) {
  std::vector<Row> rows;
  for (int j = 0; j < set.n(); ++j) {
    const JointFacts facts = facts_of(set, j);
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

std::string first_lines(const json& object) {
  std::string text;
  for (const auto& [name, hash] : object.items())
    if (hash.is_string()) text += fmt::format("{}  {}\n", hash.get<std::string>(), name);
  return text;
}

}  // namespace

std::string describe_scene(const Record& record) {
  const std::string key = "\ndescription = \"";
  const std::size_t at = record.scene.find(key);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + key.size();
  return html::escaped(record.scene.substr(begin, record.scene.find('"', begin) - begin));
}

std::string data_section(const Record& record) {
  std::vector<Row> rows;
  std::string joints;
  for (const fs::path& file : recordings(record.run.folder)) {
    const data::Dataset set = data::load_dataset(file);
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
  const json& manifest = record.manifest;
  std::string text = "<h2 id=\"reproduce\">How to reproduce</h2>\n";
  text +=
      "<pre>fricid run scene.toml -o again</pre>\n<p>with the <code>scene.toml</code> of this "
      "folder gives the same files to the last byte, for any number of threads.</p>\n";
  if (manifest.is_object()) {
    text += "<dl>";
    const auto item = [&](const char* name, const std::string& value) {
      if (!value.empty()) text += fmt::format("<dt>{}</dt><dd>{}</dd>", name, html::escaped(value));
    };
    item("Version", manifest.value("version", ""));
    item("Commit", manifest.value("commit", ""));
    if (manifest.contains("seed") && manifest.at("seed").is_number())
      item("Seed", fmt::format("{}", manifest.at("seed").get<long>()));
    const json machine = manifest.value("machine", json::object());
    item("Machine",
         fmt::format("{}, {} cores", machine.value("cpu", ""), machine.value("cores", 0)));
    text += "</dl>\n";
    std::vector<Row> stages;
    std::string outputs;
    const json run = manifest.value("stages", json::object());
    for (const auto& [name, stage] : run.items()) {
      stages.push_back({{{html::escaped(name)}, {html::number(number_in(stage, "seconds"))}}});
      if (name != "plots" && name != "report" && name != "video")
        outputs += first_lines(stage.value("outputs", json::object()));
    }
    text += "<details><summary>Time per stage</summary>" +
            html::table({"stage", "seconds"}, stages) + "</details>\n";
    const std::string inputs = first_lines(manifest.value("inputs", json::object()));
    if (!inputs.empty())
      text += "<details><summary>SHA-256 of the inputs</summary><pre>" + html::escaped(inputs) +
              "</pre></details>\n";
    if (!outputs.empty())
      text += "<details><summary>SHA-256 of the results</summary><pre>" + html::escaped(outputs) +
              "</pre></details>\n";
  }
  if (!record.scene.empty())
    text += "<details id=\"scene\"><summary>Scene as run</summary><pre>" +
            html::escaped(record.scene) + "</pre></details>\n";
  return text;
}

}  // namespace fricid::render
