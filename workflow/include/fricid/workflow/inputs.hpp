// Declaration of the inputs of a stage.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "fricid/workflow/manifest.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::workflow {

/// The declaration of a stage: everything its result depends on, by name and content. What makes a
/// stage run again is derived from it, and the stage sees no other file of the run folder.
class Inputs {
 public:
  explicit Inputs(const RunFolder& folder) : folder_(folder) {}

  /// A text, such as the TOML of a section of the scene.
  void text(const std::string& name, std::string_view value);
  /// A file outside of the run folder. @throws UserError when it cannot be read
  void file(const std::string& name, const std::filesystem::path& path);
  /// All files of a folder of the run and below, by content; none where it is not there.
  void files_below(const std::filesystem::path& folder);
  /// The files that another stage wrote, or those of them whose names begin so.
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

/// Names of the inputs that differ: other content, new, or gone.
std::vector<std::string> differences(const std::vector<Content>& before,
                                     const std::vector<Content>& now);

}  // namespace fricid::workflow
