// Rigid-body algorithms on any scalar S: double (one state) or Pack (one state per lane). The model
// is const and shared; the workspace is the caller's, made once per thread; nothing here allocates.
// With coupled motors q, v, a and tau are those of the motors (see RobotModel).
// Explicit instantiations: double, PackD, PackF.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/base/pack.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/dynamics/workspace.hpp"

namespace fricid::dynamics {

/// Inverse dynamics (Luh, Walker & Paul 1980; Featherstone 2008, ch. 5):
///     tau = M(q) a + h(q, v) + armature a + linear torques.     [q, v, a, tau: n; pi: 11 n + n_c]
template <class S>
void rnea(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi, std::span<const S> q,
          std::span<const S> v, std::span<const S> a, std::span<S> tau);

/// Mass matrix with armature (Featherstone 2008, ch. 6), row-major (n x n), both triangles filled.
template <class S>
void crba(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi, std::span<const S> q,
          std::span<S> M);

/// Forward dynamics  a = M^-1 (tau - h)  by CRBA and LDL'. tau: motor torque less friction [N m].
template <class S>
void forward_dynamics(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                      std::span<const S> q, std::span<const S> v, std::span<const S> tau,
                      std::span<S> a);

/// x = M^-1 b with the factor of the last forward_dynamics on this workspace.
template <class S>
void solve_with_last_factor(const RobotModel& model, const Workspace<S>& ws, std::span<const S> b,
                            std::span<S> x);

/// Vector-Jacobian product of rnea: adds lambda' d(rnea)/d(q, v, a, pi) to q_bar, v_bar, a_bar (n)
/// and pi_bar (11 n + n_c); an output with an empty span is skipped. One reverse sweep.
template <class S>
void rnea_pullback(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                   std::span<const S> q, std::span<const S> v, std::span<const S> a,
                   std::span<const S> lambda, std::span<S> q_bar, std::span<S> v_bar,
                   std::span<S> a_bar, std::span<S> pi_bar);

/// Regressor Y (n x (11 n + n_c)) such that  rnea = Y(q, v, a) pi.
void regressor(const RobotModel& model, Workspace<double>& ws, std::span<const double> q,
               std::span<const double> v, std::span<const double> a, Eigen::Ref<Eigen::MatrixXd> Y);

/// Kinetic energy [J], armature included.
double kinetic_energy(const RobotModel& model, Workspace<double>& ws, std::span<const double> pi,
                      std::span<const double> q, std::span<const double> v);
/// Potential energy of gravity [J], relative to all masses at the base origin.
double potential_energy(const RobotModel& model, Workspace<double>& ws, std::span<const double> pi,
                        std::span<const double> q);

struct Pose {
  Eigen::Matrix3d R;
  Eigen::Vector3d p;
};
/// Pose of a frame of the model in the base frame. q: at the joints
Pose frame_pose(const RobotModel& model, const Frame& frame, std::span<const double> q);
/// The pose of the frame called `name`. @throws UserError if unknown, with the known frames
Pose frame_pose(const RobotModel& model, std::string_view frame, std::span<const double> q);

}  // namespace fricid::dynamics
