// Declaration of the inputs of a stage.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "fricid/workflow/manifest.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::workflow {

/// The declaration of a stage: everything its result depends on, by name and content. A stage runs
/// again when its declaration changes, and sees only the declared files of the run folder.
class Inputs {
 public:
  explicit Inputs(const RunFolder& folder) : folder_(folder) {}

  /// A text, such as the TOML of a section of the scene.
  void text(const std::string& name, std::string_view value);
  /// A file outside of the run folder. @throws UserError when it cannot be read
  void file(const std::string& name, const std::filesystem::path& path);
  /// All files below a folder of the run, by content; none if it does not exist.
  void files_below(const std::filesystem::path& folder);
  /// The files that another stage wrote and whose names begin with `begin`.
  void outputs_of(const StageRecord& stage, std::string_view begin = {});

  /// Sorted by name. @throws std::logic_error when two have one name
  std::vector<Content> contents() const;
  /// The run folder as the stage sees it: only the declared files.
  RunFolder visible() const;

 private:
  void add(const std::string& name, std::string sha256);

  RunFolder folder_;
  std::vector<Content> contents_;
  std::set<std::string> visible_;
};

/// SHA-256 of a declaration, as 64 digits.
std::string key_of(const std::vector<Content>& inputs);

/// Names of the inputs that differ: changed, added or removed.
std::vector<std::string> differences(const std::vector<Content>& before,
                                     const std::vector<Content>& now);

}  // namespace fricid::workflow
