// Parts of a Workspace: small vectors of any scalar, the geometry of a chain in internal frames,
// and the quantities that the sweeps store per link.
#pragma once

#include <Eigen/Core>
#include <array>

#include "fricid/base/pack.hpp"

namespace fricid::dynamics::detail {

/// x as a fresh vector: g++ 12 copies a struct around a vector through memory, so the types below
/// are copied field by field with this.
template <class S>
[[gnu::always_inline]] inline S copy(const S& x) {
  if constexpr (kIsPack<S>) {
    return S(x.v);
  } else {
    return x;
  }
}

template <class S>
struct Vec3 {
  S x, y, z;

  Vec3() = default;
  Vec3(const S& x_, const S& y_, const S& z_) : x(copy(x_)), y(copy(y_)), z(copy(z_)) {}
  Vec3(const Vec3& o) : x(copy(o.x)), y(copy(o.y)), z(copy(o.z)) {}
  Vec3& operator=(const Vec3& o) {
    x = copy(o.x);
    y = copy(o.y);
    z = copy(o.z);
    return *this;
  }
};

/// Symmetric 3 x 3 matrix.
template <class S>
struct Sym3 {
  S xx, xy, yy, xz, yz, zz;

  Sym3() = default;
  Sym3(const S& xx_, const S& xy_, const S& yy_, const S& xz_, const S& yz_, const S& zz_)
      : xx(copy(xx_)), xy(copy(xy_)), yy(copy(yy_)), xz(copy(xz_)), yz(copy(yz_)), zz(copy(zz_)) {}
  Sym3(const Sym3& o)
      : xx(copy(o.xx)),
        xy(copy(o.xy)),
        yy(copy(o.yy)),
        xz(copy(o.xz)),
        yz(copy(o.yz)),
        zz(copy(o.zz)) {}
  Sym3& operator=(const Sym3& o) {
    xx = copy(o.xx);
    xy = copy(o.xy);
    yy = copy(o.yy);
    xz = copy(o.xz);
    yz = copy(o.yz);
    zz = copy(o.zz);
    return *this;
  }
};

template <class S>
struct Mat3 {
  S xx, xy, xz, yx, yy, yz, zx, zy, zz;

  Mat3() = default;
  Mat3(const S& xx_, const S& xy_, const S& xz_, const S& yx_, const S& yy_, const S& yz_,
       const S& zx_, const S& zy_, const S& zz_)
      : xx(copy(xx_)),
        xy(copy(xy_)),
        xz(copy(xz_)),
        yx(copy(yx_)),
        yy(copy(yy_)),
        yz(copy(yz_)),
        zx(copy(zx_)),
        zy(copy(zy_)),
        zz(copy(zz_)) {}
  Mat3(const Mat3& o)
      : xx(copy(o.xx)),
        xy(copy(o.xy)),
        xz(copy(o.xz)),
        yx(copy(o.yx)),
        yy(copy(o.yy)),
        yz(copy(o.yz)),
        zx(copy(o.zx)),
        zy(copy(o.zy)),
        zz(copy(o.zz)) {}
  Mat3& operator=(const Mat3& o) {
    xx = copy(o.xx);
    xy = copy(o.xy);
    xz = copy(o.xz);
    yx = copy(o.yx);
    yy = copy(o.yy);
    yz = copy(o.yz);
    zx = copy(o.zx);
    zy = copy(o.zy);
    zz = copy(o.zz);
    return *this;
  }
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

/// Which components of a constant joint origin are not zero: one, as on most robots, or any.
enum class Shift { kX, kY, kZ, kGeneral };

/// One joint in internal frames. Their origin is that of frame i; z is the joint axis and x is
/// chosen so that the constant turn to the parent is a quarter turn about x where the mechanism
/// allows:
///     R = turn Rz(q + offset)   revolute,    R = turn Rz(offset), p = p0 + turn z q   prismatic.
template <class Real>
struct Link {
  bool revolute = true;
  int parent = -1;
  int subtree = 0;  ///< where the list of the links that joint i moves starts in subtrees_
  int subtree_size = 0;
  Turn turn = Turn::kNone;
  Shift shift = Shift::kGeneral;
  Mat3<Real> general;          ///< the turn as a matrix (at any kind)
  Real offset = 0;             ///< [rad]
  Vec3<Real> p0;               ///< joint origin in the parent's internal frame [m]
  Mat3<Real> Q;                ///< turns internal vectors into frame i
  bool swaps = true;           ///< Q only permutes and flips axes, as follows
  std::array<int, 3> first{};  ///< internal h[k] is pi[first[k]], negated where first_zero[k] is -0
  std::array<int, 6> second{};  ///< the same for I in the order of Sym3
  std::array<Real, 3> first_zero{};
  std::array<Real, 6> second_zero{};
};

/// A force and its moment about the frame origin.
template <class S>
struct Wrench {
  Vec3<S> f, n;
};

/// Quantities of the sweeps per link, in its internal frame.
template <class S>
struct Motion {
  S c, s;              ///< cos, sin of the joint's turn
  Vec3<S> p;           ///< joint origin in the parent's frame (prismatic; else p0)
  Vec3<S> w, alpha;    ///< angular velocity and acceleration
  Vec3<S> a;           ///< acceleration of the origin less gravity
  Wrench<S> force;     ///< of the link; that the joint transmits after the inward sweep
  Inertia<S> inertia;  ///< of the link; of the link and all it carries in the inward sweep
};

/// Adjoints of Motion.
template <class S>
struct Adjoint {
  Vec3<S> f, n;  ///< of the transmitted force and moment: a virtual twist
  Vec3<S> w, alpha, a;
  Mat3<S> U;  ///< of the acceleration tensor
};

/// One link in its own frame i, for the algorithms that exist in double only.
struct OwnFrame {
  Eigen::Matrix3d R;         ///< to the parent's frame
  Eigen::Vector3d p;         ///< origin in the parent's frame
  Eigen::Vector3d w, alpha;  ///< angular velocity and acceleration
  Eigen::Vector3d v, a;      ///< velocity of the origin; its acceleration less gravity
};

// The algorithms.
template <class S>
struct Sweeps;
template <class S>
struct Pullback;
template <class S>
struct Kernels;
template <class S>
struct Motors;
struct OwnFrameKernels;

}  // namespace fricid::dynamics::detail
