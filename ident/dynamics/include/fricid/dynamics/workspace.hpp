// Preallocated memory of the rigid-body algorithms. The contents are private to them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fricid/base/pack.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::dynamics {

namespace detail {

template <class S>
struct Vec3 {
  S x, y, z;
};

/// Symmetric 3 x 3 matrix.
template <class S>
struct Sym3 {
  S xx, xy, yy, xz, yz, zz;
};

template <class S>
struct Mat3 {
  S xx, xy, xz, yx, yy, yz, zx, zy, zz;
};

/// Rigid-body parameters about the frame origin: mass, first moment, second moment of mass
/// Sigma = tr(I)/2 1 - I, which turns by two products and shifts without division.
template <class S>
struct Inertia {
  S m;
  Vec3<S> h;
  Sym3<S> sigma;
};

/// Number type of the constants that meet a scalar S.
template <class S>
struct ConstantOf {
  using type = double;
};
template <>
struct ConstantOf<float> {
  using type = float;
};
template <class T, int N>
struct ConstantOf<Pack<T, N>> {
  using type = T;
};

/// Constant turn from a joint frame to its parent's: about x by a quarter turn, as almost every
/// robot has, or anything.
enum class Turn { kNone, kPlus90, kMinus90, kHalf, kGeneral };

/// One joint in internal frames. Their origin is that of frame i; z is the joint axis and x is
/// chosen so that the constant turn to the parent is a quarter turn about x where the mechanism
/// allows:
///     R = turn Rz(q + offset)   revolute,    R = turn Rz(offset), p = p0 + turn z q   prismatic.
template <class Real>
struct Link {
  bool revolute = true;
  int parent = -1;
  Turn turn = Turn::kNone;
  Mat3<Real> general;  ///< the turn as a matrix (at any kind)
  Real offset = 0;     ///< [rad]
  Vec3<Real> p0;       ///< joint origin in the parent's internal frame [m]
  bool swaps = true;   ///< Q only permutes and flips axes
  std::array<int, 3>
      source{};  ///< swaps: internal axis k is sign[k] times axis source[k] of frame i
  std::array<Real, 3> sign{};
  Mat3<Real> Q;  ///< turns internal vectors into frame i
};

/// What one sweep stores per link, in its internal frame.
template <class S>
struct Motion {
  S c, s;                ///< cos, sin of the joint's turn
  Vec3<S> p;             ///< joint origin in the parent's frame
  Vec3<S> w, alpha;      ///< angular velocity and acceleration
  Vec3<S> a;             ///< acceleration of the origin less gravity
  Mat3<S> U;             ///< [alpha]x + [w]x [w]x
  Vec3<S> f, n;          ///< force and moment about the origin that the joint transmits
  Inertia<S> body;       ///< of the link alone
  Inertia<S> composite;  ///< of the link and all it carries
};

/// One link in its own frame i, for the algorithms that exist in double only.
struct OwnFrame {
  Eigen::Matrix3d R;         ///< to the parent's frame
  Eigen::Vector3d p;         ///< origin in the parent's frame
  Eigen::Vector3d w, alpha;  ///< angular velocity and acceleration
  Eigen::Vector3d v, a;      ///< velocity of the origin; its acceleration less gravity
};

template <class S>
struct Kernels;
struct OwnFrameKernels;

}  // namespace detail

/// Memory for a model of n joints, sized once. It also holds the model's geometry in a form made
/// for speed, so make a new one after changing joints (gravity, pi and linear torques may change).
template <class S>
class Workspace {
 public:
  explicit Workspace(const RobotModel& model);

 private:
  friend struct detail::Kernels<S>;
  friend struct detail::OwnFrameKernels;
  std::vector<detail::Link<typename detail::ConstantOf<S>::type>> links_;
  std::vector<detail::Motion<S>> motion_;
  std::vector<S> M_;  ///< mass matrix (n x n); after a factorisation L below, D on the diagonal
  std::vector<S> inverse_d_;  ///< 1 / D (n)
  std::vector<S> bias_;       ///< h (n)
  std::vector<detail::OwnFrame> own_frames_;
};

}  // namespace fricid::dynamics
