#include "run.hpp"

#include <algorithm>

#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::render {
namespace {

namespace fs = std::filesystem;
using workflow::if_there;

/// Signals of a file along the trajectory; at most as many samples as its recording.
template <class Signals>
std::optional<Signals> along(const Run& run, const fs::path& file,
                             Signals (*load)(const fs::path&, int)) {
  std::optional<Signals> signals =
      if_there(file, [&](const fs::path& path) { return load(path, run.n()); });
  if (signals && signals->t.size() > run.measured.length())
    throw UserError("{}: found {} samples; allowed: {}, as {} has", file.string(),
                    signals->t.size(), run.measured.length(), run.trajectory);
  return signals;
}

/// Requires that a file has as many joints as the recording.
void require_joints(const Run& run, const fs::path& file, std::ptrdiff_t found) {
  if (found != run.n())
    throw UserError("{}: found {} joints; allowed: {}, as {} has", file.string(), found, run.n(),
                    run.trajectory);
}

/// Which joints slide, by the robot of the first model that is there; none without a model.
std::vector<bool> sliding_joints(const Run& run) {
  std::vector<bool> slides(static_cast<std::size_t>(run.n()));
  for (const RunModel& model : run.models)
    if (const auto file = run.model_file(model)) {
      const auto& joints = file->arm.robot.joints;
      std::transform(joints.begin(), joints.end(), slides.begin(), dynamics::slides);
      break;
    }
  return slides;
}

}  // namespace

Units Run::units(int j) const {
  if (slides[static_cast<std::size_t>(j)]) return {"m", "mm", "m/s", "N", "N²"};
  return {};
}

std::string Run::heading(int j) const {
  return slides[static_cast<std::size_t>(j)] ? joint(j) + " (m, N)" : joint(j);
}

std::vector<RunModel> Run::fitted() const {
  std::vector<RunModel> fitted;
  for (const RunModel& model : models)
    if (!model.is_oracle) fitted.push_back(model);
  return fitted;
}

const RunModel* Run::model(const std::string& name) const {
  const auto found = std::ranges::find(models, name, &RunModel::name);
  return found == models.end() ? nullptr : &*found;
}

const evaluate::Summary* Run::summary(const std::string& model) const {
  const auto found = std::ranges::find(evaluation.summary, model, &evaluate::Summary::name);
  return found == evaluation.summary.end() ? nullptr : &*found;
}

std::optional<evaluate::RolloutSignals> Run::rollout(const RunModel& model) const {
  return along(*this, folder.rollout(model.first_fit(), trajectory), evaluate::load_rollout);
}
std::optional<evaluate::PredictionSignals> Run::prediction(const RunModel& model) const {
  return along(*this, folder.prediction(model.first_fit(), trajectory), evaluate::load_prediction);
}
std::optional<data::EstimateSignals> Run::estimate(const RunModel& model) const {
  return along(*this, folder.estimate(model.first_fit(), trajectory),
               data::load_signals<data::EstimateSignals>);
}
std::optional<evaluate::BandSignals> Run::band(const RunModel& model) const {
  return along(*this, folder.band(model.name, trajectory), evaluate::load_band);
}
std::optional<data::ModelFile> Run::model_file(const RunModel& model) const {
  return model_file(model.first_fit());
}
std::optional<data::FitFile> Run::fit(const RunModel& model) const {
  return fit(model.first_fit());
}

std::optional<data::ModelFile> Run::model_file(const workflow::FitId& id) const {
  std::optional<data::ModelFile> file = if_there(folder.model(id), data::load_model);
  if (file) require_joints(*this, folder.model(id), file->arm.robot.n());
  return file;
}
std::optional<data::FitFile> Run::fit(const workflow::FitId& id) const {
  std::optional<data::FitFile> fit = if_there(folder.fit(id), data::load<data::FitFile>);
  if (fit && !fit->joints.empty()) require_joints(*this, folder.fit(id), std::ssize(fit->joints));
  return fit;
}

Run read_run(const workflow::RunFolder& folder) {
  Run run{folder, data::load<evaluate::Evaluation>(folder.evaluation()), {}, {}, {}, {}, {}, {}, {},
          {}};
  run.models = models_of_run(run.evaluation, folder);
  run.trajectory = run.evaluation.trajectories.front();
  run.measured = data::load_dataset(folder.recording(run.trajectory));
  run.truth = if_there(folder.truth(run.trajectory), sim::load_truth);
  if (run.truth)
    require_joints(run, folder.truth(run.trajectory), std::ssize(run.truth->joint_names));
  run.payload = if_there(folder.payload(), data::load<data::PayloadFile>);
  run.compensation = if_there(folder.compensation(), data::load<evaluate::CompensationFile>);
  run.contact = if_there(folder.contact(), data::load<evaluate::ContactFile>);
  run.slides = sliding_joints(run);
  return run;
}

Look look_of_loop(const Run& run, const std::string& model) {
  if (model == evaluate::kTruthModel) return look_of_law("oracle");
  const RunModel* found = run.model(model);
  return found == nullptr ? Look{.colour = kTruthColour} : found->look;
}

std::vector<double> to_vector(const Eigen::Ref<const Eigen::VectorXd>& x) {
  return {x.data(), x.data() + x.size()};
}

Series curve(const RunModel& model, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y) {
  Series series = curve(model.label, model.look.colour, x, y);
  series.dash = model.look.dash;
  return series;
}

Series curve(const std::string& label, const std::string& colour, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y, double width) {
  return {.label = label, .colour = colour, .x = to_vector(x), .y = to_vector(y), .width = width};
}

}  // namespace fricid::render
