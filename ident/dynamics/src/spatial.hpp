// Vectors, turns and inertias in the internal frames of a Workspace. Everything is inline on flat
// structs, so that a pack stays in registers.
#pragma once

#include "fricid/base/math.hpp"
#include "fricid/dynamics/workspace.hpp"

namespace fricid::dynamics::detail {

template <class S>
Vec3<S> operator+(const Vec3<S>& a, const Vec3<S>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class S>
Vec3<S>& operator+=(Vec3<S>& a, const Vec3<S>& b) {
  return a = a + b;
}
template <class S>
Vec3<S> operator*(const S& k, const Vec3<S>& a) {
  return {k * a.x, k * a.y, k * a.z};
}
template <class S>
Vec3<S> cross(const Vec3<S>& a, const Vec3<S>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class S>
S dot(const Vec3<S>& a, const Vec3<S>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class A, class S>
Vec3<S> multiply(const Mat3<A>& U, const Vec3<S>& r) {
  return {U.xx * r.x + U.xy * r.y + U.xz * r.z, U.yx * r.x + U.yy * r.y + U.yz * r.z,
          U.zx * r.x + U.zy * r.y + U.zz * r.z};
}
template <class A, class S>
Vec3<S> multiply_transposed(const Mat3<A>& U, const Vec3<S>& r) {
  return {U.xx * r.x + U.yx * r.y + U.zx * r.z, U.xy * r.x + U.yy * r.y + U.zy * r.z,
          U.xz * r.x + U.yz * r.y + U.zz * r.z};
}

/// G sigma G' for a general turn G.
template <class A, class S>
Sym3<S> conjugate(const Mat3<A>& G, const Sym3<S>& s) {
  const Vec3<S> x = multiply(G, Vec3<S>{s.xx, s.xy, s.xz});  // columns of G sigma
  const Vec3<S> y = multiply(G, Vec3<S>{s.xy, s.yy, s.yz});
  const Vec3<S> z = multiply(G, Vec3<S>{s.xz, s.yz, s.zz});
  const Vec3<S> rx = multiply(G, Vec3<S>{x.x, y.x, z.x});
  const Vec3<S> ry = multiply(G, Vec3<S>{x.y, y.y, z.y});
  const Vec3<S> rz = multiply(G, Vec3<S>{x.z, y.z, z.z});
  return {rx.x, rx.y, ry.y, rx.z, ry.z, rz.z};
}

template <class A>
Mat3<A> transpose(const Mat3<A>& G) {
  return {G.xx, G.yx, G.zx, G.xy, G.yy, G.zy, G.xz, G.yz, G.zz};
}

// The constant turn of a joint, and its inverse.
template <class A, class S>
Vec3<S> turn(const Link<A>& link, const Vec3<S>& u) {
  switch (link.turn) {
    case Turn::kNone:
      return u;
    case Turn::kPlus90:
      return {u.x, -u.z, u.y};
    case Turn::kMinus90:
      return {u.x, u.z, -u.y};
    case Turn::kHalf:
      return {u.x, -u.y, -u.z};
    case Turn::kGeneral:
      break;
  }
  return multiply(link.general, u);
}
template <class A, class S>
Vec3<S> turn_back(const Link<A>& link, const Vec3<S>& u) {
  switch (link.turn) {
    case Turn::kNone:
      return u;
    case Turn::kPlus90:
      return {u.x, u.z, -u.y};
    case Turn::kMinus90:
      return {u.x, -u.z, u.y};
    case Turn::kHalf:
      return {u.x, -u.y, -u.z};
    case Turn::kGeneral:
      break;
  }
  return multiply_transposed(link.general, u);
}
template <class A, class S>
Sym3<S> turn(const Link<A>& link, const Sym3<S>& s) {
  switch (link.turn) {
    case Turn::kNone:
      return s;
    case Turn::kPlus90:
      return {s.xx, -s.xz, s.zz, s.xy, -s.yz, s.yy};
    case Turn::kMinus90:
      return {s.xx, s.xz, s.zz, -s.xy, -s.yz, s.yy};
    case Turn::kHalf:
      return {s.xx, -s.xy, s.yy, -s.xz, s.yz, s.zz};
    case Turn::kGeneral:
      break;
  }
  return conjugate(link.general, s);
}

// Child to parent, R u, and back, R' u.
template <class A, class S>
Vec3<S> to_parent(const Link<A>& link, const Motion<S>& j, const Vec3<S>& u) {
  return turn(link, Vec3<S>{j.c * u.x - j.s * u.y, j.s * u.x + j.c * u.y, u.z});
}
template <class A, class S>
Vec3<S> to_child(const Link<A>& link, const Motion<S>& j, const Vec3<S>& u) {
  const Vec3<S> t = turn_back(link, u);
  return {j.c * t.x + j.s * t.y, j.c * t.y - j.s * t.x, t.z};
}

/// Inertia of the child's frame in and about the parent's.
template <class A, class S>
Inertia<S> to_parent(const Link<A>& link, const Motion<S>& j, const Inertia<S>& body) {
  const Sym3<S>& t = body.sigma;
  const S u = j.c * t.xx - j.s * t.xy;
  const S w = j.c * t.xy - j.s * t.yy;
  const S xx = j.c * u - j.s * w;
  Sym3<S> s = turn(link, Sym3<S>{xx, j.s * u + j.c * w, t.xx + t.yy - xx, j.c * t.xz - j.s * t.yz,
                                 j.s * t.xz + j.c * t.yz, t.zz});
  const Vec3<S> h = to_parent(link, j, body.h);
  const Vec3<S>& p = j.p;
  const Vec3<S> g = h + body.m * p;
  s.xx += p.x * (h.x + g.x);
  s.yy += p.y * (h.y + g.y);
  s.zz += p.z * (h.z + g.z);
  s.xy += h.x * p.y + p.x * g.y;
  s.xz += h.x * p.z + p.x * g.z;
  s.yz += h.y * p.z + p.y * g.z;
  return {body.m, g, s};
}

template <class S>
Inertia<S>& operator+=(Inertia<S>& a, const Inertia<S>& b) {
  a.m += b.m;
  a.h += b.h;
  a.sigma = {a.sigma.xx + b.sigma.xx, a.sigma.xy + b.sigma.xy, a.sigma.yy + b.sigma.yy,
             a.sigma.xz + b.sigma.xz, a.sigma.yz + b.sigma.yz, a.sigma.zz + b.sigma.zz};
  return a;
}

/// Internal inertia from the standard parameters (m, m c, I) of a link, and the frame change.
template <class A, class S>
Inertia<S> load_inertia(const Link<A>& link, const S* pi) {
  const S half_trace = S(0.5) * (pi[4] + pi[6] + pi[9]);
  const Vec3<S> h{pi[1], pi[2], pi[3]};
  const Sym3<S> s{half_trace - pi[4], -pi[5], half_trace - pi[6], -pi[7], -pi[8],
                  half_trace - pi[9]};
  if (!link.swaps) {
    return {pi[0], multiply_transposed(link.Q, h), conjugate(transpose(link.Q), s)};
  }
  const std::array<S, 3> first{h.x, h.y, h.z};
  const std::array<std::array<S, 3>, 3> second{
      {{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}}};
  const auto& [i, k, l] = link.source;
  const auto& [si, sk, sl] = link.sign;
  return {pi[0],
          {first[i] * S(si), first[k] * S(sk), first[l] * S(sl)},
          {second[i][i], second[i][k] * S(si * sk), second[k][k], second[i][l] * S(si * sl),
           second[k][l] * S(sk * sl), second[l][l]}};
}

}  // namespace fricid::dynamics::detail
