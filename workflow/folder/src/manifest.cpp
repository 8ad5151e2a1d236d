#include "fricid/workflow/manifest.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/text.hpp"

namespace fricid::workflow {
namespace {

constexpr std::string_view kIdentify = "identify ";
constexpr std::string_view kRecordings[] = {kTrainingData, kValidationData};

/// Whether a file of this name is one that other stages read, and a stage writes.
bool is_result(std::string_view name) {
  return std::ranges::any_of(std::array<std::string_view, 3>{"data/", "models/", "fit/"},
                             [&](std::string_view folder) { return name.starts_with(folder); });
}

/// Whether a name of an output leads to a file below the run folder.
bool is_inside(const std::string& name) {
  const std::filesystem::path path(name);
  return path.is_relative() && path.has_filename() && path != "." && *path.begin() != ".." &&
         path.lexically_normal().string() == name;
}

void require_visible(const std::string& text, std::string_view key, const std::string& place) {
  require_label(text.substr(0, 1000), key, place);
}

}  // namespace

const StageRecord* Manifest::find(std::string_view stage) const {
  const auto found = std::ranges::find(stages, stage, &StageRecord::name);
  return found == stages.end() ? nullptr : &*found;
}

StageRecord& Manifest::at(const std::string& stage) {
  if (const StageRecord* found = find(stage))
    return stages[static_cast<std::size_t>(found - stages.data())];
  stages.emplace_back().name = stage;
  return stages.back();
}

std::string seal_of(const StageRecord& record) {
  std::string text = fmt::format("{}\n{}\n", record.name, record.program);
  for (const auto* contents : {&record.inputs, &record.outputs}) {
    text += fmt::format("{}\n", contents->size());
    for (const Content& content : *contents)
      text += fmt::format("{} {}\n", content.sha256, content.name);
  }
  return sha256_of_text(text);
}

void Manifest::check(const std::string& place) const {
  for (const std::string* text : {&version, &commit, &machine.cpu, &scene})
    require_visible(*text, "a text", place);
  for (const std::string& fit : fitted_by_name) require_visible(fit, "fitted_by_name", place);
  std::set<std::string_view> names, files;
  for (const StageRecord& stage : stages) {
    require_visible(stage.name, "name of a stage", place);
    if (!names.insert(stage.name).second)
      throw UserError("{}: stage {} is there twice; allowed: once", place, stage.name);
    for (const Content& output : stage.outputs) {
      if (!is_inside(output.name))
        throw UserError("{}: output {}; allowed: a file below the run folder", place,
                        printable(output.name));
      if (!files.insert(output.name).second)
        throw UserError("{}: output {} is there twice; allowed: once", place,
                        printable(output.name));
    }
  }
}

std::string stage_of(const FitId& fit) { return std::string(kIdentify) + fit.name(); }

std::optional<FitId> fit_of(std::string_view stage) {
  if (!stage.starts_with(kIdentify)) return std::nullopt;
  return FitId::parse(stage.substr(kIdentify.size()));
}

std::string changed_since(const Manifest& manifest, const StageRecord& record) {
  std::map<std::string_view, std::string_view> written;
  for (const StageRecord& stage : manifest.stages)
    for (const Content& output : stage.outputs) written[output.name] = output.sha256;
  constexpr std::size_t kShown = 3;
  std::set<std::string> changed;
  std::set<std::string_view> read;
  for (const Content& input : record.inputs) {
    read.insert(input.name);
    const auto now = written.find(input.name);
    if (now == written.end() ? is_result(input.name) : now->second != input.sha256)
      changed.insert(input.name);
  }
  for (const std::string_view kind : kRecordings) {
    const auto is_of_kind = [&](std::string_view name) { return name.starts_with(kind); };
    if (std::ranges::none_of(read, is_of_kind)) continue;
    for (const auto& [name, sha256] : written)
      if (is_of_kind(name) && !read.contains(name)) changed.emplace(name);
  }
  return first_of(std::vector(changed.begin(), changed.end()), kShown);
}

std::string outdated(const RunFolder& run, const Manifest& manifest,
                     const std::filesystem::path& file) {
  const std::string name = run.name_of(file);
  for (const StageRecord& stage : manifest.stages)
    for (const Content& output : stage.outputs) {
      if (output.name != name) continue;
      if (stage.seal != seal_of(stage) || sha256_of_file(file) != output.sha256)
        return fmt::format("changed since the stage {} wrote it", stage.name);
      if (const auto changed = changed_since(manifest, stage); !changed.empty())
        return "made from another " + changed;
      return {};
    }
  return "no stage of manifest.json made it";
}

std::string problem_key(const Manifest& manifest) {
  std::string text;
  const auto add = [&](std::string_view stage, auto&& counts) {
    const StageRecord* record = manifest.find(stage);
    for (const Content& input : record == nullptr ? std::vector<Content>() : record->inputs)
      if (counts(std::string_view(input.name)))
        text += fmt::format("{} {}\n", input.sha256, input.name);
  };
  add("data", [](std::string_view name) { return name != "scene name" && name != "scene seed"; });
  if (text.empty()) return {};
  add("evaluate", [](std::string_view name) {
    return name == "scene [identify]" || name.starts_with("--data ");
  });
  return sha256_of_text(text);
}

std::map<std::string, std::string> fit_keys(const Manifest& manifest) {
  std::map<std::string, std::string> keys;
  for (const StageRecord& stage : manifest.stages)
    if (const auto fit = fit_of(stage.name))
      for (const Content& input : stage.inputs)
        if (input.name == "scene [[model]]") keys[fit->name()] = input.sha256;
  return keys;
}

std::map<std::string, double> fit_seconds(const Manifest& manifest) {
  std::map<std::string, std::pair<double, int>> sums;
  for (const StageRecord& stage : manifest.stages)
    if (const auto fit = fit_of(stage.name)) {
      sums[fit->model].first += stage.seconds;
      ++sums[fit->model].second;
    }
  std::map<std::string, double> means;
  for (const auto& [model, sum] : sums) means[model] = sum.first / sum.second;
  return means;
}

}  // namespace fricid::workflow
