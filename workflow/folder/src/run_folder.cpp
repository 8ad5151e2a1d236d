#include "fricid/workflow/run_folder.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>

namespace fricid::workflow {

namespace fs = std::filesystem;

namespace {

constexpr const char* kDiagnosis = ".doctor.json";
constexpr const char* kHidden = "(not in manifest.json)";  // a folder that never is

}  // namespace

std::string FitId::name() const { return fmt::format("{}_s{}", model, seed); }

std::optional<FitId> FitId::parse(std::string_view name) {
  const std::size_t end = name.rfind("_s");
  if (end == std::string_view::npos || end == 0) return std::nullopt;
  FitId id{std::string(name.substr(0, end)), 0};
  const std::string_view digits = name.substr(end + 2);
  const auto [rest, failure] =
      std::from_chars(digits.data(), digits.data() + digits.size(), id.seed);
  if (failure != std::errc() || rest != digits.data() + digits.size() || id.seed < 0 ||
      id.name() != name)
    return std::nullopt;
  return id;
}

std::string RunFolder::name_of(const fs::path& file) const {
  return file.lexically_relative(path_).generic_string();
}

RunFolder RunFolder::restricted_to(std::set<std::string> names) const {
  if (visible_ != nullptr)
    std::erase_if(names, [&](const std::string& name) { return !visible_->contains(name); });
  RunFolder folder(path_);
  folder.visible_ = std::make_shared<const std::set<std::string>>(std::move(names));
  return folder;
}

fs::path RunFolder::at(const std::string& name) const {
  return shows(name) ? path_ / name : path_ / kHidden / name;
}

bool RunFolder::shows(const std::string& name) const {
  return visible_ == nullptr || visible_->contains(name);
}

std::vector<fs::path> RunFolder::files_in(const fs::path& folder,
                                          std::string_view extension) const {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (entry.path().extension() == extension && shows(name_of(entry.path())))
      files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

std::string RunFolder::training(int i) { return fmt::format("train_{}", i); }
std::string RunFolder::validation(int i) { return fmt::format("validation_{}", i); }
std::string RunFolder::loaded(int i) { return fmt::format("loaded_{}", i); }

fs::path RunFolder::recording(const std::string& name) const { return at("data/" + name + ".h5"); }
fs::path RunFolder::diagnosis(const std::string& name) const {
  return at("data/" + name + kDiagnosis);
}
fs::path RunFolder::diagnosis_beside(const fs::path& recording) {
  return fs::path(recording).replace_extension(kDiagnosis);
}
fs::path RunFolder::truth(const std::string& name) const { return at("truth/" + name + ".h5"); }

fs::path RunFolder::model(const FitId& id) const { return at("models/" + id.name() + ".json"); }
fs::path RunFolder::fit(const FitId& id) const { return at("fit/" + id.name() + ".json"); }
fs::path RunFolder::checkpoint(const FitId& id) const {
  return checkpoints() / (id.name() + ".json");
}

fs::path RunFolder::rollout(const FitId& id, const std::string& recording) const {
  return at(fmt::format("rollouts/{}_{}.h5", id.name(), recording));
}
fs::path RunFolder::prediction(const FitId& id, const std::string& recording) const {
  return at(fmt::format("predictions/{}_{}.h5", id.name(), recording));
}
fs::path RunFolder::estimate(const FitId& id, const std::string& recording) const {
  return at(fmt::format("estimates/{}_{}.h5", id.name(), recording));
}
fs::path RunFolder::band(const std::string& model, const std::string& recording) const {
  return at(fmt::format("bands/{}_{}.h5", model, recording));
}

fs::path RunFolder::loop(const std::string& model, int path, int controller) const {
  return at(fmt::format("loops/{}_path{}_controller{}.h5", model, path, controller));
}

fs::path RunFolder::external_torque(const std::string& model) const {
  return at(fmt::format("contact/{}.h5", model));
}

fs::path RunFolder::plot(const std::string& name, const std::string& extension) const {
  return plots() / (name + "." + extension);
}
fs::path RunFolder::video(const std::string& name) const { return videos() / (name + ".mp4"); }

}  // namespace fricid::workflow
