// The sweeps along the tree that inverse dynamics, mass matrix and pullback are made of.
//
// Newton-Euler with the acceleration tensor U = [alpha]x + [w]x [w]x (Khalil & Dombre 2002, ch. 9):
// a point r of a link has the acceleration a + U r, so that with mass m, first moment h and second
// moment Sigma
//     f = m a + U h,      n = h x a + (U Sigma - Sigma U')^vee.
#pragma once

#include <algorithm>
#include <span>

#include "spatial.hpp"

namespace fricid::dynamics::detail {

template <class To, class From>
Vec3<To> convert(const Vec3<From>& a) {
  return {To(a.x), To(a.y), To(a.z)};
}
template <class To, class From>
Mat3<To> convert(const Mat3<From>& m) {
  return {To(m.xx), To(m.xy), To(m.xz), To(m.yx), To(m.yy), To(m.yz), To(m.zx), To(m.zy), To(m.zz)};
}
template <class S>
struct Sweeps {
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
      const auto sc = sincos(angle);
      joint.c = sc.cos;
      joint.s = sc.sin;
      if (link.revolute) continue;
      with_turn(
          link.turn, [&]<Turn kind>(TurnIs<kind>) __attribute__((always_inline)) {
            joint.p = turn<kind>(link, Vec3<S>{S(0), S(0), q[i]}) + convert<S>(link.p0);
          });
    }
  }

  [[gnu::always_inline]] static void load_body(const L& link, const S* pi, Inertia<S>& body) {
    link.swaps ? load_swapped(link, pi, body) : load_turned(link, pi, body);
  }

  /// A point r of a link has the acceleration a + U r.
  static Mat3<S> acceleration_tensor(const Vec3<S>& w, const Vec3<S>& alpha) {
    const S xx = w.x * w.x, yy = w.y * w.y, zz = w.z * w.z;
    const S xy = w.x * w.y, xz = w.x * w.z, yz = w.y * w.z;
    return {-(yy + zz),   xy - alpha.z, xz + alpha.y, xy + alpha.z, -(xx + zz),
            yz - alpha.x, xz - alpha.y, yz + alpha.x, -(xx + yy)};
  }

  /// Moment about the origin that turns a second moment of mass.
  static Vec3<S> spin_moment(const Sym3<S>& s, const Mat3<S>& U) {
    const Vec3<S> diagonal{mul_add(U.zy, s.yy, mul_add(-U.yz, s.zz, (U.zz - U.yy) * s.yz)),
                           mul_add(U.xz, s.zz, mul_add(-U.zx, s.xx, (U.xx - U.zz) * s.xz)),
                           mul_add(U.yx, s.xx, mul_add(-U.xy, s.yy, (U.yy - U.xx) * s.xy))};
    return {mul_add(U.zx, s.xy, mul_add(-U.yx, s.xz, diagonal.x)),
            mul_add(U.xy, s.yz, mul_add(-U.zy, s.xy, diagonal.y)),
            mul_add(U.yz, s.xz, mul_add(-U.xz, s.yz, diagonal.z))};
  }

  /// Acceleration of the base, against gravity, in the frame of a link that it carries.
  static Vec3<S> base_acceleration(const RobotModel& model, const L& link, const J& j) {
    const auto& g = model.gravity;
    const Vec3<Real> up =
        turn_back<Turn::kGeneral>(link, Vec3<Real>{Real(-g.x()), Real(-g.y()), Real(-g.z())});
    return to_child<Turn::kNone>(link, j.c, j.s, convert<S>(up));
  }

  /// Outward sweep: rates and accelerations from base to tip. `a` empty: zero.
  static void sweep_out(const RobotModel& model, Workspace<S>& ws, std::span<const S> v,
                        std::span<const S> a) {
    for (size_t i = 0; i < ws.links_.size(); ++i) {
      const L& link = ws.links_[i];
      J& j = ws.motion_[i];
      Vec3<S> w, alpha, acc;
      if (link.parent < 0) {
        w = alpha = {S(0), S(0), S(0)};
        acc = base_acceleration(model, link, j);
      } else {
        const J& parent = ws.motion_[at(link.parent)];
        with_placement(
            link, [&]<Turn kind, Shift shift>(TurnIs<kind>,
                                              ShiftIs<shift>) __attribute__((always_inline)) {
              const S c = in_registers(j.c), s = in_registers(j.s);
              const Mat3<S> U = acceleration_tensor(parent.w, parent.alpha);
              w = to_child<kind>(link, c, s, parent.w);
              alpha = to_child<kind>(link, c, s, parent.alpha);
              acc = to_child<kind>(link, c, s, multiply_add(U, origin<shift>(link, j), parent.a));
            });
      }
      if (link.revolute) {
        alpha.x = mul_add(w.y, v[i], alpha.x);
        alpha.y = mul_add(-w.x, v[i], alpha.y);
        w.z += v[i];
        if (!a.empty()) alpha.z += a[i];
      } else {
        const S twice = v[i] + v[i];
        acc.x = mul_add(w.y, twice, acc.x);
        acc.y = mul_add(-w.x, twice, acc.y);
        if (!a.empty()) acc.z += a[i];
      }
      j.w = w;
      j.alpha = alpha;
      j.a = acc;
    }
  }

  /// Force and moment that the motion of each link alone takes.
  static void own_forces(Workspace<S>& ws, std::span<const S> pi) {
    for (size_t i = 0; i < ws.links_.size(); ++i) {
      J& j = ws.motion_[i];
      load_body(ws.links_[i], &pi[10 * i], j.inertia);
      const Vec3<S> w = in_registers(j.w), alpha = in_registers(j.alpha);
      const Mat3<S> U = acceleration_tensor(w, alpha);
      const Vec3<S> a = in_registers(j.a);
      const auto [m, h, sigma] = in_registers(j.inertia);
      const Vec3<S> f = multiply_add(U, h, Vec3<S>{m * a.x, m * a.y, m * a.z});
      const Vec3<S> n = cross_add(h, a, spin_moment(sigma, U));
      j.force.f = f;
      j.force.n = n;
    }
  }

  /// The wrench w at a link, seen in and about the parent's frame.
  template <Turn kind, class V>
  [[gnu::always_inline]] static void move_wrench(const L& link, const S& c, const S& s, const V& p,
                                                 const Wrench<S>& w, Wrench<S>& out) {
    const Vec3<S> f = to_parent<kind>(link, c, s, in_registers(w.f));
    out.n = cross_add(p, f, to_parent<kind>(link, c, s, in_registers(w.n)));
    out.f = f;
  }
  template <Turn kind, class V>
  [[gnu::always_inline]] static void add_wrench(const L& link, const S& c, const S& s, const V& p,
                                                const Wrench<S>& w, Wrench<S>& sum) {
    const Vec3<S> f = to_parent<kind>(link, c, s, in_registers(w.f));
    sum.n += cross_add(p, f, to_parent<kind>(link, c, s, in_registers(w.n)));
    sum.f += f;
  }

  static S along_axis(const L& link, const Wrench<S>& w) { return link.revolute ? w.n.z : w.f.z; }

  /// Wrench of a unit acceleration of a joint.
  [[gnu::always_inline]] static Wrench<S> unit_wrench(const L& link, const Inertia<S>& c) {
    if (link.revolute) {
      return {{-c.h.y, c.h.x, S(0)}, {-c.sigma.xz, -c.sigma.yz, c.sigma.xx + c.sigma.yy}};
    }
    return {{S(0), S(0), c.m}, {c.h.y, -c.h.x, S(0)}};
  }

  /// Hands forces and, with kMass, inertia and mass-matrix columns of link i to its parent. Column
  /// k carries the wrench of a unit acceleration of joint k towards the base.
  template <Turn kind, Shift shift, bool kForce, bool kMass>
  static void hand_in(Workspace<S>& ws, size_t i) {
    const L& link = ws.links_[i];
    const J& j = ws.motion_[i];
    J& parent = ws.motion_[at(link.parent)];
    const auto p = origin<shift>(link, j);
    const S c = in_registers(j.c), s = in_registers(j.s);
    if constexpr (kForce) add_wrench<kind>(link, c, s, p, j.force, parent.force);
    if constexpr (kMass) {
      const size_t n = ws.links_.size();
      const bool revolute = ws.links_[at(link.parent)].revolute;
      S* const row = &ws.M_[at(link.parent)];
      Wrench<S>* const columns = ws.columns_.data();
      const auto move = [&](const Wrench<S>& w, size_t k) __attribute__((always_inline)) {
        move_wrench<kind>(link, c, s, p, w, columns[k]);
        row[k * n] = revolute ? columns[k].n.z : columns[k].f.z;
      };
      move(unit_wrench(link, j.inertia), i);
      const int* const subtree = &ws.subtrees_[at(link.subtree)];
      for (int k = 1; k < link.subtree_size; ++k) move(columns[at(subtree[k])], at(subtree[k]));
      add_to_parent<kind>(link, c, s, p, in_registers(j.inertia), parent.inertia);
    }
  }

  template <bool kForce, bool kMass>
  static void hand_in_any(Workspace<S>& ws, size_t i) {
    with_placement(ws.links_[i], [&]<Turn kind, Shift shift>(TurnIs<kind>, ShiftIs<shift>) {
      hand_in<kind, shift, kForce, kMass>(ws, i);
    });
  }

  /// Inward sweep: forces to `tau` unless empty and, with kMass, the lower triangle of the mass
  /// matrix without armature.
  template <bool kForce, bool kMass>
  static void sweep_in(Workspace<S>& ws, std::span<S> tau) {
    const size_t n = ws.links_.size();
    if (kMass && ws.branched_) std::fill(ws.M_.begin(), ws.M_.end(), S(0));
    for (size_t i = n; i-- > 0;) {
      const L& link = ws.links_[i];
      const J& j = ws.motion_[i];
      if (kForce && !tau.empty()) tau[i] = along_axis(link, j.force);
      if constexpr (kMass) {
        const Inertia<S>& c = j.inertia;
        ws.M_[i * n + i] = link.revolute ? c.sigma.xx + c.sigma.yy : c.m;
      }
      if (link.parent < 0) continue;
      hand_in_any<kForce, kMass>(ws, i);
    }
  }
};

}  // namespace fricid::dynamics::detail
