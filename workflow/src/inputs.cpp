#include "fricid/workflow/inputs.hpp"

#include <algorithm>
#include <stdexcept>

#include "fricid/base/files.hpp"

namespace fricid::workflow {

namespace fs = std::filesystem;

void Inputs::add(const std::string& name, std::string sha256) {
  contents_.push_back({name, std::move(sha256)});
}

void Inputs::text(const std::string& name, std::string_view value) {
  add(name, sha256_of_text(value));
}

void Inputs::file(const std::string& name, const fs::path& path) {
  add(name, sha256_of_file(path));
}

void Inputs::files_below(const fs::path& folder) {
  if (!fs::exists(folder)) return;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = folder_.name_of(entry.path());
    add(name, sha256_of_file(entry.path()));
    visible_.insert(name);
  }
}

void Inputs::outputs_of(const StageRecord& stage, std::string_view begin) {
  for (const Content& output : stage.outputs) {
    if (!output.name.starts_with(begin)) continue;
    add(output.name, output.sha256);
    visible_.insert(output.name);
  }
}

std::vector<Content> Inputs::contents() const {
  std::vector<Content> sorted = contents_;
  std::ranges::sort(sorted, {}, &Content::name);
  const auto twice = std::ranges::adjacent_find(sorted, {}, &Content::name);
  if (twice != sorted.end()) throw std::logic_error("two inputs are called " + twice->name);
  return sorted;
}

RunFolder Inputs::visible() const { return folder_.restricted_to(visible_); }

std::string key_of(const std::vector<Content>& inputs) {
  std::string text;
  for (const Content& input : inputs) text += input.sha256 + " " + input.name + "\n";
  return sha256_of_text(text);
}

std::vector<std::string> differences(const std::vector<Content>& before,
                                     const std::vector<Content>& now) {
  std::vector<std::string> names;
  const auto add_missing = [&](const std::vector<Content>& from, const std::vector<Content>& in) {
    for (const Content& content : from)
      if (std::ranges::find(in, content) == in.end() &&
          std::ranges::find(names, content.name) == names.end())
        names.push_back(content.name);
  };
  add_missing(now, before);
  add_missing(before, now);
  std::ranges::sort(names);
  return names;
}

}  // namespace fricid::workflow
