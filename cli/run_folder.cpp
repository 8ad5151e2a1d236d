#include "run_folder.hpp"

#include <chrono>
#include <fstream>
#include <thread>

#include "fricid/base/error.hpp"
#include "fricid/base/progress.hpp"
#include "version.hpp"

namespace fricid::cli {
namespace {

constexpr std::string_view kFormat = "fricid.manifest/1";

std::string cpu_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

std::filesystem::path created(std::filesystem::path path) {
  std::error_code failure;
  std::filesystem::create_directories(path, failure);
  if (failure || !std::filesystem::is_directory(path))
    throw UserError("{}: cannot make this folder: {}", path.string(), failure.message());
  return path;
}

nlohmann::json read_manifest(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return {};
  auto manifest = nlohmann::json::parse(read_file(path), nullptr, false);
  if (manifest.is_discarded() || manifest.value("format", "") != kFormat)
    throw UserError("{}: found no \"format\": \"{}\"; the folder belongs to something else",
                    path.string(), kFormat);
  return manifest;
}

}  // namespace

RunFolder::RunFolder(std::filesystem::path path, bool fresh)
    : made_(!std::filesystem::exists(path)),
      fresh_(fresh),
      path_(created(std::move(path))),
      lock_(std::make_unique<FileLock>(path_ / ".lock")),
      program_(sha256_of_file("/proc/self/exe")) {
  manifest_ = read_manifest(path_ / "manifest.json");
  if (!manifest_.empty()) remove_left_temporaries(path_);
  if (fresh_) std::filesystem::remove_all(path_ / "checkpoint");
  manifest_["format"] = kFormat;
  manifest_["version"] = kFricidVersion;
  manifest_["commit"] = kFricidCommit;
  manifest_["machine"] = {{"cpu", cpu_name()}, {"cores", std::thread::hardware_concurrency()}};
}

RunFolder::~RunFolder() {
  const bool moved = !lock_;
  if (moved || !made_ || manifest_.contains("stages")) return;
  std::error_code kept;  // what is not ours stays, and the folder with it
  for (const char* name : {"manifest.json", "scene.toml", ".lock"})
    std::filesystem::remove(path_ / name, kept);
  std::filesystem::remove(path_, kept);
}

bool RunFolder::up_to_date(const std::string& name, const std::string& key) const {
  if (fresh_) return false;
  const nlohmann::json* record = record_of(name);
  return record != nullptr && record->at("key") == key && intact(name);
}

const nlohmann::json* RunFolder::record_of(const std::string& name) const {
  const auto stages = manifest_.find("stages");
  return stages == manifest_.end() || !stages->contains(name) ? nullptr : &stages->at(name);
}

bool RunFolder::intact(const std::string& name) const {
  const nlohmann::json* record = record_of(name);
  if (record == nullptr) return false;
  for (const auto& [file, hash] : record->at("outputs").items())
    if (!std::filesystem::exists(path_ / file) || sha256_of_file(path_ / file) != hash)
      return false;
  return true;
}

bool RunFolder::stands(const std::string& name, const std::string& key) const {
  return intact(name) && record_of(name)->value("inputs", "") == sha256_of_text(key);
}

std::vector<std::string> RunFolder::stages() const {
  std::vector<std::string> names;
  if (const auto stages = manifest_.find("stages"); stages != manifest_.end())
    for (const auto& [name, record] : stages->items()) names.push_back(name);
  return names;
}

void RunFolder::remove_unless_changed(const nlohmann::json& outputs,
                                      const nlohmann::json& kept) const {
  for (const auto& [file, hash] : outputs.items())
    if (!kept.contains(file) && std::filesystem::exists(path_ / file) &&
        sha256_of_file(path_ / file) == hash)
      std::filesystem::remove(path_ / file);
}

std::string RunFolder::key_of(const std::string& text) const {
  return sha256_of_text(program_ + text);
}

bool RunFolder::stage(const std::string& name, const std::string& key_text,
                      const std::function<std::vector<std::string>()>& body) {
  throw_if_stopped();
  const std::string key = key_of(key_text);
  if (up_to_date(name, key)) return false;

  const auto begin = std::chrono::steady_clock::now();
  nlohmann::json outputs = nlohmann::json::object();
  for (const std::string& file : body()) outputs[file] = sha256_of_file(path_ / file);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  const nlohmann::json* before = record_of(name);
  const nlohmann::json old = before == nullptr ? nlohmann::json::object() : before->at("outputs");
  manifest_["stages"][name] = {{"key", key},
                               {"inputs", sha256_of_text(key_text)},
                               {"outputs", outputs},
                               {"seconds", elapsed.count()}};
  save();
  remove_unless_changed(old, outputs);
  return true;
}

void RunFolder::describe(const std::string& key, const nlohmann::json& value) {
  if (manifest_.contains(key) && manifest_[key] == value) return;
  manifest_[key] = value;
  save();
}

nlohmann::json RunFolder::described(const std::string& key) const {
  return manifest_.value(key, nlohmann::json());
}

std::string RunFolder::outputs_of(const std::string& name) const {
  const nlohmann::json* record = record_of(name);
  if (record == nullptr)
    throw UserError("{}: {} was not done; run `fricid run {}` first", path_.string(), name,
                    path_.string());
  return record->at("outputs").dump();
}

double RunFolder::seconds_of(const std::string& name) const {
  return manifest_.at("stages").at(name).at("seconds").get<double>();
}

void RunFolder::save() const {
  write_file_atomically(path_ / "manifest.json", manifest_.dump(2) + "\n");
}

}  // namespace fricid::cli
