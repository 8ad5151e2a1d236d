// The hand-written reverse sweep of inverse dynamics.
#pragma once

#include "linear_torques.hpp"
#include "sweeps.hpp"

namespace fricid::dynamics::detail {

template <class S>
struct Pullback {
  using Forward = Sweeps<S>;
  using L = typename Forward::L;
  using J = typename Forward::J;

  static size_t at(int i) { return static_cast<size_t>(i); }

  /// Where rnea_pullback adds; an empty span is skipped.
  struct Bars {
    std::span<S> q, v, a, pi;
  };

  static void run(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                  std::span<const S> q, std::span<const S> v, std::span<const S> a,
                  std::span<const S> lambda, const Bars& bars) {
    const size_t n = ws.links_.size();
    for (size_t i = 0; i < n; ++i) {
      if (!bars.a.empty()) bars.a[i] += lambda[i] * pi[10 * n + i];
      if (!bars.pi.empty()) bars.pi[10 * n + i] += lambda[i] * a[i];
    }
    if (ws.A_.empty()) return pull_links(model, ws, pi, q, v, a, lambda, bars);

    // through the links at the joints, then back to the motors
    const auto room = [n](std::span<S> bar, std::vector<S>& own) {
      std::fill(own.begin(), own.end(), S(0));
      return bar.empty() ? bar : std::span<S>(own);
    };
    const Bars at_joints{room(bars.q, ws.q_bar_), room(bars.v, ws.v_bar_), room(bars.a, ws.a_bar_),
                         bars.pi};
    pull_links(model, ws, pi, Motors<S>::joints_of(ws, q, ws.q_),
               Motors<S>::joints_of(ws, v, ws.v_), Motors<S>::joints_of(ws, a, ws.a_),
               Motors<S>::joints_of(ws, lambda, ws.tau_), at_joints);
    for (size_t i = 0; i < n; ++i) {
      if (!bars.q.empty()) Motors<S>::add(ws, i, at_joints.q[i], bars.q);
      if (!bars.v.empty()) Motors<S>::add(ws, i, at_joints.v[i], bars.v);
      if (!bars.a.empty()) Motors<S>::add(ws, i, at_joints.a[i], bars.a);
    }
  }

  /// All but the armatures, at the joints.
  static void pull_links(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                         std::span<const S> q, std::span<const S> v, std::span<const S> a,
                         std::span<const S> lambda, const Bars& bars) {
    const size_t n = ws.links_.size();
    Forward::place(ws, q);
    Forward::sweep_out(model, ws, v, a);
    Forward::own_forces(ws, pi);
    Forward::template sweep_in<true, false>(ws, {});
    for (size_t i = 0; i < n; ++i) pull_force(ws, i, lambda[i], bars);
    for (size_t i = n; i-- > 0;) pull_motion(ws, i, v[i], bars);
    for (size_t k = 0; k < model.linear_torques.size(); ++k) {
      const LinearTorque& torque = model.linear_torques[k];
      const size_t i = at(torque.joint), c = at(model.linear_begin()) + k;
      if (!bars.pi.empty()) bars.pi[c] += lambda[i] * LinearTorques<S>::shape(torque, q[i]);
      if (!bars.q.empty()) bars.q[i] += lambda[i] * pi[c] * LinearTorques<S>::slope(torque, q[i]);
    }
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
    const Mat3<S> U = Forward::acceleration_tensor(j.w, j.alpha);
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
      const Mat3<S> tensor = Forward::acceleration_tensor(above.w, above.alpha);
      const Vec3<S> axis = turn<kind>(link, Vec3<S>{S(0), S(0), S(1)});
      bars.q[i] += dot(a, multiply(tensor, axis));
    });
  }
};

}  // namespace fricid::dynamics::detail
