// manifest.json: the stages run in a folder, with their inputs, outputs, program and duration.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::workflow {

/// A file or an option, and the hash of its content.
struct Content {
  std::string name;    ///< of an input, or of a file relative to the run folder
  std::string sha256;  ///< 64 hexadecimal digits

  bool operator==(const Content&) const = default;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name,
            text("name of the input, or path of the file relative to the run folder"));
    archive("sha256", sha256, text("64 hexadecimal digits of its content"));
  }
};

/// Record of a stage that was run.
struct StageRecord {
  std::string name;              ///< "simulate", "identify lugre_s1", ...
  std::string program;           ///< SHA-256 of the program that ran it
  std::vector<Content> inputs;   ///< all that it read, sorted by name
  std::vector<Content> outputs;  ///< all files that it wrote, sorted by name
  double seconds = 0;            ///< wall clock
  /// seal_of(record) when it was written; another one: altered since, and not to be believed.
  std::optional<std::string> seal;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("name of the stage"));
    archive("program", program, text("SHA-256 of the program that ran it"));
    archive("seconds", seconds, number("s", 0, 1e12, "wall-clock time"));
    archive.sections("inputs", inputs, "everything that it read");
    archive.sections("outputs", outputs, "all files that it wrote");
    archive("seal", seal, text("SHA-256 of name, program, inputs and outputs"));
  }
};

/// SHA-256 of what a record says was done.
std::string seal_of(const StageRecord& record);

struct Machine {
  std::string cpu;
  int cores = 0;

  template <class Archive>
  void visit(Archive& archive) {
    archive("cpu", cpu, text("model of the processor"));
    archive("cores", cores, number("", 0, 1e6, "number of hardware threads"));
  }
};

struct Manifest {
  static constexpr std::string_view kFormat = "fricid.manifest/2";

  std::string version, commit;  ///< of the program that last wrote the manifest
  Machine machine;
  std::string scene;  ///< name
  std::uint64_t seed = 0;
  std::vector<Content> sources;             ///< files that the scene names, by absolute path
  std::vector<std::string> fitted_by_name;  ///< fits requested from `fricid identify` by name
  std::vector<StageRecord> stages;          ///< in the order in which they were first done

  const StageRecord* find(std::string_view stage) const;  ///< null: was not run
  StageRecord& at(const std::string& stage);              ///< created if missing

  /// @throws UserError when an output lies outside of the run folder, a stage or an output is there
  /// twice, or a text is not printable
  void check(const std::string& place) const;

  template <class Archive>
  void visit(Archive& archive) {
    archive("version", version, text("version of fricid"));
    archive("commit", commit, text("commit of fricid"));
    archive.section("machine", machine, "where it ran last");
    archive("scene", scene, text("name of the scene"));
    archive("seed", seed, number("", 0, 9e15, "seed of the scene"));
    archive.sections("sources", sources, "files that the scene names");
    archive("fitted_by_name", fitted_by_name,
            text("fits requested by name, in addition to those of the scene"));
    archive.sections("stages", stages, "stages that were run");
  }
};

/// How the names of recordings in a run folder begin.
constexpr std::string_view kTrainingData = "data/train_", kValidationData = "data/validation_";

/// Name of the stage that makes a fit: "identify lugre_s1".
std::string stage_of(const FitId& fit);
/// The inverse. Empty: a stage that makes no fit.
std::optional<FitId> fit_of(std::string_view stage);

/// Data, models and fits that a stage was made from and that other stages have since written
/// otherwise or no more, and recordings that came beside them, in few words: "data/train_0.h5".
/// Empty: none. A fit that came beside is none.
std::string changed_since(const Manifest& manifest, const StageRecord& record);

/// Why a file of a run is no result of its present data and fits, in one line; empty: it is.
/// Whether scene, robot and logs are as they were is for `fits_of` and `Run::stands`.
std::string outdated(const RunFolder& run, const Manifest& manifest,
                     const std::filesystem::path& file);

/// Key of what a run is made of: robot, data and [identify], apart from name and seed of the scene.
/// Empty: its data were not made.
std::string problem_key(const Manifest& manifest);
/// Key of the settings of every fit, by its name: "lvm_s1".
std::map<std::string, std::string> fit_keys(const Manifest& manifest);

/// Wall clock of the fits by model, mean over seeds [s].
std::map<std::string, double> fit_seconds(const Manifest& manifest);

}  // namespace fricid::workflow
