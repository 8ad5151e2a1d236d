#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "fricid/base/files.hpp"

namespace fricid::cli {

/// A run folder and its manifest.json. The work is cut into stages; a stage whose key and outputs
/// are as recorded is skipped, so an interrupted run goes on where it stopped. A folder that was
/// made for a run which then finished no stage is removed again.
class RunFolder {
 public:
  /// Opens or creates the folder and locks it. @throws UserError when another run holds it
  RunFolder(std::filesystem::path path, bool fresh);
  ~RunFolder();
  RunFolder(RunFolder&&) = default;

  /// Does `body` unless `key` and the hashes of the outputs it named last time are unchanged.
  /// `body` returns the files it wrote, relative to the folder; what it wrote last time and no
  /// longer writes is removed, unless somebody changed it since. @return true when it ran
  bool stage(const std::string& name, const std::string& key,
             const std::function<std::vector<std::string>()>& body);

  /// Whether the stage was done from what `key` says, by this build of the program or another, and
  /// what it wrote stands as it was.
  bool stands(const std::string& name, const std::string& key) const;
  /// Whether the stage was done and what it wrote stands as it was.
  bool intact(const std::string& name) const;

  /// Names of the stages that are done.
  std::vector<std::string> stages() const;

  /// What a stage with this key depends on, this build of the program included, as 64 digits.
  std::string key_of(const std::string& text) const;

  /// Records facts about the run (seeds, inputs, machine) in the manifest.
  void describe(const std::string& key, const nlohmann::json& value);
  /// What was recorded; null where nothing was.
  nlohmann::json described(const std::string& key) const;

  /// Hashes of everything a stage wrote, as one text: part of the key of what depends on it.
  /// @throws UserError when it was not done
  std::string outputs_of(const std::string& name) const;

  /// Wall-clock seconds that a stage took when it last ran.
  double seconds_of(const std::string& name) const;

  const std::filesystem::path& path() const { return path_; }

 private:
  bool up_to_date(const std::string& name, const std::string& key) const;
  const nlohmann::json* record_of(const std::string& name) const;  // null when it was not done
  void remove_unless_changed(const nlohmann::json& outputs, const nlohmann::json& kept) const;
  void save() const;

  bool made_;   // here, not found
  bool fresh_;  // stages are done whatever the manifest says
  std::filesystem::path path_;
  std::unique_ptr<FileLock> lock_;
  std::string program_;  // hash of the running program: another build does its work anew
  nlohmann::json manifest_;
};

}  // namespace fricid::cli
