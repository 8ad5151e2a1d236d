// Paths of the files of a run, the only place where their names are defined.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace fricid::workflow {

/// One fit: a model of the scene and a seed.
struct FitId {
  std::string model;
  int seed = 1;

  std::string name() const;  ///< stem of its files: "lugre_s1"
  /// The inverse of `name`. Empty: not such a name.
  static std::optional<FitId> parse(std::string_view name);

  bool operator==(const FitId&) const = default;
};

/// A run folder as a value: paths of the files that a run may have. Creates nothing. A recording is
/// called "train_0", "validation_0", ...
///
/// A stage gets it restricted to the files that it declared: paths of other data, fits and results
/// are such that no file is there, and say why. Pictures are listed by `files_in`.
class RunFolder {
 public:
  explicit RunFolder(std::filesystem::path path) : path_(std::move(path)) {}

  const std::filesystem::path& path() const { return path_; }
  /// A file of the folder as the manifest names it: relative, with slashes.
  std::string name_of(const std::filesystem::path& file) const;
  /// The same folder with only these of its visible files visible.
  RunFolder restricted_to(std::set<std::string> names) const;
  /// Files with an extension (".svg") in a folder of the run, not below it, sorted by name.
  std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder,
                                              std::string_view extension) const;

  std::filesystem::path scene() const { return at("scene.toml"); }
  std::filesystem::path manifest() const { return path_ / "manifest.json"; }
  std::filesystem::path lock() const { return path_ / ".lock"; }

  static std::string training(int i);    ///< name of the i-th training recording
  static std::string validation(int i);  ///< name of the i-th held-out recording
  static std::string loaded(int i);      ///< name of the i-th recording with an unknown load
  std::filesystem::path recordings() const { return path_ / "data"; }
  std::filesystem::path recording(const std::string& name) const;
  std::filesystem::path diagnosis(const std::string& name) const;
  /// The diagnosis of a recording, which need not be in a run folder.
  static std::filesystem::path diagnosis_beside(const std::filesystem::path& recording);
  std::filesystem::path truth(const std::string& name) const;
  std::filesystem::path excitation() const { return at("excitation.json"); }

  std::filesystem::path models() const { return path_ / "models"; }
  std::filesystem::path model(const FitId& id) const;
  std::filesystem::path fits() const { return path_ / "fit"; }
  std::filesystem::path fit(const FitId& id) const;
  std::filesystem::path checkpoint(const FitId& id) const;
  std::filesystem::path checkpoints() const { return path_ / "checkpoint"; }

  std::filesystem::path evaluation() const { return at("evaluation.json"); }
  std::filesystem::path table() const { return at("table.md"); }
  std::filesystem::path table_csv() const { return at("table.csv"); }
  std::filesystem::path torque_table() const { return at("torque.md"); }
  std::filesystem::path starts() const { return at("starts.csv"); }
  std::filesystem::path rollout(const FitId& id, const std::string& recording) const;
  std::filesystem::path prediction(const FitId& id, const std::string& recording) const;
  std::filesystem::path estimate(const FitId& id, const std::string& recording) const;
  std::filesystem::path estimates() const { return path_ / "estimates"; }
  std::filesystem::path band(const std::string& model, const std::string& recording) const;
  /// Rollouts of other programs, one folder per model.
  std::filesystem::path external() const { return path_ / "external"; }

  std::filesystem::path payload() const { return at("payload.json"); }

  std::filesystem::path compensation() const { return at("compensation.json"); }
  std::filesystem::path compensation_table() const { return at("compensation.md"); }
  /// A closed loop with the friction of a model fed forward, by index of its path and controller.
  std::filesystem::path loop(const std::string& model, int path, int controller) const;

  std::filesystem::path contact() const { return at("contact.json"); }
  std::filesystem::path contact_table() const { return at("contact.md"); }
  /// External torque that an observer with a model's friction saw during the first pushes, and the
  /// motion under them.
  std::filesystem::path external_torque(const std::string& model) const;
  std::filesystem::path pushed_loop() const { return at("contact/pushes.h5"); }

  std::filesystem::path plots() const { return path_ / "plots"; }
  std::filesystem::path plot(const std::string& name, const std::string& extension) const;
  std::filesystem::path videos() const { return path_ / "video"; }
  std::filesystem::path video(const std::string& name) const;
  std::filesystem::path check() const { return path_ / "check.json"; }
  std::filesystem::path report() const { return path_ / "report.html"; }

 private:
  bool shows(const std::string& name) const;
  std::filesystem::path at(const std::string& name) const;

  std::filesystem::path path_;
  std::shared_ptr<const std::set<std::string>> visible_;  // null: all
};

}  // namespace fricid::workflow
