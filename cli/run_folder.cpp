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
  const auto stages = manifest_.find("stages");
  if (stages == manifest_.end() || !stages->contains(name)) return false;
  const auto& stage = (*stages)[name];
  if (stage["key"] != key) return false;
  for (const auto& [file, hash] : stage["outputs"].items())
    if (!std::filesystem::exists(path_ / file) || sha256_of_file(path_ / file) != hash)
      return false;
  return true;
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
  manifest_["stages"][name] = {{"key", key}, {"outputs", outputs}, {"seconds", elapsed.count()}};
  save();
  return true;
}

void RunFolder::describe(const std::string& key, const nlohmann::json& value) {
  if (manifest_.contains(key) && manifest_[key] == value) return;
  manifest_[key] = value;
  save();
}

std::string RunFolder::outputs_of(const std::string& name) const {
  return manifest_.at("stages").at(name).at("outputs").dump();
}

double RunFolder::seconds_of(const std::string& name) const {
  return manifest_.at("stages").at(name).at("seconds").get<double>();
}

void RunFolder::save() const {
  write_file_atomically(path_ / "manifest.json", manifest_.dump(2) + "\n");
}

}  // namespace fricid::cli
