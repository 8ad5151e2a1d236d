// An open run folder: locked, with its manifest.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "fricid/base/files.hpp"
#include "fricid/workflow/inputs.hpp"
#include "fricid/workflow/manifest.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::workflow {

/// Result of the work of a stage.
struct Done {
  std::vector<std::filesystem::path> files;  ///< files that it wrote
  /// Duration without the work shared with other stages [s]; NaN: the measured wall-clock time.
  double seconds = std::numeric_limits<double>::quiet_NaN();
};

/// One step of a run: its inputs, and a function that makes files from these only.
struct Stage {
  std::string name;
  Inputs inputs;
  /// @param visible  the run folder restricted to the files that `inputs` declares
  std::function<Done(const RunFolder& visible)> work;
};

/// An open run folder. A stage whose inputs and outputs are as recorded is skipped, so an
/// interrupted run resumes where it stopped. A new folder in which no stage left anything is
/// removed again.
class Run {
 public:
  /// Opens or creates a folder and locks it. Accepted are a folder of an earlier run (it has a
  /// manifest), an empty one and a new one.
  /// @param fresh  do every stage, up to date or not
  /// @throws UserError when it is something else, a link leads out of it, or another run has locked
  /// it
  static Run open(const std::filesystem::path& path, bool fresh);
  ~Run();
  Run(Run&&) = default;

  const RunFolder& folder() const { return folder_; }
  const Manifest& manifest() const { return manifest_; }
  /// Changes the manifest and saves it.
  void describe(const std::function<void(Manifest&)>& change);

  /// Does a stage unless it is up to date. Files that it wrote last time and no longer writes are
  /// removed unless they were changed since. @return true when it ran
  bool perform(const Stage& stage);

  /// Whether the stage was done from these inputs, by any build of the program, and its files are
  /// unchanged.
  bool stands(const Stage& stage) const;
  /// Whether a stage was done and its files are unchanged.
  bool intact(std::string_view stage) const;
  bool intact(const StageRecord& record) const;
  /// Record of a stage whose files are unchanged and made from the present files of the run.
  /// @throws UserError when the stage was not done, or naming a file that was changed
  const StageRecord& results_of(const std::string& stage) const;
  /// Names of the inputs that changed since the stage was last done.
  std::vector<std::string> changed(const Stage& stage) const;

  /// Key of the checkpoint of a stage: a hash of the program and the inputs.
  std::string key_of(const Stage& stage) const;

 private:
  Run(std::filesystem::path path, bool fresh);
  bool is_as_written(const Content& output) const;
  void remove_outputs(const std::vector<Content>& before, const std::vector<Content>& now) const;
  void save();

  RunFolder folder_;
  bool new_;    // the folder was made here
  bool empty_;  // no manifest was found
  bool fresh_;  // do every stage, up to date or not
  std::unique_ptr<FileLock> lock_;
  std::string program_;  // hash of the running program: another build repeats stages
  Manifest manifest_;
  mutable std::set<std::string> verified_;  // stages whose files were found unchanged
};

/// @throws UserError when the folder holds files that no run made, or links, which could lead out
/// of it
void require_own_folder(const RunFolder& folder);
/// @throws UserError unless `path` is the folder of an earlier run
void require_run_folder(const std::filesystem::path& path);
bool is_run_folder(const std::filesystem::path& path);

}  // namespace fricid::workflow
