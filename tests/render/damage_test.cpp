// Files of a run that were damaged: refused in one line that names the file and what is wrong.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "fricid/base/error.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/render/figures.hpp"
#include "fricid/render/report.hpp"
#include "fricid/sim/excitation_file.hpp"
#include "run_folder_fixture.hpp"

namespace fricid::render {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Damage : public RunToDraw {
 protected:
  void SetUp() override {
    RunToDraw::SetUp();
    edit_fit([](data::FitFile& fit) {
      fit.rigid_body.rows = fit.rigid_body.rows_total = {10, 10};
      fit.multi_step.emplace().checked = {0, 1};
      fit.multi_step->held_out = {2, 1};
      fit.joints[0].parameters = {{"Fc"}, {"Fs"}};
      fit.joints[0].correlation = Eigen::MatrixXd::Identity(2, 2);
    });
    sim::ExcitationFile excitation;
    excitation.trajectories.emplace_back().joints.emplace_back();
    data::save(excitation, run.excitation());
    ASSERT_EQ(said(), "no error");
  }

  std::string said() const {
    try {
      report_of_run(run, scene::Scene(), workflow::Manifest());
      figures_of_run(run);
    } catch (const UserError& error) {
      return error.what();
    }
    return "no error";
  }

  /// What is said of an artefact while it is changed.
  std::string said_of(const fs::path& file, const std::function<void(json&)>& change) const {
    const std::string whole = read_file(file);
    json root = json::parse(whole);
    change(root);
    write_file_atomically(file, root.dump());
    std::string message = "no error";
    try {
      read(file);
    } catch (const UserError& error) {
      message = error.what();
    }
    write_file_atomically(file, whole);
    return message;
  }
  void read(const fs::path& file) const {
    if (file == run.evaluation())
      data::load<evaluate::Evaluation>(file);
    else if (file == run.fit(simple))
      data::load<data::FitFile>(file);
    else if (file == run.excitation())
      data::load<sim::ExcitationFile>(file);
    else
      data::load_model(file);
  }

  static void expect_said(const std::string& message, const fs::path& file,
                          const std::string& what) {
    EXPECT_THAT(message,
                AllOf(HasSubstr(file.filename().string()), HasSubstr(what), Not(HasSubstr("\n"))));
  }
  void expect_refused(const fs::path& file, const std::string& pointer, const json& value,
                      const std::string& what) const {
    expect_said(said_of(file, [&](json& root) { root[json::json_pointer(pointer)] = value; }), file,
                what);
  }
  void expect_missing(const fs::path& file, const std::string& object,
                      const std::string& key) const {
    expect_said(said_of(file, [&](json& root) { root[json::json_pointer(object)].erase(key); }),
                file, "found no ");
  }
};

TEST_F(Damage, OfTheEvaluation) {
  const fs::path file = run.evaluation();
  expect_refused(file, "/format", "fricid.evaluation/1", "allowed: \"format\"");
  expect_refused(file, "/summary/2/rollouts", "four", "summary[2].rollouts: found \"four\"");
  expect_refused(file, "/models", "none", "models: found \"none\"");
  expect_missing(file, "", "floor");
  expect_missing(file, "/models/2", "label");
  for (const char* list : {"oracle", "halving", "repeat", "floor", "integration",
                           "best_conventional", "headroom", "meaningless"})
    expect_refused(file, std::string("/") + list, json::array(),
                   std::string(list) + " has 0 entries; allowed: 2");
  for (const char* list :
       {"q_mse_geometric_mean", "q_mse_mean", "q_mse_median", "v_mse_geometric_mean",
        "ratio_to_oracle", "headroom_closed", "ensemble_q_mse", "ensemble_coverage",
        "band_coverage", "band_half_width"})
    expect_refused(file, std::string("/summary/2/") + list, {1}, std::string(list) + " has 1");
  expect_refused(file, "/summary/2/interval_90", {{1, 2}}, "interval_90 has 1 entries");
  const std::string score = "/models/2/trajectories/0/";
  for (const char* list : {"q_mse", "q_mae", "v_mse", "v_mae"}) {
    expect_refused(file, score + list, {1}, std::string(list) + " has 1 entries; allowed: 2");
    expect_refused(file, score + list + "_joint", {{1, 2}},
                   std::string(list) + "_joint has 1 entries; allowed: 2");
    expect_refused(file, score + list + "_joint/1", {1, 2, 3},
                   std::string(list) + "_joint has 3 entries; allowed: 2");
  }
  expect_refused(file, score + "trajectory", 1, "trajectory = 1; allowed: 0 to 0");
  expect_refused(file, score + "friction_rmse_sliding", {1}, "friction_rmse sliding has 1");
  expect_refused(file, "/repeats", json::array(), "repeats has 0 entries; allowed: 1");
  expect_refused(file, "/repeats/0/tau_sd", {1, 2, 3}, "q_mse_joint has 2 entries; allowed: 3");
  expect_refused(file, "/trajectories", json::array(), "trajectories is empty");
  expect_refused(file, "/trajectories/0", "../secret", "../secret");
  expect_refused(file, "/models/2/name", "../secret", "../secret");
}

TEST_F(Damage, OfAFit) {
  const fs::path file = run.fit(simple);
  expect_refused(file, "/format", "fricid.fit/1", "allowed: \"format\"");
  expect_refused(file, "/usable", "yes", "usable: found \"yes\"; allowed: true or false");
  expect_refused(file, "/outcome", "good", "allowed: converged, iteration limit");
  expect_missing(file, "", "objective");
  expect_missing(file, "/joints/1", "r2");
  expect_refused(file, "/rigid_body/rows_used", {10}, "rows_used has 1 entries; allowed: 2");
  expect_refused(file, "/rigid_body/coulomb_Nm", {1, 2, 3}, "coulomb_Nm has 3 entries");
  expect_refused(file, "/joints/0/correlation", {{1}}, "correlation of joint_a1 is 1 x 1");
  expect_refused(file, "/multi_step/held_out", {2}, "multi_step.held_out has 1 entries");
  expect_refused(file, "/multi_step/chosen", 2, "multi_step.chosen = 2");
  expect_refused(file, "/multi_step/chosen", -1, "multi_step.chosen = -1");
}

// Each kind of file is read where the run is drawn.
TEST_F(Damage, IsFoundWhereTheRunIsDrawn) {
  for (const fs::path& file :
       {run.evaluation(), run.fit(simple), run.excitation(), run.model(simple)}) {
    const std::string whole = read_file(file);
    write_file_atomically(file, "{\"format\": \"another\"}");
    expect_said(said(), file, "format");
    write_file_atomically(file, whole);
  }
  edit_fit([](data::FitFile& fit) {  // adds two joints to two
    fit.rigid_body = {};
  });
  expect_said(said(), run.fit(simple), "found 4 joints; allowed: 2");
}

TEST_F(Damage, OfTheExcitation) {
  const fs::path file = run.excitation();
  expect_refused(file, "/format", nullptr, "found null; allowed: \"format\"");
  expect_refused(file, "/trajectories/0/feasible", 1, "trajectories[0].feasible: found 1");
  expect_missing(file, "/trajectories/0/margins/0", "velocity");
}

TEST_F(Damage, OfAModel) {
  const fs::path file = run.model(simple);
  expect_refused(file, "/format", "fricid.fit/2", "format");
  expect_refused(file, "/friction", 3, "friction");
  expect_refused(file, "/robot", nullptr, "robot");
}

TEST_F(Damage, OfSignals) {
  const auto write = [&](const fs::path& file, const char* format,
                         const std::vector<std::pair<const char*, data::RowMatrix>>& tables) {
    data::write_hdf5(file, format, [&](data::H5Writer& out) {
      out.vector("t", Eigen::VectorXd::LinSpaced(kRows, 0, 1), "s");
      for (const auto& [name, values] : tables) out.matrix(name, values, "");
    });
  };
  const fs::path rollout = run.rollout(simple, kTrajectory);
  const std::string whole = read_file(rollout);
  write(rollout, "fricid.rollout/1", {{"q", ramp(0)}, {"v", ramp(0).topRows(7)}});
  expect_said(said(), rollout, "table v has 7 rows; allowed: 4000");
  write(rollout, "fricid.rollout/1", {{"q", ramp(0)}, {"v", ramp(0).leftCols(1)}});
  expect_said(said(), rollout, "/v has 1 columns; allowed: 2");
  write(rollout, "fricid.rollout/1", {{"q", ramp(0)}});
  expect_said(said(), rollout, "/v is missing");
  write(rollout, "fricid.rollout/2", {{"q", ramp(0)}, {"v", ramp(0)}});
  expect_said(said(), rollout, "fricid.rollout/2");
  write_file_atomically(rollout, whole);
  ASSERT_EQ(said(), "no error");

  const fs::path prediction = run.prediction(simple, kTrajectory);
  write(prediction, "fricid.prediction/1", {{"q", ramp(0)}, {"v", ramp(0)}});
  expect_said(said(), prediction, "/tau is missing");
  fs::remove(prediction);

  const fs::path truth = run.truth(kTrajectory);
  data::write_hdf5(truth, "fricid.truth/1", [&](data::H5Writer& out) {
    out.attribute("joint_names", trajectory.data.joint_names);
    out.attribute("rate_hz", 250.0);
    out.attribute("friction", std::string("{\"joints\": []}"));
    out.vector("t", Eigen::VectorXd::LinSpaced(kRows, 0, 1), "s");
    out.matrix("q", ramp(0).topRows(kRows - 1), "rad");
  });
  expect_said(said(), truth, "table q has 3999 rows; allowed: 4000");
}

}  // namespace
}  // namespace fricid::render
