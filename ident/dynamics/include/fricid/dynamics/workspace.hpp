// Preallocated memory of the rigid-body algorithms. The contents are private to them.
#pragma once

#include <vector>

#include "fricid/dynamics/detail/motion.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::dynamics {

/// Memory for a model of n joints, allocated once. It also holds the geometry of the model in the
/// form that the algorithms use: make a new workspace after changing joints. Gravity, pi and the
/// coefficients of linear torques may change.
template <class S>
class Workspace {
 public:
  explicit Workspace(const RobotModel& model);

 private:
  friend struct detail::Sweeps<S>;
  friend struct detail::Pullback<S>;
  friend struct detail::Kernels<S>;
  friend struct detail::Motors<S>;
  friend struct detail::OwnFrameKernels;

  std::vector<detail::Link<typename detail::ConstantOf<S>::type>> links_;
  std::vector<detail::Motion<S>> motion_;
  std::vector<detail::Adjoint<S>> adjoint_;
  std::vector<detail::Wrench<S>> columns_;  ///< of a unit acceleration of each joint
  std::vector<int> subtrees_;  ///< for each joint the links that it moves, itself first
  bool branched_ = false;
  std::vector<S> M_;          ///< lower triangle of M (n x n), then L of L D L'
  std::vector<S> inverse_d_;  ///< 1 / D (n)
  std::vector<S> bias_;       ///< h (n)
  std::vector<detail::OwnFrame> own_frames_;

  // of arms with coupled motors, else empty
  std::vector<S> A_;                      ///< joints of motors (n x n)
  std::vector<S> q_, v_, a_, tau_;        ///< at the joints (n)
  std::vector<S> q_bar_, v_bar_, a_bar_;  ///< of pullbacks, at the joints (n)
  std::vector<S> MA_;                     ///< (n x n)
};

}  // namespace fricid::dynamics
