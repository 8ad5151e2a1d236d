#include "fricid/sim/mujoco_arm.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <mutex>
#include <numbers>
#include <stdexcept>
#include <string>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/sim/mjcf.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::sim {
namespace {

// MuJoCo and the engine agree to rounding; a wrong number in a model file differs by far more.
constexpr double kMismatchAllowed = 1e-8;

struct MjSpecDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
using MjSpecPtr = std::unique_ptr<mjSpec, MjSpecDeleter>;

void throw_error(const char* message) {
  throw std::runtime_error(std::string("MuJoCo: ") + message);
}

void print_warning(const char* message) {
  std::fprintf(stderr, "MuJoCo: %s\n", printable(message).c_str());
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// @param text  the MJCF; empty: that of `file`, which is its name in messages
MjSpecPtr parse(const std::string& file, const std::string& text) {
  if (text.empty()) require_regular_file(file);
  std::array<char, 1024> error{};
  const auto size = static_cast<int>(error.size());
  MjSpecPtr spec(text.empty() ? mj_parseXML(file.c_str(), nullptr, error.data(), size)
                              : mj_parseXMLString(text.c_str(), nullptr, error.data(), size));
  if (!spec) throw UserError("{}: {}", file, one_line(error.data()));
  return spec;
}

MjModelPtr compile(mjSpec& spec, const std::filesystem::path& mjcf) {
  MjModelPtr model(mj_compile(&spec, nullptr));
  if (!model) throw UserError("{}: {}", mjcf.string(), one_line(mjs_getError(&spec)));
  return model;
}

// The joints of the robot in a model, by name.
std::vector<int> matched_joints(const mjModel& model, const std::string& file,
                                const dynamics::RobotModel& robot) {
  std::vector<int> ids;
  for (const dynamics::Joint& joint : robot.joints) {
    const int id = mj_name2id(&model, mjOBJ_JOINT, joint.name.c_str());
    if (id < 0) throw UserError("{}: joint {} of {} is missing", file, joint.name, robot.name);
    const int type = model.jnt_type[id];
    if (type != (joint.type == dynamics::JointType::kRevolute ? mjJNT_HINGE : mjJNT_SLIDE))
      throw UserError("{}: joint {} has another type than in {}", file, joint.name, robot.name);
    const int dof = model.jnt_dofadr[id];
    if (model.dof_frictionloss[dof] != 0 || model.dof_damping[dof] != 0)
      throw UserError(
          "{}: joint {} has frictionloss {} and damping {}, allowed 0: friction is added to it",
          file, joint.name, model.dof_frictionloss[dof], model.dof_damping[dof]);
    ids.push_back(id);
  }
  return ids;
}

Eigen::Matrix3d orientation_of(const mjModel& model, int body) {
  const MjDataPtr data(mj_makeData(&model));
  mj_kinematics(&model, data.get());
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * body);
}

/// @param file  of the spec, for the message
mjsBody& find_body(const mjSpec& spec, const mjModel& model, int body, const std::string& file) {
  const char* name = mj_id2name(&model, mjOBJ_BODY, body);
  mjsBody* found = name ? mjs_findBody(&spec, name) : nullptr;
  if (!found)
    throw UserError("{}: a body without name; allowed: the base and the last link have one", file);
  return *found;
}

// Turns the base so that gravity, seen from the carrier of the first joint, is `wanted`.
bool turn_base(mjSpec& spec, const mjModel& model, int first_body, const Eigen::Vector3d& wanted,
               const std::string& file) {
  const Eigen::Matrix3d R_WB = orientation_of(model, model.body_parentid[first_body]);
  const Eigen::Vector3d gravity(model.opt.gravity), found = R_WB.transpose() * gravity;
  if ((found - wanted).norm() <= 1e-9 * std::max(1.0, wanted.norm())) return false;
  // R makes R_WB' R' g = wanted, so R takes R_WB wanted to g.
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(R_WB * wanted, gravity);
  const int root = model.body_rootid[first_body];
  const double* quat = model.body_quat + 4 * root;
  const Eigen::Quaterniond now = turn * Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]);
  mjsBody& base = find_body(spec, model, root, file);
  base.alt.type = mjORIENTATION_QUAT;
  base.quat[0] = now.w();
  base.quat[1] = now.x();
  base.quat[2] = now.y();
  base.quat[3] = now.z();
  return true;
}

void add_payload_body(mjSpec& spec, const mjModel& model, int link_body, const Payload& payload,
                      const std::string& file) {
  mjsBody* body = mjs_addBody(&find_body(spec, model, link_body, file), nullptr);
  const Eigen::Vector3d p = payload.frame.p + payload.frame.R * payload.com;
  const Eigen::Matrix3d I = payload.frame.R * payload.inertia * payload.frame.R.transpose();
  // principal axes, so that a point mass is allowed too
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(I);
  Eigen::Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  const Eigen::Quaterniond q(axes);
  body->explicitinertial = 1;
  body->mass = payload.mass;
  const std::array<double, 4> quat{q.w(), q.x(), q.y(), q.z()};
  std::copy(quat.begin(), quat.end(), body->iquat);
  for (int i = 0; i < 3; ++i) {
    body->ipos[i] = p[i];
    body->inertia[i] = std::max(0.0, principal.eigenvalues()[i]);
  }
}

// Rotors of coupled motors: the armature of their joints becomes the inertia of tendons whose
// lengths are the motor angles. A file may have such tendons already.
void couple_motors(mjSpec& spec, const dynamics::RobotModel& robot) {
  const Eigen::MatrixXd C = robot.motors_of_joints();
  for (int k = 0; k < robot.n(); ++k) {
    const std::string& own = robot.joints[static_cast<std::size_t>(k)].name;
    const std::string name = "motor of " + own;
    if ((C.row(k).array() != 0).count() == 1 || mjs_findElement(&spec, mjOBJ_TENDON, name.c_str()))
      continue;
    mjsJoint* joint = mjs_asJoint(mjs_findElement(&spec, mjOBJ_JOINT, own.c_str()));
    mjsTendon* tendon = mjs_addTendon(&spec, nullptr);
    mjs_setName(tendon->element, name.c_str());
    tendon->armature = joint->armature;
    joint->armature = 0;
    for (int j = 0; j < robot.n(); ++j)
      if (C(k, j) != 0)
        mjs_wrapJoint(tendon, robot.joints[static_cast<std::size_t>(j)].name.c_str(), C(k, j));
  }
}

bool same_inertias(const mjModel& x, const mjModel& y) {
  if (x.nbody != y.nbody || x.nv != y.nv) return false;
  for (int b = 0; b < x.nbody; ++b) {
    const auto same = [&](const mjtNum* of_x, const mjtNum* of_y, int size) {
      return std::equal(of_x + size * b, of_x + size * (b + 1), of_y + size * b);
    };
    const bool moves = x.body_weldid[b] != 0;
    if (moves && !(same(x.body_mass, y.body_mass, 1) && same(x.body_ipos, y.body_ipos, 3) &&
                   same(x.body_iquat, y.body_iquat, 4) && same(x.body_inertia, y.body_inertia, 3)))
      return false;
  }
  return true;
}

/// @param spec   that of `model`, without what is only seen afterwards
/// @return the model without it; null where bodies take their inertia from it, or where other
///         parts of the file refer to it
MjModelPtr without_looks(mjSpec& spec, const mjModel& model) {
  for (const mjtObj seen : {mjOBJ_GEOM, mjOBJ_SITE, mjOBJ_CAMERA, mjOBJ_LIGHT})
    while (mjsElement* element = mjs_firstElement(&spec, seen))
      if (mjs_delete(&spec, element) != 0) return nullptr;
  MjModelPtr bare(mj_compile(&spec, nullptr));
  if (bare && !same_inertias(model, *bare)) bare.reset();
  return bare;
}

void disable_all_but_gravity(mjModel& model, double step) {
  model.opt.disableflags |= mjDSBL_CONSTRAINT | mjDSBL_CONTACT | mjDSBL_LIMIT |
                            mjDSBL_FRICTIONLOSS | mjDSBL_EQUALITY | mjDSBL_ACTUATION |
                            mjDSBL_AUTORESET;
  model.opt.integrator = mjINT_EULER;
  model.opt.timestep = step;
}

}  // namespace

void initialise_mujoco() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (mj_version() != mjVERSION_HEADER)
      throw UserError("MuJoCo library is {}, this program was built for {}", mj_version(),
                      mjVERSION_HEADER);
    mju_user_error = throw_error;
    mju_user_warning = print_warning;
  });
}

std::string compiled_mjcf(const std::filesystem::path& mjcf) {
  initialise_mujoco();
  const MjSpecPtr spec = parse(mjcf.string(), "");
  const MjModelPtr model = compile(*spec, mjcf);
  std::string bytes(static_cast<std::size_t>(mj_sizeModel(model.get())), '\0');
  mj_saveModel(model.get(), nullptr, bytes.data(), static_cast<mjtSize>(bytes.size()));
  return bytes;
}

void require_joints(const std::filesystem::path& mjcf, const dynamics::RobotModel& robot) {
  initialise_mujoco();
  const MjModelPtr model = compile(*parse(mjcf.string(), ""), mjcf);
  matched_joints(*model, mjcf.string(), robot);
}

MujocoArm::MujocoArm(const std::filesystem::path& mjcf, const dynamics::RobotModel& robot,
                     double step, const Payload& payload) {
  initialise_mujoco();
  const bool made = mjcf.empty();
  const std::string file = made ? fmt::format("MJCF made of {}", robot.name) : mjcf.string();
  const MjSpecPtr spec = parse(file, made ? mjcf_of(robot) : "");
  model_ = compile(*spec, mjcf);

  // match the joints by name, both ways
  for (const int id : matched_joints(*model_, file, robot)) {
    dofs_.push_back(model_->jnt_dofadr[id]);
    qpos_.push_back(model_->jnt_qposadr[id]);
    bodies_.push_back(model_->jnt_bodyid[id]);
  }
  if (model_->nv != n())
    throw UserError("{}: {} degrees of freedom, {} has {}", file, model_->nv, robot.name, n());

  // add payload, mount and rotors of the scene, then compile again
  const bool turned = turn_base(*spec, *model_, bodies_.front(), robot.gravity, file);
  const bool loaded = payload.mass > 0 && !made;  // `robot` carries it already
  if (loaded) {
    const int link = payload.frame.link;
    if (link < 0) throw UserError("{}: payload on a frame that does not move", file);
    add_payload_body(*spec, *model_, body(link), payload, file);
  }
  if (robot.coupled()) couple_motors(*spec, robot);
  if (turned || loaded || robot.coupled()) model_ = compile(*spec, mjcf);
  disable_all_but_gravity(*model_, step);
  moving_ = without_looks(*spec, *model_);
  if (moving_) disable_all_but_gravity(*moving_, step);

  if (const double mismatch = dynamics_mismatch(*this, robot); mismatch > kMismatchAllowed)
    throw UserError(
        "{}: inverse dynamics differ from {} by {:.1e} of the largest torque, allowed {:.0e}", file,
        robot.name, mismatch, kMismatchAllowed);
}

MjDataPtr MujocoArm::make_data() const { return MjDataPtr(mj_makeData(model_.get())); }

double dynamics_mismatch(const MujocoArm& arm, const dynamics::RobotModel& robot, int states) {
  dynamics::RobotModel tree = robot;
  tree.linear_torques.clear();
  tree.pi.conservativeResize(tree.linear_begin());
  dynamics::Workspace<double> ws(tree);
  const Transmission motors(robot);

  const auto n = static_cast<std::size_t>(arm.n());
  std::vector<double> q(n), v(n), a(n), tau(n);
  const MjDataPtr data = arm.make_data();
  double difference = 0, largest = 0;
  for (int s = 0; s < states; ++s) {
    Rng rng(0, static_cast<std::uint64_t>(s));
    for (std::size_t j = 0; j < n; ++j) {
      q[j] = std::numbers::pi * (2 * rng.uniform() - 1);
      v[j] = 2 * rng.normal();
      a[j] = 5 * rng.normal();
      const int joint = static_cast<int>(j);
      data->qpos[arm.qpos(joint)] = q[j];
      data->qvel[arm.dof(joint)] = v[j];
      data->qacc[arm.dof(joint)] = a[j];
    }
    mj_inverse(&arm.model(), data.get());
    for (std::vector<double>* x : {&q, &v, &a}) {
      Eigen::Map<RowMatrix> row(x->data(), 1, robot.n());
      row = motors.to_motors(row);
    }
    dynamics::rnea<double>(tree, ws, {tree.pi.data(), static_cast<std::size_t>(tree.pi.size())}, q,
                           v, a, tau);
    Eigen::Map<RowMatrix> tau_row(tau.data(), 1, robot.n());
    tau_row = motors.torque_to_joints(tau_row);
    for (std::size_t j = 0; j < n; ++j) {
      const double of_mujoco = data->qfrc_inverse[arm.dof(static_cast<int>(j))];
      if (!std::isfinite(of_mujoco)) return std::numeric_limits<double>::infinity();
      difference = std::max(difference, std::abs(of_mujoco - tau[j]));
      largest = std::max(largest, std::abs(tau[j]));
    }
  }
  return difference / largest;
}

}  // namespace fricid::sim
