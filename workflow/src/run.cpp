#include "fricid/workflow/run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "fricid/base/error.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/workflow/version.hpp"

namespace fricid::workflow {
namespace {

namespace fs = std::filesystem;

std::string cpu_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (const std::size_t colon = line.find(": ");
        line.starts_with("model name") && colon != line.npos)
      return line.substr(colon + 2);
  return "unknown";
}

/// A manifest as it stands in its file.
struct Unchecked : Manifest {
  void check() const = delete;
};

/// The stages that can be used of a manifest that as a whole cannot.
Manifest sound_part(const fs::path& file) {
  Manifest sound;
  const auto may_stand = [&] {
    try {
      sound.check(file.string());
      return true;
    } catch (const UserError&) {
      return false;
    }
  };
  try {
    const auto all = data::load<Unchecked>(file);
    sound.fitted_by_name = all.fitted_by_name;
    if (!may_stand()) sound.fitted_by_name.clear();
    for (const StageRecord& stage : all.stages) {
      sound.stages.push_back(stage);
      if (!may_stand()) sound.stages.pop_back();
    }
  } catch (const UserError&) {
    return {};  // no manifest at all
  }
  return sound;
}

/// @param fresh  leave out what cannot be used
Manifest read_manifest(const fs::path& file, bool fresh) {
  if (!fs::exists(file)) return {};
  Manifest manifest;
  bool earlier = false;
  try {
    earlier = data::format_of(file) == "fricid.manifest/1";
    if (!earlier) manifest = data::load<Manifest>(file);
  } catch (const UserError& error) {
    if (!fresh) throw UserError("{}; with --fresh what is wrong there is done again", error.what());
    manifest = sound_part(file);
  }
  if (earlier)
    throw UserError(
        "{}: made by an earlier version of fricid (fricid.manifest/1); name another folder with -o "
        "or remove this one",
        file.string());
  // what an altered record says was done is done again
  std::erase_if(manifest.stages,
                [](const StageRecord& record) { return record.seal != seal_of(record); });
  return manifest;
}

void create(const fs::path& path) {
  std::error_code failure;
  fs::create_directories(path, failure);
  if (failure || !fs::is_directory(path))
    throw UserError("{}: cannot make this folder: {}", path.string(), failure.message());
}

}  // namespace

void require_own_folder(const RunFolder& folder) {
  const fs::path& path = folder.path();
  if (!fs::exists(path)) return;
  if (!fs::is_directory(path))
    throw UserError("{}: found a file; allowed: the folder of a run, an empty or a new one",
                    path.string());
  if (!fs::exists(folder.manifest()))
    for (const auto& entry : fs::directory_iterator(path))
      if (!is_left_temporary(entry.path()) && entry.path() != folder.lock())
        throw UserError(
            "{}: found {} and no manifest.json; allowed: the folder of a run, an empty or a new "
            "one",
            path.string(), entry.path().filename().string());
  for (auto entry = fs::recursive_directory_iterator(path); entry != fs::end(entry); ++entry) {
    if (entry->path() == folder.external()) {
      entry.disable_recursion_pending();  // read only, never written
    } else if (entry->is_symlink()) {
      throw UserError("{}: found a symbolic link; allowed: files and folders of a run",
                      entry->path().string());
    }
  }
}

bool is_run_folder(const fs::path& path) { return fs::exists(RunFolder(path).manifest()); }

void require_run_folder(const fs::path& path) {
  if (!is_run_folder(path))
    throw UserError("{}: found no manifest.json; allowed: the folder of a run", path.string());
}

Run Run::open(const fs::path& path, bool fresh) {
  require_own_folder(RunFolder(path));
  return {path, fresh};
}

Run::Run(fs::path path, bool fresh)
    : folder_(std::move(path)),
      new_(!fs::exists(folder_.path())),
      empty_(!fs::exists(folder_.manifest())),
      fresh_(fresh),
      program_(sha256_of_file(running_file())) {
  create(folder_.path());
  lock_ = std::make_unique<FileLock>(folder_.lock());
  manifest_ = read_manifest(folder_.manifest(), fresh);
  remove_left_temporaries(folder_.path());
  if (fresh_) fs::remove_all(folder_.checkpoints());
  manifest_.version = kVersion;
  manifest_.commit = kCommit;
  manifest_.machine = {cpu_name(), static_cast<int>(std::thread::hardware_concurrency())};
}

Run::~Run() {
  const bool moved = !lock_;
  if (moved || !empty_ || !manifest_.stages.empty()) return;
  const std::set<fs::path> own{folder_.manifest(), folder_.scene(), folder_.lock()};
  std::error_code kept;
  // a stage that was cut short may have left files: with the manifest the folder is one of a run
  fs::directory_iterator entry(folder_.path(), kept);
  for (; !kept && entry != fs::end(entry); entry.increment(kept))
    if (!own.contains(entry->path())) return;
  for (const fs::path& file : own) fs::remove(file, kept);
  if (new_) fs::remove(folder_.path(), kept);
}

void Run::describe(const std::function<void(Manifest&)>& change) {
  const std::string before = data::to_json(manifest_);
  change(manifest_);
  if (data::to_json(manifest_) != before || !fs::exists(folder_.manifest())) save();
}

bool Run::intact(const StageRecord& record) const {
  return std::ranges::all_of(record.outputs,
                             [&](const Content& output) { return is_as_written(output); });
}

bool Run::is_as_written(const Content& output) const {
  const fs::path file = folder_.path() / output.name;
  return fs::exists(file) && sha256_of_file(file) == output.sha256;
}

bool Run::intact(std::string_view stage) const {
  const StageRecord* record = manifest_.find(stage);
  return record != nullptr && intact(*record);
}

bool Run::stands(const Stage& stage) const {
  const StageRecord* record = manifest_.find(stage.name);
  return record != nullptr && record->inputs == stage.inputs.contents() && intact(*record);
}

const StageRecord& Run::results_of(const std::string& stage) const {
  const StageRecord* record = manifest_.find(stage);
  const std::string folder = folder_.path().string();
  if (record == nullptr)
    throw UserError("{}: {} was not done; run `fricid run {}` first", folder, stage, folder);
  if (const auto changed = changed_since(manifest_, *record); !changed.empty())
    throw UserError("{}: {} was done with another {}; `fricid {} {}` does it again", folder, stage,
                    changed, stage == "evaluate" ? "evaluate" : "run", folder);
  if (verified_.contains(stage)) return *record;
  for (const Content& output : record->outputs)
    if (!is_as_written(output))
      throw UserError("{}: changed since the stage {} wrote it; `fricid run {}` makes it again",
                      (folder_.path() / output.name).string(), stage, folder);
  verified_.insert(stage);
  return *record;
}

std::vector<std::string> Run::changed(const Stage& stage) const {
  const StageRecord* record = manifest_.find(stage.name);
  return differences(record == nullptr ? std::vector<Content>() : record->inputs,
                     stage.inputs.contents());
}

std::string Run::key_of(const Stage& stage) const {
  return sha256_of_text(program_ + workflow::key_of(stage.inputs.contents()));
}

bool Run::perform(const Stage& stage) {
  throw_if_stopped();
  const StageRecord* before = manifest_.find(stage.name);
  if (!fresh_ && before != nullptr && before->program == program_ && stands(stage)) return false;

  StageRecord record;
  record.name = stage.name;
  record.program = program_;
  record.inputs = stage.inputs.contents();
  const auto begin = std::chrono::steady_clock::now();
  const Done done = stage.work(stage.inputs.visible());
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  record.seconds = std::isnan(done.seconds) ? elapsed.count() : done.seconds;
  for (const fs::path& file : done.files)
    record.outputs.push_back({folder_.name_of(file), sha256_of_file(file)});
  std::ranges::sort(record.outputs, {}, &Content::name);
  const auto twice = std::ranges::adjacent_find(record.outputs, {}, &Content::name);
  if (twice != record.outputs.end())
    throw std::logic_error("two outputs are called " + twice->name);

  StageRecord& kept = manifest_.at(stage.name);
  const std::vector<Content> old = std::move(kept.outputs);
  kept = std::move(record);
  save();
  verified_.insert(stage.name);
  remove_outputs(old, kept.outputs);
  return true;
}

void Run::remove_outputs(const std::vector<Content>& before,
                         const std::vector<Content>& now) const {
  for (const Content& old : before) {
    if (std::ranges::find(now, old.name, &Content::name) == now.end() && is_as_written(old))
      fs::remove(folder_.path() / old.name);
  }
}

void Run::save() {
  for (StageRecord& record : manifest_.stages) record.seal = seal_of(record);
  data::save(manifest_, folder_.manifest());
}

}  // namespace fricid::workflow
