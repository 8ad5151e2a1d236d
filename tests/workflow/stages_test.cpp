// The law of stages: change what a stage declares and it runs again, and all that follow from it;
// change anything else and it does not.
#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <set>

#include "fricid/base/error.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/section.hpp"
#include "source_dir.hpp"
#include "temporary_folder.hpp"

namespace fricid::workflow {
namespace {

static_assert(name_of(Section::kRender) == "[render]");

namespace fs = std::filesystem;
using Names = std::set<std::string>;
using Declarations = std::map<std::string, std::vector<Content>>;  ///< by stage

/// Changes the n-th value of a scene, and says which top-level section it belongs to.
class Mutation {
 public:
  explicit Mutation(int target) : target_(target) {}

  template <class Value>
  void operator()(std::string_view key, Value& value, const Field& /*field*/) {
    if (next_++ != target_) return;
    key_ = section_.empty() ? std::string(key) : section_;
    change(value);
  }
  void text_unless_tables(std::string_view key, std::string& value, const Field& field) {
    (*this)(key, value, field);
  }
  template <class Part>
  void tables_unless_text(std::string_view key, std::vector<Part>& parts,
                          std::string_view meaning) {
    sections(key, parts, meaning);
  }
  template <class Part>
  void section(std::string_view key, Part& part, std::string_view /*meaning*/) {
    const std::string outer = section_;
    if (section_.empty()) section_ = key;
    part.visit(*this);
    section_ = outer;
  }
  void section(std::string_view key, std::optional<friction::Friction>& friction,
               std::string_view /*meaning*/) {
    if (!friction) return;
    for (double& value : friction->theta) {
      if (next_++ != target_) continue;
      key_ = key;
      value *= 1.01;
    }
  }
  template <class Part>
  void sections(std::string_view key, std::vector<Part>& parts, std::string_view /*meaning*/) {
    const std::string outer = section_;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (outer.empty()) section_ = std::string(key) + " " + std::to_string(i);
      parts[i].visit(*this);
      section_ = outer;
    }
  }

  /// Empty: the scene has no more values.
  const std::string& key() const { return key_; }

 private:
  static void change(double& value) { value = value == 0 ? 0.5 : 1.01 * value; }
  static void change(int& value) { ++value; }
  static void change(std::uint64_t& value) { ++value; }
  static void change(bool& value) { value = !value; }
  static void change(std::string& value) { value += "x"; }
  template <fricid::NamedEnum E>
  static void change(E& value) {
    const auto next = static_cast<std::size_t>(value) + 1;
    value = static_cast<E>(next % all_names<E>().size());
  }
  template <class Value>
  static void change(std::optional<Value>& value) {
    change(value.value());
  }
  template <class Value>
  static void change(std::vector<Value>& values) {
    values.emplace_back();
  }
  static void change(std::map<std::string, double>& values) { values["x"] = 1; }
  static void change(std::vector<int>& values) {
    for (int& value : values) ++value;
  }
  template <std::size_t N>
  static void change(std::array<double, N>& values) {
    values[0] += 0.1;
  }

  int target_, next_ = 0;
  std::string section_, key_;
};

/// A run folder in which every stage was done, by name only: its files hold a line each.
class Stages : public TemporaryFolder {
 protected:
  Stages() {
    const scene::Problem problem = load_problem(tiny());
    scene::Scene scene = problem.scene;
    scene.payload.mass_kg = 1;
    scene.compensation.gains = {1};
    scene.contact.hours = 1;
    job.emplace(open_job(with_scene(problem, std::move(scene)), folder / "run", false, 1,
                         [](const std::string&) {}));
    const RunFolder& run = job->run.folder();
    record("data", {run.recording("train_0"), run.recording("validation_0"), run.truth("train_0"),
                    run.truth("validation_0"), run.excitation()});
    for (const FitRequest& fit : fits())
      record(fit_stage(*job, fit).name, {run.model(fit.id()), run.fit(fit.id())});
    record("evaluate", {run.evaluation(), run.table(), run.rollout({"lugre", 1}, "validation_0")});
    record("payload", {run.recording("loaded_0"), run.payload()});
    record("compensate", {run.compensation(), run.compensation_table(), run.loop("lugre", 0, 0)});
    record("contact", {run.contact(), run.contact_table(), run.external_torque("lugre")});
    record("plots", {run.plot("tracking", "svg")});
    record("video", {run.video("comparison")});
    record("report", {run.report()});
  }

  static fs::path tiny() { return source_dir() / "tests/e2e/tiny.toml"; }

  std::vector<FitRequest> fits() const { return requested_fits(job->problem.scene, {}, {}); }

  /// The same run with another problem.
  void put(const scene::Problem& problem) {
    Job other{problem, job->mjcf, std::move(job->run), job->jobs, job->say};
    job.emplace(std::move(other));
  }

  /// What the stages declare; one whose results to read are not of the present files declares none.
  Declarations declarations() const {
    Declarations made;
    const auto add = [&](const std::string& name, const std::function<Stage()>& make) {
      try {
        made[name] = make().inputs.contents();
      } catch (const UserError&) {
        made[name].clear();
      }
    };
    add("data", [&] { return data_stage(*job); });
    for (const FitRequest& fit : fits())
      add(stage_of(fit.id()), [&] { return fit_stage(*job, fit); });
    add("evaluate", [&] { return evaluation_stage(*job, {}); });
    add("payload", [&] { return payload_stage(*job); });
    add("compensate", [&] { return compensation_stage(*job); });
    add("contact", [&] { return contact_stage(*job); });
    add("plots", [&] { return plots_stage(*job); });
    add("video", [&] { return film_stage(*job, job->problem, ""); });
    add("report", [&] { return report_stage(*job); });
    return made;
  }

  /// Writes a stage's files and its record, as if it had been done from what it declares now.
  void record(const std::string& name, const std::vector<fs::path>& files) {
    job->run.describe([&](Manifest& manifest) {
      StageRecord& done = manifest.at(name);
      for (const fs::path& file : files) {
        write_file_atomically(file, file.string());
        done.outputs.push_back({job->run.folder().name_of(file), sha256_of_file(file)});
      }
    });
    for (const Stage& stage : made_so_far(name))
      if (stage.name == name)
        job->run.describe(
            [&](Manifest& manifest) { manifest.at(name).inputs = stage.inputs.contents(); });
  }

  std::vector<Stage> made_so_far(const std::string& name) const {
    if (name == "data") return {data_stage(*job)};
    if (name.starts_with("identify")) {
      std::vector<Stage> stages;
      for (const FitRequest& fit : fits()) stages.push_back(fit_stage(*job, fit));
      return stages;
    }
    if (name == "evaluate") return {evaluation_stage(*job, {})};
    if (name == "payload") return {payload_stage(*job)};
    if (name == "compensate") return {compensation_stage(*job)};
    if (name == "contact") return {contact_stage(*job)};
    return {};
  }

  /// Stages whose declarations differ.
  static Names changed(const Declarations& before, const Declarations& now) {
    Names names;
    for (const auto& [stage, inputs] : now)
      if (!before.contains(stage) || before.at(stage) != inputs) names.insert(stage);
    return names;
  }

  std::optional<Job> job;
};

/// Stages that read a section themselves. What follows from the data and the fits runs again
/// because their files change.
Names readers_of(const std::string& section) {
  static const std::map<std::string, Names> kReaders{
      {"name", {"data", "evaluate", "payload", "compensate", "contact", "video", "report"}},
      {"description", {"video", "report"}},
      {"seed", {"data", "payload", "compensate", "contact", "report"}},
      {"robot",
       {"data", "identify simple_s1", "identify lugre_s1", "evaluate", "payload", "compensate",
        "contact", "plots", "video", "report"}},
      {"friction", {"data", "evaluate", "payload", "compensate", "contact", "video", "report"}},
      {"plant", {"data", "evaluate", "payload", "compensate", "contact", "report"}},
      {"controller", {"data", "payload", "compensate", "contact", "report"}},
      {"excitation", {"data", "payload", "compensate", "contact", "report"}},
      {"sensors", {"data", "payload", "compensate", "contact", "report"}},
      {"data", {"report"}},  // of a simulated scene
      {"identify", {"identify simple_s1", "identify lugre_s1", "evaluate", "payload", "report"}},
      {"model 0", {"identify simple_s1", "report"}},
      {"model 1", {"identify lugre_s1", "report"}},
      {"evaluate", {"evaluate", "report"}},
      {"payload", {"payload", "report"}},
      {"compensation", {"compensate", "report"}},
      {"contact", {"contact", "report"}},
      {"render", {"video", "report"}}};
  const auto found = kReaders.find(section);
  return found == kReaders.end() ? Names{"nobody knows " + section} : found->second;
}

// A law that the scene has no model of is what [[model]] with its name alone would be.
TEST_F(Stages, FitsAreMadeByTheNamesOfLaws) {
  using estimate::Method;
  const scene::Scene& scene = job->problem.scene;
  const auto model_of = [&](const char* name) {
    return requested_fits(scene, {name}, {}).front().model;
  };
  EXPECT_EQ(model_of("lvm").method, Method::kJoint);
  EXPECT_EQ(model_of("dahl").method, Method::kConventional);
  EXPECT_EQ(model_of("coulomb_viscous").law, "coulomb_viscous");
  EXPECT_EQ(model_of("lvm_paper").method, Method::kEm);
  EXPECT_EQ(model_of("lvm_paper").elements, 32);
  EXPECT_EQ(model_of("lugre").starts, 1);  // of the scene
  scene::Scene without = scene;
  without.models.clear();
  EXPECT_EQ(requested_fits(without, {"simple"}, {}).front().model.law, "coulomb_viscous");
  try {
    model_of("lugree");
    ADD_FAILURE();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("model lugree: found no law and no model"));
  }
}

// Every key of the scene in turn. A fit whose scene changed is no longer counted, so what counts
// fits follows at once.
TEST_F(Stages, RunAgainForTheirSectionsOfTheSceneAndNoOthers) {
  const Declarations before = declarations();
  const scene::Problem problem = job->problem;
  int keys = 0;
  for (;; ++keys) {
    Mutation mutation(keys);
    scene::Scene scene = problem.scene;
    scene.visit(mutation);
    put(with_scene(problem, std::move(scene)));
    if (mutation.key().empty()) break;
    Names expected = readers_of(mutation.key());
    if (expected.contains("identify simple_s1") || expected.contains("identify lugre_s1"))
      expected.insert({"evaluate", "compensate", "contact", "plots", "video", "report"});
    Names found = changed(before, declarations());
    if (mutation.key().starts_with("model")) {
      // under another name or seed it is another fit
      std::erase_if(found, [](const std::string& stage) { return stage.starts_with("identify"); });
      std::erase_if(expected,
                    [](const std::string& stage) { return stage.starts_with("identify"); });
    }
    EXPECT_EQ(found, expected) << "key " << keys << " of " << mutation.key();
  }
  EXPECT_GT(keys, 100);
}

// A fit reads the model of another run.
TEST_F(Stages, FitsRunAgainForTheContentOfTheirPrior) {
  const fs::path file = job->run.folder().path() / "prior.json";
  scene::Scene scene = job->problem.scene;
  scene.models[1].prior = file.string();
  write_file_atomically(file, "one");
  put(with_scene(job->problem, std::move(scene)));
  const Declarations before = declarations();
  write_file_atomically(file, "other");
  const Names found = changed(before, declarations());
  EXPECT_TRUE(found.contains("identify lugre_s1"));
  EXPECT_FALSE(found.contains("identify simple_s1"));
  fs::remove(file);
  EXPECT_TRUE(changed(before, declarations()).contains("identify lugre_s1"));
}

// Files: the content of what a stage wrote is an input of those that read it.
TEST_F(Stages, RunAgainForTheFilesOfOthers) {
  const std::map<std::string, Names> readers{
      {"data/train_0.h5",
       {"identify simple_s1", "identify lugre_s1", "evaluate", "payload", "compensate", "contact",
        "plots", "video", "report"}},
      {"data/loaded_0.h5", {"plots", "video", "report"}},
      {"payload.json", {"plots", "video", "report"}},
      {"data/validation_0.h5", {"evaluate", "plots", "video", "report"}},
      {"truth/train_0.h5", {"evaluate", "plots", "video", "report"}},
      {"truth/validation_0.h5", {"evaluate", "plots", "video", "report"}},
      {"excitation.json", {"evaluate", "plots", "video", "report"}},
      {"models/lugre_s1.json", {"evaluate", "compensate", "contact", "plots", "video", "report"}},
      {"fit/lugre_s1.json", {"evaluate", "plots", "video", "report"}},
      {"evaluation.json", {"plots", "video", "report"}},
      {"table.md", {"plots", "video", "report"}},
      {"rollouts/lugre_s1_validation_0.h5", {"plots", "video", "report"}},
      {"compensation.json", {"plots", "video", "report"}},
      {"compensation.md", {"plots", "video", "report"}},
      {"loops/lugre_path0_controller0.h5", {"plots", "video", "report"}},
      {"contact.json", {"plots", "video", "report"}},
      {"contact.md", {"plots", "video", "report"}},
      {"contact/lugre.h5", {"plots", "video", "report"}},
      {"plots/tracking.svg", {"report"}},
      {"video/comparison.mp4", {"report"}}};
  const Declarations before = declarations();
  const Manifest manifest = job->run.manifest();
  int outputs = 0;
  for (const StageRecord& stage : manifest.stages)
    for (const Content& output : stage.outputs) {
      if (stage.name == "report" || output.name.find("simple") != std::string::npos) continue;
      ++outputs;
      const std::string text = read_file(job->run.folder().path() / output.name);
      write_file_atomically(job->run.folder().path() / output.name, "other");
      job->run.describe([&](Manifest& changed) {
        for (Content& one : changed.at(stage.name).outputs)
          if (one.name == output.name) one.sha256 = sha256_of_text("other");
      });
      ASSERT_TRUE(readers.contains(output.name)) << output.name;
      EXPECT_EQ(changed(before, declarations()), readers.at(output.name)) << output.name;
      write_file_atomically(job->run.folder().path() / output.name, text);
      job->run.describe([&](Manifest& changed) { changed = manifest; });
    }
  EXPECT_EQ(outputs, 20);
}

// A part of a scene holds what was named and nothing else.
TEST_F(Stages, PartsOfASceneHoldNoMore) {
  const scene::Scene& scene = job->problem.scene;
  const scene::Problem part = part_of(job->problem, std::array{Section::kIdentify, Section::kSeed});
  EXPECT_EQ(part.scene.seed, scene.seed);
  EXPECT_EQ(part.scene.identify.cutoff_hz, scene.identify.cutoff_hz);
  EXPECT_TRUE(part.scene.name.empty());
  EXPECT_TRUE(part.scene.models.empty());
  EXPECT_FALSE(part.scene.friction);
  EXPECT_EQ(part.robot.n(), 0);
  EXPECT_TRUE(part.inputs.empty());
}

}  // namespace
}  // namespace fricid::workflow
