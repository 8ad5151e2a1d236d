#include "stage.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::viewer {
namespace {

namespace fs = std::filesystem;

int joint_of(const Stage& stage, const std::string& name) {
  const auto& joints = stage.problem.robot.joints;
  const auto found = std::find_if(joints.begin(), joints.end(),
                                  [&](const auto& joint) { return joint.name == name; });
  if (found == joints.end()) throw UserError("joint {}: unknown", name);
  return static_cast<int>(found - joints.begin());
}

/// Index in theta of a parameter of the selected joint.
int parameter_of(const Stage& stage, const std::string& symbol) {
  const friction::RobotFriction& model = stage.live->friction().model;
  if (const int i = friction::find_parameter(model, stage.joint, "", symbol); i >= 0) return i;
  std::string known;
  for (const friction::ParameterRef& parameter : model.parameters())
    if (parameter.joint == stage.joint) known += (known.empty() ? "" : ", ") + parameter.symbol;
  throw UserError("parameter {}: allowed: {}", symbol, known);
}

void require_live(const Stage& stage) {
  if (!stage.live) throw UserError("the target has no friction to simulate");
}

}  // namespace

void Stage::advance(double seconds) {
  if (!playing) return;
  if (mode == Mode::kLive) return live->advance(speed * seconds);
  const double end = film->t[film->t.size() - 1];
  t = t + speed * seconds;
  if (t > end) t = 0;
}

void Stage::seek(double seconds) {
  if (mode == Mode::kReplay) {
    t = std::clamp(seconds, 0.0, film->t[film->t.size() - 1]);
    return;
  }
  live->reset();
  while (live->time() < seconds) live->step();
}

void Stage::reset() {
  if (mode == Mode::kReplay)
    t = 0;
  else
    live->reset();
}

void Stage::replay_joint(std::size_t model) {
  if (replayed_ && replayed_->model == model && replayed_->joint == joint) return;
  const film::FilmModel& shown = film->models[model];
  Replayed replayed{
      model, joint, friction_of_joint(data::load_model(shown.file).arm.friction, joint), {}};
  JointMotion& motion = replayed.motion;
  const Eigen::Index rows = film->t.size();
  motion.dt = (film->t[rows - 1] - film->t[0]) / static_cast<double>(rows - 1);
  motion.q = shown.q.col(joint);
  motion.v = shown.v.col(joint);
  motion.load = film->tau.col(joint);
  if (film->temperature.size() > 0) motion.temperature = film->temperature.col(joint);
  motion.z = drive_friction(replayed.friction, motion.dt, motion.q, motion.v, motion.load,
                            motion.temperature)
                 .z;
  replayed_ = std::move(replayed);
}

std::optional<ShownCloud> Stage::cloud() {
  if (mode == Mode::kReplay) {
    for (std::size_t m = 0; m < film->models.size(); ++m) {
      if (!visible[m] || !workflow::is_there(film->models[m].file)) continue;
      replay_joint(m);
      if (replayed_->motion.z.cols() == 0) continue;
      return ShownCloud{
          film->models[m].label, film->models[m].colour, std::min(cloud_age, t),
          latent_cloud(replayed_->friction, replayed_->motion, row(), cloud_age, kCopies)};
    }
    return {};
  }

  const friction::Friction& all = live->friction();
  const int first = all.model.state_begin(joint), end = all.model.state_begin(joint + 1);
  const auto rows = static_cast<Eigen::Index>(live->history().size());
  if (rows == 0 || first == end) return {};
  JointMotion motion{1 / problem.scene.sensors.rate_hz,
                     RowMatrix(rows, 1),
                     RowMatrix(rows, 1),
                     RowMatrix(rows, 1),
                     {},
                     RowMatrix(rows, end - first)};
  const auto j = static_cast<std::size_t>(joint);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const Moment& moment = live->history()[static_cast<std::size_t>(k)];
    motion.q(k, 0) = moment.q[j];
    motion.v(k, 0) = moment.v[j];
    motion.load(k, 0) = moment.tau[j];
    motion.z.row(k) = Eigen::RowVectorXd::Map(moment.z.data() + first, end - first);
  }
  return ShownCloud{"live friction", kLiveColour,
                    std::min(cloud_age, static_cast<double>(rows - 1) * motion.dt),
                    latent_cloud(friction_of_joint(all, joint), motion, static_cast<int>(rows) - 1,
                                 cloud_age, kCopies)};
}

Stage make_stage(const fs::path& target) {
  const workflow::RunFolder run(target), around(target.parent_path().parent_path());
  const bool is_run = workflow::is_there(run.manifest());
  const bool is_model = target.extension() == ".json";
  Stage stage(scene::load_problem(is_run ? run.scene() : is_model ? around.scene() : target));
  stage.arm.emplace(sim::make_arm(stage.problem));

  if (is_run && workflow::is_there(run.evaluation())) {
    stage.film = film::read_film(run, stage.problem);
    stage.visible.assign(stage.film->models.size(), true);
    stage.joint = film::most_telling_joint(*stage.film);
    stage.mode = Mode::kReplay;
  }
  std::optional<friction::Friction> friction = stage.problem.scene.friction;
  if (is_model) friction = data::load_model(target).arm.friction;
  if (friction) stage.live = std::make_unique<LiveArm>(*stage.arm, stage.problem, *friction);
  if (stage.live) stage.live->swings = true;
  if (!stage.live && !stage.film) throw UserError("{}: found nothing to show", target.string());
  return stage;
}

void save_scene(const Stage& stage, const fs::path& path) {
  require_live(stage);
  scene::Scene changed = stage.problem.scene;
  changed.friction = stage.live->friction();
  write_file_atomically(path, scene::to_toml(changed));
}

Asked obey(Stage& stage, const std::string& command) {
  std::istringstream words(command);
  std::string verb, name;
  double value = 0;
  words >> verb;
  const auto number = [&] {
    if (!(words >> value)) throw UserError("{}: a number is missing", command);
    return value;
  };
  const auto word = [&] {
    if (!(words >> name)) throw UserError("{}: a name is missing", command);
    return name;
  };

  if (verb.empty() || verb.front() == '#') return {};
  if (verb == "shot") return {.shot = word()};
  if (verb == "fps") return {.race = number()};
  if (verb == "scene") {
    save_scene(stage, word());
  } else if (verb == "seek") {
    stage.seek(number());
  } else if (verb == "play" || verb == "pause") {
    stage.playing = verb == "play";
  } else if (verb == "speed") {
    stage.speed = number();
  } else if (verb == "age") {
    stage.cloud_age = std::clamp(number(), 0.0, Stage::kOldestCloud);
  } else if (verb == "toggle") {
    word();
    std::size_t m = 0;
    const std::size_t count = stage.film ? stage.film->models.size() : 0;
    while (m < count && stage.film->models[m].name != name) ++m;
    if (m == count) throw UserError("{}: no such model is shown", command);
    stage.visible[m] = !stage.visible[m];
  } else if (verb == "joint") {
    stage.joint = joint_of(stage, word());
  } else if (verb == "live") {
    require_live(stage);
    stage.mode = Mode::kLive;
  } else if (verb == "replay") {
    if (!stage.film) throw UserError("{}: the target is no run folder", command);
    stage.mode = Mode::kReplay;
  } else if (verb == "reset") {
    stage.reset();
  } else if (verb == "set") {
    require_live(stage);
    const int parameter = parameter_of(stage, word());
    stage.live->set_parameter(parameter, number());
  } else if (verb == "push") {
    require_live(stage);
    stage.live->push = {stage.joint, number(), 0, 1};
    stage.live->swings = false;
    if (words >> stage.live->push.amplitude) stage.live->push.frequency_hz = number();
  } else if (verb == "swing") {
    require_live(stage);
    stage.live->swings = true;
  } else if (verb == "run") {
    constexpr double kPart = LiveArm::kMostPerCall / 2;
    const bool was_playing = std::exchange(stage.playing, true);
    for (double left = number(); left > 0; left -= kPart)
      stage.advance(std::min(left, kPart) / stage.speed);
    stage.playing = was_playing;
  } else {
    throw UserError("{}: unknown command", command);
  }
  return {};
}

}  // namespace fricid::viewer
