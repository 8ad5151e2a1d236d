// The rigid body of the ground truth in MuJoCo, without contacts, limits or joint friction.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::sim {

struct MjModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct MjDataDeleter {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using MjModelPtr = std::unique_ptr<mjModel, MjModelDeleter>;
using MjDataPtr = std::unique_ptr<mjData, MjDataDeleter>;

/// Redirects the messages of MuJoCo: errors become std::runtime_error, warnings one line on
/// stderr; it does not wait for a key or write a log file. Called by every loader; cheap.
/// @throws UserError when the library that was loaded is not the one whose header was compiled
void initialise_mujoco();

/// The MJCF file compiled by MuJoCo, as bytes that are equal if the file and everything it includes
/// or refers to (meshes, textures) are. @throws UserError when it cannot be compiled
std::string compiled_mjcf(const std::filesystem::path& mjcf);

/// A rigid payload: mass [kg], centre of mass [m] in `frame`, inertia about it [kg m^2].
struct Payload {
  dynamics::Frame frame;
  double mass = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

/// A MuJoCo model whose joints are those of a RobotModel, matched by name. Const after loading, so
/// threads share it; each makes its own mjData.
class MujocoArm {
 public:
  /// Loads an MJCF file. Contacts, limits, actuators and all other constraints are off; the
  /// integrator is semi-implicit Euler with `step` [s]. When gravity in the base frame differs from
  /// robot.gravity, the base is turned until it agrees. Without a file the arm is made of `robot`,
  /// payload included (`mjcf_of`). Armatures of a file are those of the motors: where `robot`
  /// couples these, they become inertias of tendons whose lengths are the motor angles.
  /// @throws UserError naming the file and the joint: file not readable, joint missing, of another
  ///         type or not in `robot`, joint with frictionloss or damping, dynamics that differ from
  ///         those of `robot`
  MujocoArm(const std::filesystem::path& mjcf, const dynamics::RobotModel& robot, double step,
            const Payload& payload = {});

  const mjModel& model() const { return *model_; }
  MjDataPtr make_data() const;
  /// The same bodies, joints and tendons without what is only seen (geoms, sites, cameras, lights):
  /// equal motion, bit for bit, at less than MuJoCo's cost of a step of `model`.
  const mjModel& moving() const { return moving_ ? *moving_ : *model_; }
  int n() const { return static_cast<int>(dofs_.size()); }
  double step() const { return model_->opt.timestep; }
  int dof(int joint) const { return dofs_[static_cast<std::size_t>(joint)]; }
  int qpos(int joint) const { return qpos_[static_cast<std::size_t>(joint)]; }
  int body(int joint) const { return bodies_[static_cast<std::size_t>(joint)]; }

 private:
  MjModelPtr model_;
  MjModelPtr moving_;  // null where parts of the file need what is seen
  std::vector<int> dofs_, qpos_, bodies_;
};

/// Largest difference of inverse dynamics between MuJoCo and the engine over `states` random states
/// within the limits, as a share of the largest torque met (linear torques of `robot` left out).
double dynamics_mismatch(const MujocoArm& arm, const dynamics::RobotModel& robot, int states = 5);

}  // namespace fricid::sim
