// The algorithms as templates; algorithms.cpp instantiates them, tests do so for dual numbers.
//
// Newton-Euler with the acceleration tensor U = [alpha]x + [w]x [w]x (Khalil & Dombre 2002, ch. 9):
// a point r of a link has the acceleration a + U r, so that with mass m, first moment h and second
// moment Sigma
//     f = m a + U h,      n = h x a + (U Sigma - Sigma U')^vee.
#pragma once

#include <cassert>

#include "chain.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "spatial.hpp"

namespace fricid::dynamics {

namespace detail {

template <class To, class From>
Vec3<To> convert(const Vec3<From>& a) {
  return {To(a.x), To(a.y), To(a.z)};
}
template <class To, class From>
Mat3<To> convert(const Mat3<From>& m) {
  return {To(m.xx), To(m.xy), To(m.xz), To(m.yx), To(m.yy), To(m.yz), To(m.zx), To(m.zy), To(m.zz)};
}
template <class To>
Link<To> convert(const Link<double>& from) {
  Link<To> to;
  to.revolute = from.revolute;
  to.parent = from.parent;
  to.turn = from.turn;
  to.general = convert<To>(from.general);
  to.offset = To(from.offset);
  to.p0 = convert<To>(from.p0);
  to.swaps = from.swaps;
  to.source = from.source;
  for (size_t k = 0; k < 3; ++k) to.sign[k] = To(from.sign[k]);
  to.Q = convert<To>(from.Q);
  return to;
}

template <class S>
struct Kernels {
  using Real = typename ConstantOf<S>::type;
  using L = Link<Real>;
  using J = Motion<S>;

  static size_t at(int i) { return static_cast<size_t>(i); }

  /// Turn and place of every joint.
  static void place(Workspace<S>& ws, std::span<const S> q) {
    for (size_t i = 0; i < ws.links_.size(); ++i) {
      const L& link = ws.links_[i];
      J& joint = ws.motion_[i];
      const S angle = link.revolute ? q[i] + S(link.offset) : S(link.offset);
      const SinCos<S> sc = sincos(angle);
      joint.c = sc.cos;
      joint.s = sc.sin;
      joint.p = {S(link.p0.x), S(link.p0.y), S(link.p0.z)};
      if (!link.revolute) joint.p += turn(link, Vec3<S>{S(0), S(0), q[i]});
    }
  }

  static void load_bodies(Workspace<S>& ws, std::span<const S> pi) {
    for (size_t i = 0; i < ws.links_.size(); ++i)
      ws.motion_[i].body = load_inertia(ws.links_[i], &pi[10 * i]);
  }

  static Mat3<S> acceleration_tensor(const Vec3<S>& w, const Vec3<S>& alpha) {
    const S xx = w.x * w.x, yy = w.y * w.y, zz = w.z * w.z;
    const S xy = w.x * w.y, xz = w.x * w.z, yz = w.y * w.z;
    return {-(yy + zz),   xy - alpha.z, xz + alpha.y, xy + alpha.z, -(xx + zz),
            yz - alpha.x, xz - alpha.y, yz + alpha.x, -(xx + yy)};
  }

  /// Moment of a link's own inertia forces about its origin.
  static Vec3<S> moment(const Inertia<S>& body, const J& j) {
    const Sym3<S>& s = body.sigma;
    const Mat3<S>& U = j.U;
    const Vec3<S> spin{
        U.zx * s.xy - U.yx * s.xz + U.zy * s.yy - U.yz * s.zz + (U.zz - U.yy) * s.yz,
        U.xy * s.yz - U.zy * s.xy + U.xz * s.zz - U.zx * s.xx + (U.xx - U.zz) * s.xz,
        U.yz * s.xz - U.xz * s.yz + U.yx * s.xx - U.xy * s.yy + (U.yy - U.xx) * s.xy};
    return cross(body.h, j.a) + spin;
  }

  /// Acceleration of the base: against gravity, in the root's internal frame before its own turn.
  static Vec3<S> base_acceleration(const RobotModel& model, const L& link) {
    const auto& g = model.gravity;
    return multiply_transposed(link.general,
                               Vec3<S>{S(Real(-g.x())), S(Real(-g.y())), S(Real(-g.z()))});
  }

  /// Velocities, accelerations and each link's own force from base to tip. `a` empty: zero.
  static void sweep_out(const RobotModel& model, Workspace<S>& ws, std::span<const S> v,
                        std::span<const S> a) {
    for (size_t i = 0; i < ws.links_.size(); ++i) {
      const L& link = ws.links_[i];
      J& j = ws.motion_[i];
      const bool has_a = !a.empty();
      if (link.parent < 0) {
        const Vec3<S> t = base_acceleration(model, link);
        j.w = j.alpha = {S(0), S(0), S(0)};
        j.a = {j.c * t.x + j.s * t.y, j.c * t.y - j.s * t.x, t.z};
      } else {
        const J& parent = ws.motion_[at(link.parent)];
        j.w = to_child(link, j, parent.w);
        j.alpha = to_child(link, j, parent.alpha);
        j.a = to_child(link, j, parent.a + multiply(parent.U, j.p));
      }
      if (link.revolute) {
        j.alpha.x += j.w.y * v[i];
        j.alpha.y -= j.w.x * v[i];
        j.w.z += v[i];
        if (has_a) j.alpha.z += a[i];
      } else {
        const S twice = v[i] + v[i];
        j.a.x += j.w.y * twice;
        j.a.y -= j.w.x * twice;
        if (has_a) j.a.z += a[i];
      }
      j.U = acceleration_tensor(j.w, j.alpha);
      j.f = j.body.m * j.a + multiply(j.U, j.body.h);
      j.n = moment(j.body, j);
    }
  }

  /// Hands the force of link i to its parent.
  static void pass_force(Workspace<S>& ws, size_t i) {
    const L& link = ws.links_[i];
    if (link.parent < 0) return;
    const J& j = ws.motion_[i];
    J& parent = ws.motion_[at(link.parent)];
    const Vec3<S> f = to_parent(link, j, j.f);
    parent.f += f;
    parent.n += to_parent(link, j, j.n) + cross(j.p, f);
  }

  static S axis_force(const L& link, const J& j) { return link.revolute ? j.n.z : j.f.z; }

  static void pass_inertia(Workspace<S>& ws, size_t i) {
    const L& link = ws.links_[i];
    if (link.parent < 0) return;
    const J& j = ws.motion_[i];
    ws.motion_[at(link.parent)].composite += to_parent(link, j, j.composite);
  }

  /// Column i of the mass matrix, upwards from joint i; lower triangle.
  static void mass_column(Workspace<S>& ws, size_t i, const S& armature) {
    const size_t n = ws.links_.size();
    const L* link = &ws.links_[i];
    const J* j = &ws.motion_[i];
    const Inertia<S>& c = j->composite;
    Vec3<S> f, m;  // force and moment of a unit acceleration
    if (link->revolute) {
      f = {-c.h.y, c.h.x, S(0)};
      m = {-c.sigma.xz, -c.sigma.yz, c.sigma.xx + c.sigma.yy};
      ws.M_[i * n + i] = m.z + armature;
    } else {
      f = {S(0), S(0), c.m};
      m = {c.h.y, -c.h.x, S(0)};
      ws.M_[i * n + i] = f.z + armature;
    }
    for (size_t k = 0; k < i; ++k) ws.M_[i * n + k] = S(0);
    while (link->parent >= 0) {
      f = to_parent(*link, *j, f);
      m = to_parent(*link, *j, m) + cross(j->p, f);
      const size_t k = at(link->parent);
      link = &ws.links_[k];
      j = &ws.motion_[k];
      ws.M_[i * n + k] = link->revolute ? m.z : f.z;
    }
  }

  static S shape(const LinearTorque& torque, const S& q) {
    switch (torque.shape) {
      case LinearTorque::Shape::kConstant:
        return S(1);
      case LinearTorque::Shape::kSin:
        return sincos(S(Real(torque.k)) * q).sin;
      case LinearTorque::Shape::kCos:
        return sincos(S(Real(torque.k)) * q).cos;
      case LinearTorque::Shape::kLinear:
        return q;
    }
    return S(0);
  }

  static void add_linear_torques(const RobotModel& model, std::span<const S> pi,
                                 std::span<const S> q, std::span<S> tau) {
    for (size_t k = 0; k < model.linear_torques.size(); ++k) {
      const LinearTorque& torque = model.linear_torques[k];
      const size_t i = at(torque.joint);
      tau[i] += pi[at(model.linear_begin()) + k] * shape(torque, q[i]);
    }
  }

  static void rnea(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                   std::span<const S> q, std::span<const S> v, std::span<const S> a,
                   std::span<S> tau) {
    const size_t n = ws.links_.size();
    place(ws, q);
    load_bodies(ws, pi);
    sweep_out(model, ws, v, a);
    for (size_t i = n; i-- > 0;) {
      tau[i] = axis_force(ws.links_[i], ws.motion_[i]) + pi[10 * n + i] * a[i];
      pass_force(ws, i);
    }
    add_linear_torques(model, pi, q, tau);
  }

  static void crba(Workspace<S>& ws, std::span<const S> pi, std::span<const S> q, std::span<S> M) {
    const size_t n = ws.links_.size();
    place(ws, q);
    load_bodies(ws, pi);
    for (J& j : ws.motion_) j.composite = j.body;
    for (size_t i = n; i-- > 0;) {
      mass_column(ws, i, pi[10 * n + i]);
      pass_inertia(ws, i);
    }
    for (size_t i = 0; i < n; ++i)
      for (size_t k = 0; k <= i; ++k) M[i * n + k] = M[k * n + i] = ws.M_[i * n + k];
  }

  /// M = L D L' in place; L unit lower.
  static void factorise(Workspace<S>& ws) {
    const size_t n = ws.links_.size();
    S* M = ws.M_.data();
    for (size_t k = 0; k < n; ++k) {
      const S inverse = S(1) / M[k * n + k];
      ws.inverse_d_[k] = inverse;
      for (size_t i = k + 1; i < n; ++i) {
        const S l = M[i * n + k] * inverse;
        for (size_t j = k + 1; j < i; ++j) M[i * n + j] -= l * M[k * n + j];
        M[i * n + i] -= l * M[i * n + k];
        M[k * n + i] = M[i * n + k];
        M[i * n + k] = l;
      }
    }
  }

  static void solve(const Workspace<S>& ws, std::span<S> x) {
    const size_t n = ws.links_.size();
    const S* M = ws.M_.data();
    for (size_t i = 0; i < n; ++i)
      for (size_t k = 0; k < i; ++k) x[i] -= M[i * n + k] * x[k];
    for (size_t i = 0; i < n; ++i) x[i] *= ws.inverse_d_[i];
    for (size_t i = n; i-- > 0;)
      for (size_t k = i + 1; k < n; ++k) x[i] -= M[k * n + i] * x[k];
  }

  static void forward_dynamics(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                               std::span<const S> q, std::span<const S> v, std::span<const S> tau,
                               std::span<S> a) {
    const size_t n = ws.links_.size();
    place(ws, q);
    load_bodies(ws, pi);
    sweep_out(model, ws, v, {});
    for (J& j : ws.motion_) j.composite = j.body;
    for (size_t i = n; i-- > 0;) {
      ws.bias_[i] = axis_force(ws.links_[i], ws.motion_[i]);
      pass_force(ws, i);
      mass_column(ws, i, pi[10 * n + i]);
      pass_inertia(ws, i);
    }
    add_linear_torques(model, pi, q, std::span<S>(ws.bias_));
    for (size_t i = 0; i < n; ++i) a[i] = tau[i] - ws.bias_[i];
    factorise(ws);
    solve(ws, a);
  }
};

}  // namespace detail

template <class S>
Workspace<S>::Workspace(const RobotModel& model)
    : motion_(model.joints.size()),
      M_(model.joints.size() * model.joints.size()),
      inverse_d_(model.joints.size()),
      bias_(model.joints.size()),
      own_frames_(model.joints.size()) {
  for (const auto& link : detail::make_links(model))
    links_.push_back(detail::convert<typename detail::ConstantOf<S>::type>(link));
}

template <class S>
void rnea(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi, std::span<const S> q,
          std::span<const S> v, std::span<const S> a, std::span<S> tau) {
  detail::Kernels<S>::rnea(model, ws, pi, q, v, a, tau);
}

template <class S>
void crba(const RobotModel&, Workspace<S>& ws, std::span<const S> pi, std::span<const S> q,
          std::span<S> M) {
  detail::Kernels<S>::crba(ws, pi, q, M);
}

template <class S>
void forward_dynamics(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                      std::span<const S> q, std::span<const S> v, std::span<const S> tau,
                      std::span<S> a) {
  detail::Kernels<S>::forward_dynamics(model, ws, pi, q, v, tau, a);
}

template <class S>
void solve_with_last_factor(const RobotModel&, const Workspace<S>& ws, std::span<const S> b,
                            std::span<S> x) {
  for (size_t i = 0; i < b.size(); ++i) x[i] = b[i];
  detail::Kernels<S>::solve(ws, x);
}

}  // namespace fricid::dynamics
