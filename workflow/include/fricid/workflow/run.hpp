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
  std::vector<std::filesystem::path> files;  ///< that it wrote
  /// Duration without the work shared with other stages [s]; NaN: the measured wall-clock time.
  double seconds = std::numeric_limits<double>::quiet_NaN();
};

/// One step of a run: its inputs, and a function that makes files from these alone.
struct Stage {
  std::string name;
  Inputs inputs;
  /// @param visible  the run folder, without what `inputs` does not declare
  std::function<Done(const RunFolder& visible)> work;
};

/// An open run folder. A stage whose inputs and outputs are as recorded is not done again, so an
/// interrupted run goes on where it stopped. What was made for a run which then finished no stage
/// is removed again.
class Run {
 public:
  /// Opens or creates a folder and locks it. Taken are a folder that a run made (it has a
  /// manifest), an empty one and a new one.
  /// @param fresh  every stage is done, whatever the manifest says
  /// @throws UserError when it is something else, a link leads out of it, or another run holds it
  static Run open(const std::filesystem::path& path, bool fresh);
  ~Run();
  Run(Run&&) = default;

  const RunFolder& folder() const { return folder_; }
  const Manifest& manifest() const { return manifest_; }
  /// Changes what the manifest says of the run, and saves it.
  void describe(const std::function<void(Manifest&)>& change);

  /// Does a stage unless it is up to date. Files that it wrote last time and no longer writes are
  /// removed, unless somebody changed them since. @return true when it ran
  bool perform(const Stage& stage);

  /// Whether the stage was done from these inputs, by this build of the program or another, and
  /// what it wrote is as it was.
  bool stands(const Stage& stage) const;
  /// Whether a stage was done and what it wrote is as it was.
  bool intact(std::string_view stage) const;
  bool intact(const StageRecord& record) const;
  /// Record of a stage whose files are as it wrote them.
  /// @throws UserError when it was not done, or a file was changed since, naming it
  const StageRecord& results_of(const std::string& stage) const;
  /// Names of the inputs of a stage that are not those it was last done from.
  std::vector<std::string> changed(const Stage& stage) const;

  /// Key of the checkpoint of a stage: a hash of the program and the inputs.
  std::string key_of(const Stage& stage) const;

 private:
  Run(std::filesystem::path path, bool fresh);
  bool is_as_written(const Content& output) const;
  void remove_outputs(const std::vector<Content>& before, const std::vector<Content>& now) const;
  void save() const;

  RunFolder folder_;
  bool new_;    // the folder was made here
  bool empty_;  // no manifest was found
  bool fresh_;  // stages are done whatever the manifest says
  std::unique_ptr<FileLock> lock_;
  std::string program_;  // hash of the running program: another build does its work anew
  Manifest manifest_;
  mutable std::set<std::string> verified_;  // stages whose files were found as written
};

/// @throws UserError when the folder holds what no run made, or a link: it could lead out of it
void require_own_folder(const RunFolder& folder);
/// @throws UserError unless `path` is the folder of an earlier run
void require_run_folder(const std::filesystem::path& path);
bool is_run_folder(const std::filesystem::path& path);

}  // namespace fricid::workflow
