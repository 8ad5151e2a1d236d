#include "fricid/data/model_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/friction_keys.hpp"
#include "fricid/data/written_model.hpp"
#include "fricid/dynamics/physical_inertia.hpp"

namespace fricid::data {
namespace {

using dynamics::RobotModel;
using friction::Friction;
using friction::ParameterInfo;

// ---- writing

WrittenRobot written(const RobotModel& robot) {
  WrittenRobot file{.name = robot.name, .gravity = robot.gravity};
  for (int i = 0; i < robot.n(); ++i) {
    const auto pi = robot.pi.segment<10>(10 * i);
    file.joints.push_back(
        {.joint = robot.joints[static_cast<std::size_t>(i)],
         .armature = robot.pi[robot.armature_begin() + i],
         .moves = {pi[0], pi.segment<3>(1), {pi[4], pi[5], pi[6], pi[7], pi[8], pi[9]}}});
  }
  for (const dynamics::Frame& frame : robot.frames) file.frames.push_back({frame});
  for (std::size_t i = 0; i < robot.linear_torques.size(); ++i)
    file.linear_torques.push_back(
        {robot.linear_torques[i], robot.pi[robot.linear_begin() + static_cast<Eigen::Index>(i)]});
  for (const dynamics::Coupling& coupling : robot.couplings) {
    if (!file.couplings) file.couplings.emplace();
    file.couplings->push_back({coupling});
  }
  return file;
}

/// The next parameters of theta under their symbols.
WrittenParameters written(const std::vector<ParameterInfo>& infos, bool slides,
                          const double*& theta) {
  WrittenParameters parameters;
  for (const ParameterInfo& info : infos)
    parameters.emplace_back(info.symbol,
                            WrittenParameter{*theta++, unit_of_joint(info.unit, slides)});
  return parameters;
}

/// One list of laws per joint; a robot without friction has empty ones.
void write_friction(const Friction& friction, const RobotModel& robot, WrittenModel& file) {
  const int n = robot.n();
  const double* theta = friction.theta.data();
  file.friction.resize(static_cast<std::size_t>(n));
  const std::vector<friction::JointSpec>& joints = friction.model.joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const bool slides = dynamics::slides(robot.joints[j]);
    for (const friction::LawSpec& law : joints[j].laws) {
      WrittenLaw& own = file.friction[j].emplace_back();
      own.law = law.law;
      own.elements = law.elements;
      own.parameters = written(friction::parameters_of_law(law.law, law.elements), slides, theta);
      for (const friction::ModifierSpec& modifier : law.modifiers)
        own.modifiers.push_back(
            {modifier.name, modifier.order,
             written(friction::parameters_of_modifier(modifier.name, modifier.order), slides,
                     theta)});
    }
  }
  if (!friction.model.has_whole()) return;
  const friction::RobotLawSpec& whole = friction.model.whole();
  WrittenRobotLaw& own = file.friction_of_robot.emplace();
  own.law = whole.law;
  own.elements = whole.elements;
  own.parameters =
      written(friction::parameters_of_robot_law(whole.law, {n, whole.elements, whole.latents}),
              false, theta);
  if (friction::find_robot_law(whole.law).most_latents > 0) own.latents = whole.latents;
}

// ---- reading

/// Where something stands in a file, for messages.
struct Place {
  std::string file, path;

  Place operator/(std::string_view key) const {
    return {file, path.empty() ? std::string(key) : fmt::format("{}.{}", path, key)};
  }
  Place at(std::size_t i) const { return {file, fmt::format("{}[{}]", path, i)}; }

  template <class Found>
  [[noreturn]] void refuse(const Found& found, std::string_view allowed) const {
    throw UserError("{}: {}: found {}; allowed: {}", file, path, found, allowed);
  }
  [[noreturn]] void refuse_text(const std::string& found, std::string_view allowed) const {
    refuse(fmt::format("\"{}\"", printable(found)), allowed);
  }
  void require_within(const Limit& limit, std::size_t found) const {
    fricid::require_within(limit, found, fmt::format("{}: {}", file, path));
  }
  /// What `make` gives; its UserError is told as one of this place.
  template <class Make>
  auto checked(Make make) const {
    try {
      return make();
    } catch (const UserError& error) {
      throw UserError("{}: {}: {}", file, path, error.what());
    }
  }
  void require_range(int found, int lower, int upper) const {
    if (found < lower || found > upper) refuse(found, fmt::format("{} to {}", lower, upper));
  }
  void require_name(Named kind, const std::string& name) const {
    require_written_name(kind, name, fmt::format("{}: {}", file, path));
  }
  /// Rotations carry full precision: those written by hand or rounded are refused.
  void require_rotation(const Eigen::Matrix3d& R) const {
    if ((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-9 ||
        R.determinant() < 0)
      refuse("another matrix", "a rotation");
  }
};

constexpr double kRounding = 1e-3;  // what a URDF may miss of a physical inertia, per unit of mass

void check_joint(const WrittenJoint& item, int i, const Place& place) {
  const dynamics::Joint& joint = item.joint;
  (place / "name").require_name(Named::kJoint, joint.name);
  (place / "link").require_name(Named::kLink, joint.link);
  (place / "parent").require_range(joint.parent, -1, i - 1);
  (place / "R0").require_rotation(joint.R0);
  if (std::abs(joint.axis.norm() - 1) > 1e-9)
    (place / "axis").refuse(fmt::format("length {}", joint.axis.norm()), "a unit vector");
}

RobotModel read_robot(const WrittenRobot& file, const Place& place) {
  RobotModel robot;
  (place / "name").require_name(Named::kRobot, file.name);
  robot.name = file.name;
  robot.gravity = file.gravity;
  const int n = static_cast<int>(file.joints.size());
  if (n < 1) (place / "joints").refuse(n, "at least one joint");
  (place / "joints").require_within(limits::kJoints, file.joints.size());
  robot.pi.setZero(11 * n + static_cast<int>(file.linear_torques.size()));
  for (int i = 0; i < n; ++i) {
    const WrittenJoint& item = file.joints[static_cast<std::size_t>(i)];
    const Place own = (place / "joints").at(static_cast<std::size_t>(i));
    check_joint(item, i, own);
    robot.joints.push_back(item.joint);
    if (dynamics::Joint& joint = robot.joints.back(); joint.continuous) {
      joint.upper = std::numeric_limits<double>::infinity();
      joint.lower = -joint.upper;
    } else if (!(joint.lower <= joint.upper)) {
      (own / "lower").refuse(joint.lower, fmt::format("up to upper = {}", joint.upper));
    }
    const auto& [mass, first_moment, inertia] = item.moves;
    robot.pi.segment<10>(10 * i) << mass, first_moment, inertia.Ixx, inertia.Ixy, inertia.Iyy,
        inertia.Ixz, inertia.Iyz, inertia.Izz;
    robot.pi[10 * n + i] = item.armature;
    if (!(mass > 0)) (own / "moves" / "mass").refuse(mass, "above 0");
    if (!dynamics::is_physical(robot.pi.segment<10>(10 * i), -kRounding))
      (own / "moves" / "inertia")
          .refuse(fmt::format("{}", fmt::join(robot.pi.segment<6>(10 * i + 4), " ")),
                  "that of a body of this mass and first moment");
  }
  for (std::size_t i = 0; i < file.frames.size(); ++i) {
    const dynamics::Frame& frame = file.frames[i].frame;
    const Place own = (place / "frames").at(i);
    (own / "name").require_name(Named::kLink, frame.name);
    (own / "link").require_range(frame.link, -1, n - 1);
    (own / "R").require_rotation(frame.R);
    robot.frames.push_back(frame);
  }
  for (std::size_t i = 0; i < file.linear_torques.size(); ++i) {
    const auto& [torque, c] = file.linear_torques[i];
    const Place own = (place / "linear_torques").at(i);
    require_label(torque.name, (own / "name").path, own.file);
    (own / "joint").require_range(torque.joint, 0, n - 1);
    robot.linear_torques.push_back(torque);
    robot.pi[11 * n + static_cast<int>(i)] = c;
  }
  if (!file.couplings) return robot;
  for (std::size_t i = 0; i < file.couplings->size(); ++i) {
    const dynamics::Coupling& coupling = (*file.couplings)[i].coupling;
    const Place own = (place / "couplings").at(i);
    (own / "joint").require_range(coupling.joint, 0, n - 1);
    (own / "motor").require_range(coupling.motor, 0, n - 1);
    if (coupling.joint == coupling.motor) (own / "motor").refuse(coupling.motor, "another joint");
    robot.couplings.push_back(coupling);
  }
  if (!dynamics::is_transmission(robot))
    (place / "couplings")
        .refuse(fmt::format("{}", file.couplings->size()), "motors that turn every joint");
  return robot;
}

/// @param slides  whether the units are those of a sliding joint; those of one that turns are read
/// there too
void read_parameters(const WrittenParameters& file, const std::vector<ParameterInfo>& infos,
                     bool slides, const Place& place, std::vector<double>& theta) {
  for (std::size_t i = 0; i < infos.size(); ++i) {
    const ParameterInfo& info = infos[i];
    const Place own = place / info.symbol;
    // they stand in the order of the table, unless someone edited the file
    const auto is_own = [&](const auto& entry) { return entry.first == info.symbol; };
    const auto found = i < file.size() && is_own(file[i])
                           ? file.begin() + static_cast<std::ptrdiff_t>(i)
                           : std::ranges::find_if(file, is_own);
    if (found == file.end()) throw UserError("{}: found no {}", own.file, own.path);
    const auto& [value, unit] = found->second;
    if (const std::string allowed = unit_of_joint(info.unit, slides);
        unit != allowed && unit != info.unit)
      (own / "unit").refuse_text(unit, allowed);
    if (!(value >= info.lower && value <= info.upper))
      (own / "value").refuse(value, fmt::format("{:g} to {:g}", info.lower, info.upper));
    theta.push_back(value);
  }
  if (file.size() != infos.size())
    place.refuse(fmt::format("{} parameters", file.size()),
                 fmt::format("the {} parameters of the law", infos.size()));
}

const friction::LawInfo& row_of(const std::string& name, std::span<const friction::LawInfo> rows,
                                const Place& place) {
  const friction::LawInfo* row = find_row(rows, name);
  if (row == nullptr) place.refuse_text(name, list_names(rows));
  return *row;
}

/// Number of elements or terms: of rows that have none, `none`.
void require_count(int count, const friction::LawInfo& row, int none, const Place& place) {
  if (row.has_elements)
    place.require_range(count, 1, row.most_elements);
  else
    place.require_range(count, none, none);
}

friction::LawSpec read_law(const WrittenLaw& file, bool slides, const Place& place,
                           std::vector<double>& theta) {
  const friction::LawInfo& row = row_of(file.law, friction::law_table(), place / "law");
  require_count(file.elements, row, 0, place / "elements");
  friction::LawSpec law{.law = file.law, .elements = file.elements, .modifiers = {}};
  read_parameters(file.parameters, friction::parameters_of_law(law.law, law.elements), slides,
                  place / "parameters", theta);
  for (std::size_t m = 0; m < file.modifiers.size(); ++m) {
    const auto& [name, order, parameters] = file.modifiers[m];
    const Place own = (place / "modifiers").at(m);
    require_count(order, row_of(name, friction::modifier_table(), own / "modifier"), 1,
                  own / "order");
    read_parameters(parameters, friction::parameters_of_modifier(name, order), slides,
                    own / "parameters", theta);
    law.modifiers.push_back({.name = name, .order = order});
  }
  return law;
}

friction::RobotLawSpec read_robot_law(const WrittenRobotLaw& file, int n, const Place& place,
                                      std::vector<double>& theta) {
  const friction::LawInfo& row = row_of(file.law, friction::robot_law_table(), place / "law");
  require_count(file.elements, row, 0, place / "elements");
  friction::RobotLawSpec whole{.law = file.law, .elements = file.elements};
  if (row.most_latents > 0) {
    if (!file.latents) throw UserError("{}: found no {}", place.file, (place / "n_z").path);
    (place / "n_z").require_range(*file.latents, 1, row.most_latents);
    whole.latents = *file.latents;
  }
  const friction::RobotLawSize size{n, whole.elements, whole.latents};
  read_parameters(file.parameters,
                  place.checked([&] { return friction::parameters_of_robot_law(whole.law, size); }),
                  false, place / "parameters", theta);
  return whole;
}

Friction read_friction(const WrittenModel& file, const RobotModel& robot, const Place& root) {
  const int n = robot.n();
  const Place place = root / "friction";
  if (std::ssize(file.friction) != n)
    place.refuse(fmt::format("{} lists", file.friction.size()),
                 fmt::format("one list of laws for each of {} joints", n));
  std::vector<friction::JointSpec> joints(file.friction.size());
  std::vector<double> theta;
  for (std::size_t j = 0; j < joints.size(); ++j)
    for (std::size_t i = 0; i < file.friction[j].size(); ++i)
      joints[j].laws.push_back(read_law(file.friction[j][i], dynamics::slides(robot.joints[j]),
                                        place.at(j).at(i), theta));
  friction::RobotLawSpec whole;
  if (file.friction_of_robot)
    whole = read_robot_law(*file.friction_of_robot, n, root / "friction_of_robot", theta);
  return {.model = place.checked(
              [&] { return friction::RobotFriction(std::move(joints), std::move(whole)); }),
          .theta = std::move(theta)};
}

LatentNoise read_noise(const WrittenNoise& file, int n, int nz, const Place& place) {
  const auto require_size = [&](const char* key, const Eigen::VectorXd& values,
                                std::initializer_list<int> sizes) {
    if (std::ranges::find(sizes, values.size()) == sizes.end())
      (place / key).refuse(values.size(), fmt::format("{} numbers", fmt::join(sizes, " or ")));
  };
  require_size("variance_q", file.variance_q, {n});
  require_size("variance_v", file.variance_v, {n});
  require_size("variance_z", file.variance_z, {nz});
  require_size("variance_observation", file.variance_observation, {n, 2 * n});
  if (file.variance_friction) require_size("variance_friction", *file.variance_friction, {n});
  return {.dt = file.sample_s,
          .q = file.variance_q,
          .v = file.variance_v,
          .z = file.variance_z,
          .R = file.variance_observation,
          .friction = file.variance_friction.value_or(Eigen::VectorXd())};
}

}  // namespace

namespace {

WrittenModel written(const ModelFile& model) {
  WrittenModel file{.name = model.name,
                    .label = model.label,
                    .seed = model.seed,
                    .is_oracle = model.is_oracle,
                    .free_parameters = model.free_parameters,
                    .budget = model.budget,
                    .doubts = model.doubts.empty() ? std::nullopt : std::optional(model.doubts),
                    .robot = written(model.arm.robot)};
  write_friction(model.arm.friction, model.arm.robot, file);
  if (const auto& noise = model.noise)
    file.noise = {
        noise->dt, noise->q,
        noise->v,  noise->z,
        noise->R,  noise->friction.size() ? std::optional(noise->friction) : std::nullopt};
  return file;
}

}  // namespace

void save_model(const ModelFile& model, const std::filesystem::path& path) {
  save(written(model), path);
}

std::string model_text(const ModelFile& model) { return to_json(written(model)); }

ModelFile load_model(const std::filesystem::path& path) {
  return parse_model(read_file(path), path.string());
}

ModelFile parse_model(std::string_view text, const std::string& where) {
  const auto file = parse<WrittenModel>(text, where);
  const Place root{where, ""};
  (root / "name").require_name(Named::kModel, file.name);
  if (!file.is_oracle) require_name(Named::kModel, file.name, root.file);
  require_label(file.label, "label", root.file);
  if (file.budget) require_label(*file.budget, "budget", root.file);
  ModelFile model{.name = file.name,
                  .label = file.label,
                  .seed = file.seed,
                  .arm = {},
                  .free_parameters = file.free_parameters,
                  .budget = file.budget.value_or(""),
                  .is_oracle = file.is_oracle,
                  .doubts = {}};
  for (const std::string& doubt : file.doubts.value_or(std::vector<std::string>()))
    model.doubts.push_back(printable(doubt));
  model.arm.robot = read_robot(file.robot, root / "robot");
  const int n = model.arm.robot.n();
  model.arm.friction = read_friction(file, model.arm.robot, root);
  if (file.noise)
    model.noise = read_noise(*file.noise, n, model.arm.friction.model.state_size(), root / "noise");
  return model;
}

}  // namespace fricid::data
