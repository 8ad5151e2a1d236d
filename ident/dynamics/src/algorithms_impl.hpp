// The algorithms as templates; algorithms.cpp instantiates them, tests do so for dual numbers.
//
// Newton-Euler with the acceleration tensor U = [alpha]x + [w]x [w]x (Khalil & Dombre 2002, ch. 9):
// a point r of a link has the acceleration a + U r, so that with mass m, first moment h and second
// moment Sigma
//     f = m a + U h,      n = h x a + (U Sigma - Sigma U')^vee.
#pragma once

#include <algorithm>

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
  to.subtree = from.subtree;
  to.subtree_size = from.subtree_size;
  to.turn = from.turn;
  to.shift = from.shift;
  to.general = convert<To>(from.general);
  to.offset = To(from.offset);
  to.p0 = convert<To>(from.p0);
  to.Q = convert<To>(from.Q);
  to.swaps = from.swaps;
  to.first = from.first;
  to.second = from.second;
  for (size_t k = 0; k < 3; ++k) to.first_zero[k] = To(from.first_zero[k]);
  for (size_t k = 0; k < 6; ++k) to.second_zero[k] = To(from.second_zero[k]);
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

  /// Inward sweep: forces to `tau` and, with kMass, the lower triangle of the mass matrix without
  /// armature.
  template <bool kForce, bool kMass>
  static void sweep_in(Workspace<S>& ws, std::span<S> tau) {
    const size_t n = ws.links_.size();
    if (kMass && ws.branched_) std::fill(ws.M_.begin(), ws.M_.end(), S(0));
    for (size_t i = n; i-- > 0;) {
      const L& link = ws.links_[i];
      const J& j = ws.motion_[i];
      if constexpr (kForce) tau[i] = along_axis(link, j.force);
      if constexpr (kMass) {
        const Inertia<S>& c = j.inertia;
        ws.M_[i * n + i] = link.revolute ? c.sigma.xx + c.sigma.yy : c.m;
      }
      if (link.parent < 0) continue;
      hand_in_any<kForce, kMass>(ws, i);
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
    sweep_out(model, ws, v, a);
    own_forces(ws, pi);
    sweep_in<true, false>(ws, tau);
    for (size_t i = 0; i < n; ++i) tau[i] = mul_add(pi[10 * n + i], a[i], tau[i]);
    add_linear_torques(model, pi, q, tau);
  }

  static void add_armature(Workspace<S>& ws, std::span<const S> pi) {
    const size_t n = ws.links_.size();
    for (size_t i = 0; i < n; ++i) ws.M_[i * n + i] += pi[10 * n + i];
  }

  static void crba(Workspace<S>& ws, std::span<const S> pi, std::span<const S> q, std::span<S> M) {
    const size_t n = ws.links_.size();
    place(ws, q);
    for (size_t i = 0; i < n; ++i) load_body(ws.links_[i], &pi[10 * i], ws.motion_[i].inertia);
    sweep_in<false, true>(ws, {});
    add_armature(ws, pi);
    for (size_t i = 0; i < n; ++i)
      for (size_t k = 0; k <= i; ++k) M[i * n + k] = M[k * n + i] = ws.M_[i * n + k];
  }

  /// Calls f with the number of joints as a compile-time constant for the usual arms, else with 0.
  template <class F>
  static void with_size(size_t n, F&& f) {
    if (n == 6) return f(std::integral_constant<size_t, 6>{});
    if (n == 7) return f(std::integral_constant<size_t, 7>{});
    f(std::integral_constant<size_t, 0>{});
  }

  /// M = L D L' in place; L unit lower.
  static void factorise(Workspace<S>& ws) {
    with_size(ws.links_.size(), [&]<size_t kSize>(std::integral_constant<size_t, kSize>) {
      const size_t n = kSize ? kSize : ws.links_.size();
      S* M = ws.M_.data();
      for (size_t i = 0; i < n; ++i) {
        // row i of L D in place, then of L
        for (size_t k = 0; k < i; ++k) {
          S x = M[i * n + k];
          for (size_t j = 0; j < k; ++j) x = mul_add(-M[i * n + j], M[k * n + j], x);
          M[i * n + k] = x;
        }
        S d = M[i * n + i];
        for (size_t k = 0; k < i; ++k) {
          const S l = M[i * n + k] * ws.inverse_d_[k];
          d = mul_add(-l, M[i * n + k], d);
          M[i * n + k] = l;
        }
        ws.inverse_d_[i] = S(1) / d;
      }
    });
  }

  /// x <- M^-1 x with the factor in ws.
  static void solve(const Workspace<S>& ws, std::span<S> x) {
    with_size(ws.links_.size(), [&]<size_t kSize>(std::integral_constant<size_t, kSize>) {
      const size_t n = kSize ? kSize : ws.links_.size();
      const S* M = ws.M_.data();
      for (size_t i = 0; i < n; ++i) {
        S sum = x[i];
        for (size_t k = 0; k < i; ++k) sum = mul_add(-M[i * n + k], x[k], sum);
        x[i] = sum;
      }
      for (size_t i = n; i-- > 0;) {
        S sum = x[i] * ws.inverse_d_[i];
        for (size_t k = i + 1; k < n; ++k) sum = mul_add(-M[k * n + i], x[k], sum);
        x[i] = sum;
      }
    });
  }

  static void forward_dynamics(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                               std::span<const S> q, std::span<const S> v, std::span<const S> tau,
                               std::span<S> a) {
    const size_t n = ws.links_.size();
    place(ws, q);
    sweep_out(model, ws, v, {});
    own_forces(ws, pi);
    sweep_in<true, true>(ws, ws.bias_);
    add_armature(ws, pi);
    add_linear_torques(model, pi, q, std::span<S>(ws.bias_));
    for (size_t i = 0; i < n; ++i) a[i] = tau[i] - ws.bias_[i];
    factorise(ws);
    solve(ws, a);
  }

  static S shape_slope(const LinearTorque& torque, const S& q) {
    const S k(Real(torque.k));
    switch (torque.shape) {
      case LinearTorque::Shape::kConstant:
        return S(0);
      case LinearTorque::Shape::kSin:
        return k * sincos(k * q).cos;
      case LinearTorque::Shape::kCos:
        return -k * sincos(k * q).sin;
      case LinearTorque::Shape::kLinear:
        return S(1);
    }
    return S(0);
  }

  /// Where rnea_pullback adds; an empty span is skipped.
  struct Bars {
    std::span<S> q, v, a, pi;
  };

  static void rnea_pullback(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                            std::span<const S> q, std::span<const S> v, std::span<const S> a,
                            std::span<const S> lambda, const Bars& bars) {
    const size_t n = ws.links_.size();
    place(ws, q);
    sweep_out(model, ws, v, a);
    own_forces(ws, pi);
    sweep_forces(ws);
    for (size_t i = 0; i < n; ++i) {
      if (!bars.a.empty()) bars.a[i] += lambda[i] * pi[10 * n + i];
      if (!bars.pi.empty()) bars.pi[10 * n + i] += lambda[i] * a[i];
      pull_force(ws, i, lambda[i], bars);
    }
    for (size_t i = n; i-- > 0;) pull_motion(ws, i, v[i], bars);
    for (size_t k = 0; k < model.linear_torques.size(); ++k) {
      const LinearTorque& torque = model.linear_torques[k];
      const size_t i = at(torque.joint), c = at(model.linear_begin()) + k;
      if (!bars.pi.empty()) bars.pi[c] += lambda[i] * shape(torque, q[i]);
      if (!bars.q.empty()) bars.q[i] += lambda[i] * pi[c] * shape_slope(torque, q[i]);
    }
  }

  static void sweep_forces(Workspace<S>& ws) {
    for (size_t i = ws.links_.size(); i-- > 0;)
      if (ws.links_[i].parent >= 0) hand_in_any<true, false>(ws, i);
  }

  /// Reverse of the inward sweep at joint i, parents first. The adjoint of the force that a joint
  /// transmits is a virtual twist: every joint i moves at the rate lambda_i. It works on the link's
  /// own force, whence the adjoints of its inertia and acceleration.
  static void pull_force(Workspace<S>& ws, size_t i, const S& lambda, const Bars& bars) {
    const L& link = ws.links_[i];
    const J& j = ws.motion_[i];
    Adjoint<S>& bar = ws.adjoint_[i];
    bar.f = bar.n = {S(0), S(0), S(0)};
    if (link.parent >= 0) {
      const Adjoint<S>& parent = ws.adjoint_[at(link.parent)];
      with_turn(link.turn, [&]<Turn kind>(TurnIs<kind>) {
        bar.f = to_child<kind>(link, j.c, j.s, cross_add(parent.n, j.p, parent.f));
        bar.n = to_child<kind>(link, j.c, j.s, parent.n);
        if (bars.q.empty()) return;
        const Vec3<S>&f = j.force.f, &m = j.force.n;
        if (link.revolute) {
          bars.q[i] += f.x * bar.f.y - f.y * bar.f.x + m.x * bar.n.y - m.y * bar.n.x;
        } else {
          // the moment p x f grows with q along the axis
          bars.q[i] += f.x * bar.n.y - f.y * bar.n.x;
        }
      });
    }
    (link.revolute ? bar.n.z : bar.f.z) += lambda;

    // f = m a + U h,  n = h x a + (U Sigma)^vee;  with T = [n_bar]x:  U_bar = f_bar h' + T Sigma
    const Inertia<S>& body = j.inertia;
    const Vec3<S>& h = body.h;
    const Sym3<S>& s = body.sigma;
    const Vec3<S>&f = bar.f, &t = bar.n;
    bar.a = cross_add(t, h, Vec3<S>{body.m * f.x, body.m * f.y, body.m * f.z});
    bar.w = bar.alpha = {S(0), S(0), S(0)};
    bar.U = {f.x * h.x + t.y * s.xz - t.z * s.xy, f.x * h.y + t.y * s.yz - t.z * s.yy,
             f.x * h.z + t.y * s.zz - t.z * s.yz, f.y * h.x + t.z * s.xx - t.x * s.xz,
             f.y * h.y + t.z * s.xy - t.x * s.yz, f.y * h.z + t.z * s.xz - t.x * s.zz,
             f.z * h.x + t.x * s.xy - t.y * s.xx, f.z * h.y + t.x * s.yy - t.y * s.xy,
             f.z * h.z + t.x * s.yz - t.y * s.xz};
    if (bars.pi.empty()) return;
    const Mat3<S> U = acceleration_tensor(j.w, j.alpha);
    Inertia<S> inertia;
    inertia.m = dot(f, j.a);
    inertia.h = multiply_add(transpose(U), f, cross(j.a, t));
    // Sigma_bar = T' U, off the diagonal summed over the pair
    inertia.sigma = {t.z * U.yx - t.y * U.zx,
                     t.z * U.yy - t.y * U.zy + t.x * U.zx - t.z * U.xx,
                     t.x * U.zy - t.z * U.xy,
                     t.z * U.yz - t.y * U.zz + t.y * U.xx - t.x * U.yx,
                     t.x * U.zz - t.z * U.xz + t.y * U.xy - t.x * U.yy,
                     t.y * U.xz - t.x * U.yz};
    store_inertia(link, inertia, &bars.pi[10 * i]);
  }

  /// Reverse of the outward sweep at joint i, children first.
  static void pull_motion(Workspace<S>& ws, size_t i, const S& v, const Bars& bars) {
    const L& link = ws.links_[i];
    const J& j = ws.motion_[i];
    Adjoint<S>& bar = ws.adjoint_[i];
    // U = [alpha]x + w w' - w'w 1
    const Mat3<S>& B = bar.U;
    const Vec3<S>& w = j.w;
    bar.alpha += Vec3<S>{B.zy - B.yz, B.xz - B.zx, B.yx - B.xy};
    const S xy = B.xy + B.yx, xz = B.xz + B.zx, yz = B.yz + B.zy;
    const S two(2);
    bar.w += Vec3<S>{xy * w.y + xz * w.z - two * (B.yy + B.zz) * w.x,
                     xy * w.x + yz * w.z - two * (B.xx + B.zz) * w.y,
                     xz * w.x + yz * w.y - two * (B.xx + B.yy) * w.z};

    // the joint's own motion
    const Vec3<S> alpha = bar.alpha, acc = bar.a;
    Vec3<S> rate = bar.w;
    if (link.revolute) {
      if (!bars.a.empty()) bars.a[i] += alpha.z;
      if (!bars.v.empty()) bars.v[i] += rate.z + alpha.x * w.y - alpha.y * w.x;
      rate.x -= alpha.y * v;
      rate.y += alpha.x * v;
      if (!bars.q.empty()) {
        // before the joint: w less z v, alpha less w x z v, a; all turn against q
        const S alpha_x = j.alpha.x - w.y * v, alpha_y = j.alpha.y + w.x * v;
        bars.q[i] += w.y * rate.x - w.x * rate.y + alpha_y * alpha.x - alpha_x * alpha.y +
                     j.a.y * acc.x - j.a.x * acc.y;
      }
    } else {
      if (!bars.a.empty()) bars.a[i] += acc.z;
      if (!bars.v.empty()) bars.v[i] += two * (acc.x * w.y - acc.y * w.x);
      rate.x -= two * acc.y * v;
      rate.y += two * acc.x * v;
    }
    if (link.parent < 0) return;

    const J& above = ws.motion_[at(link.parent)];
    Adjoint<S>& parent = ws.adjoint_[at(link.parent)];
    with_turn(link.turn, [&]<Turn kind>(TurnIs<kind>) {
      parent.w += to_parent<kind>(link, j.c, j.s, rate);
      parent.alpha += to_parent<kind>(link, j.c, j.s, alpha);
      const Vec3<S> a = to_parent<kind>(link, j.c, j.s, acc);
      parent.a += a;
      const Vec3<S>& p = j.p;
      Mat3<S>& U = parent.U;
      U = {U.xx + a.x * p.x, U.xy + a.x * p.y, U.xz + a.x * p.z, U.yx + a.y * p.x, U.yy + a.y * p.y,
           U.yz + a.y * p.z, U.zx + a.z * p.x, U.zy + a.z * p.y, U.zz + a.z * p.z};
      if (link.revolute || bars.q.empty()) return;
      // the origin p moves along the axis
      const Mat3<S> tensor = acceleration_tensor(above.w, above.alpha);
      const Vec3<S> axis = turn<kind>(link, Vec3<S>{S(0), S(0), S(1)});
      bars.q[i] += dot(a, multiply(tensor, axis));
    });
  }
};

}  // namespace detail

template <class S>
Workspace<S>::Workspace(const RobotModel& model)
    : motion_(model.joints.size()),
      adjoint_(model.joints.size()),
      columns_(model.joints.size()),
      M_(model.joints.size() * model.joints.size()),
      inverse_d_(model.joints.size()),
      bias_(model.joints.size()),
      own_frames_(model.joints.size()) {
  for (const auto& link : detail::make_links(model))
    links_.push_back(detail::convert<typename detail::ConstantOf<S>::type>(link));
  for (size_t i = 0; i < links_.size(); ++i) {
    auto& link = links_[i];
    motion_[i].p = detail::convert<S>(link.p0);
    link.subtree = static_cast<int>(subtrees_.size());
    for (size_t k = i; k < links_.size(); ++k) {
      int ancestor = static_cast<int>(k);
      while (ancestor > static_cast<int>(i))
        ancestor = links_[static_cast<size_t>(ancestor)].parent;
      if (ancestor == static_cast<int>(i)) subtrees_.push_back(static_cast<int>(k));
    }
    link.subtree_size = static_cast<int>(subtrees_.size()) - link.subtree;
    if (i + static_cast<size_t>(link.subtree_size) < links_.size()) branched_ = true;
  }
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
void rnea_pullback(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                   std::span<const S> q, std::span<const S> v, std::span<const S> a,
                   std::span<const S> lambda, std::span<S> q_bar, std::span<S> v_bar,
                   std::span<S> a_bar, std::span<S> pi_bar) {
  detail::Kernels<S>::rnea_pullback(model, ws, pi, q, v, a, lambda, {q_bar, v_bar, a_bar, pi_bar});
}

template <class S>
void solve_with_last_factor(const RobotModel&, const Workspace<S>& ws, std::span<const S> b,
                            std::span<S> x) {
  for (size_t i = 0; i < b.size(); ++i) x[i] = b[i];
  detail::Kernels<S>::solve(ws, x);
}

}  // namespace fricid::dynamics
