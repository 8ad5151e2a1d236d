// Vectors, turns and inertias in the internal frames of a Workspace. Everything is inline on flat
// structs, so that a pack stays in registers.
#pragma once

#include <cmath>
#include <type_traits>

#include "fricid/base/math.hpp"
#include "fricid/dynamics/workspace.hpp"

namespace fricid::dynamics::detail {

/// a b + c, rounded once where the scalar can.
template <class S>
[[gnu::always_inline]] inline S mul_add(const S& a, const std::type_identity_t<S>& b,
                                        const std::type_identity_t<S>& c) {
  if constexpr (Lanewise<S>) {
    return fma(a, b, c);
  } else {
    return a * b + c;
  }
}

/// x, read once: g++ would read it from memory again at every use, and memory is the narrowest path
/// (one 64-byte load per cycle).
template <class S>
[[gnu::always_inline]] inline S in_registers(S x) {
#if defined(__GNUC__) && defined(__x86_64__)
  if constexpr (kIsPack<S>) asm("" : "+v"(x.v));
#endif
  return x;
}
template <class S>
[[gnu::always_inline]] inline Vec3<S> in_registers(const Vec3<S>& a) {
  return {in_registers(a.x), in_registers(a.y), in_registers(a.z)};
}
template <class S>
[[gnu::always_inline]] inline Inertia<S> in_registers(const Inertia<S>& a) {
  const Sym3<S>& s = a.sigma;
  return {in_registers(a.m), in_registers(a.h),
          Sym3<S>{in_registers(s.xx), in_registers(s.xy), in_registers(s.yy), in_registers(s.xz),
                  in_registers(s.yz), in_registers(s.zz)}};
}

/// x with its sign flipped where `zero` is -0: no multiplication.
template <class S, class A>
[[gnu::always_inline]] inline S flip(A zero, const S& x) {
  if constexpr (Lanewise<S>) {
    return from_bits(to_bits(x) ^ to_bits(S(zero)));
  } else {
    return std::signbit(zero) ? -x : x;
  }
}

template <class S>
[[gnu::always_inline]] inline Vec3<S> operator+(const Vec3<S>& a, const Vec3<S>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class S>
[[gnu::always_inline]] inline Vec3<S>& operator+=(Vec3<S>& a, const Vec3<S>& b) {
  return a = a + b;
}
/// A component known to be zero when compiled: its products vanish.
struct Zero {
  Zero operator-() const { return {}; }
};
template <class S>
[[gnu::always_inline]] inline S mul_add(Zero, const S&, const S& c) {
  return c;
}
template <class S>
[[gnu::always_inline]] inline S mul_add(const S&, Zero, const S& c) {
  return c;
}
template <class X, class Y, class Z>
struct Offset {
  X x;
  Y y;
  Z z;
};

/// k a + b.
template <class S>
[[gnu::always_inline]] inline Vec3<S> mul_add(const S& k, const Vec3<S>& a, const Vec3<S>& b) {
  return {mul_add(k, a.x, b.x), mul_add(k, a.y, b.y), mul_add(k, a.z, b.z)};
}
template <class S>
[[gnu::always_inline]] inline Vec3<S> cross(const Vec3<S>& a, const Vec3<S>& b) {
  return {mul_add(a.y, b.z, -(a.z * b.y)), mul_add(a.z, b.x, -(a.x * b.z)),
          mul_add(a.x, b.y, -(a.y * b.x))};
}
/// a x b + c.
template <class V, class S>
[[gnu::always_inline]] inline Vec3<S> cross_add(const V& a, const Vec3<S>& b, const Vec3<S>& c) {
  return {mul_add(a.y, b.z, mul_add(-a.z, b.y, c.x)), mul_add(a.z, b.x, mul_add(-a.x, b.z, c.y)),
          mul_add(a.x, b.y, mul_add(-a.y, b.x, c.z))};
}
template <class S>
[[gnu::always_inline]] inline S dot(const Vec3<S>& a, const Vec3<S>& b) {
  return mul_add(a.x, b.x, mul_add(a.y, b.y, a.z * b.z));
}
/// U r + b.
template <class A, class V, class S>
[[gnu::always_inline]] inline Vec3<S> multiply_add(const Mat3<A>& U, const V& r, const Vec3<S>& b) {
  return {mul_add(r.x, S(U.xx), mul_add(r.y, S(U.xy), mul_add(r.z, S(U.xz), b.x))),
          mul_add(r.x, S(U.yx), mul_add(r.y, S(U.yy), mul_add(r.z, S(U.yz), b.y))),
          mul_add(r.x, S(U.zx), mul_add(r.y, S(U.zy), mul_add(r.z, S(U.zz), b.z)))};
}
template <class A>
[[gnu::always_inline]] inline Mat3<A> transpose(const Mat3<A>& G) {
  return {G.xx, G.yx, G.zx, G.xy, G.yy, G.zy, G.xz, G.yz, G.zz};
}
template <class A, class S>
[[gnu::always_inline]] inline Vec3<S> multiply(const Mat3<A>& U, const Vec3<S>& r) {
  return multiply_add(U, r, Vec3<S>{S(0), S(0), S(0)});
}

/// G sigma G' for a turn G.
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

// Call f with the turn, or the shift, or both as compile-time constants, so that each kind has its
// own straight code.
template <Turn kind>
using TurnIs = std::integral_constant<Turn, kind>;
template <Shift kind>
using ShiftIs = std::integral_constant<Shift, kind>;

template <class F>
[[gnu::always_inline]] inline void with_turn(Turn kind, F&& f) {
  switch (kind) {
    case Turn::kNone:
      return f(TurnIs<Turn::kNone>{});
    case Turn::kPlus90:
      return f(TurnIs<Turn::kPlus90>{});
    case Turn::kMinus90:
      return f(TurnIs<Turn::kMinus90>{});
    case Turn::kHalf:
      return f(TurnIs<Turn::kHalf>{});
    case Turn::kGeneral:
      return f(TurnIs<Turn::kGeneral>{});
  }
}
template <class F>
[[gnu::always_inline]] inline void with_shift(Shift kind, F&& f) {
  switch (kind) {
    case Shift::kX:
      return f(ShiftIs<Shift::kX>{});
    case Shift::kY:
      return f(ShiftIs<Shift::kY>{});
    case Shift::kZ:
      return f(ShiftIs<Shift::kZ>{});
    case Shift::kGeneral:
      return f(ShiftIs<Shift::kGeneral>{});
  }
}
template <class A, class F>
[[gnu::always_inline]] inline void with_placement(const Link<A>& link, F&& f) {
  if (link.turn == Turn::kGeneral) return f(TurnIs<Turn::kGeneral>{}, ShiftIs<Shift::kGeneral>{});
  with_turn(
      link.turn, [&]<Turn turn>(TurnIs<turn>) __attribute__((always_inline)) {
        with_shift(
            link.shift, [&]<Shift shift>(ShiftIs<shift>) __attribute__((always_inline)) {
              f(TurnIs<turn>{}, ShiftIs<shift>{});
            });
      });
}

/// Origin of a joint in the parent's frame.
template <Shift shift, class A, class S>
[[gnu::always_inline]] inline auto origin(const Link<A>& link, const Motion<S>& joint) {
  if constexpr (shift == Shift::kX) {
    return Offset<S, Zero, Zero>{S(link.p0.x), {}, {}};
  } else if constexpr (shift == Shift::kY) {
    return Offset<Zero, S, Zero>{{}, S(link.p0.y), {}};
  } else if constexpr (shift == Shift::kZ) {
    return Offset<Zero, Zero, S>{{}, {}, S(link.p0.z)};
  } else {
    return joint.p;
  }
}

// The constant turn of a joint, and its inverse.
template <Turn kind, class A, class S>
[[gnu::always_inline]] inline Vec3<S> turn(const Link<A>& link, const Vec3<S>& u) {
  if constexpr (kind == Turn::kNone) return u;
  if constexpr (kind == Turn::kPlus90) return {u.x, -u.z, u.y};
  if constexpr (kind == Turn::kMinus90) return {u.x, u.z, -u.y};
  if constexpr (kind == Turn::kHalf) return {u.x, -u.y, -u.z};
  if constexpr (kind == Turn::kGeneral) return multiply(link.general, u);
}
template <Turn kind, class A, class S>
[[gnu::always_inline]] inline Vec3<S> turn_back(const Link<A>& link, const Vec3<S>& u) {
  if constexpr (kind == Turn::kNone) return u;
  if constexpr (kind == Turn::kPlus90) return {u.x, u.z, -u.y};
  if constexpr (kind == Turn::kMinus90) return {u.x, -u.z, u.y};
  if constexpr (kind == Turn::kHalf) return {u.x, -u.y, -u.z};
  if constexpr (kind == Turn::kGeneral) return multiply(transpose(link.general), u);
}
template <Turn kind, class A, class S>
[[gnu::always_inline]] inline Sym3<S> turn(const Link<A>& link, const Sym3<S>& s) {
  if constexpr (kind == Turn::kNone) return s;
  if constexpr (kind == Turn::kPlus90) return {s.xx, -s.xz, s.zz, s.xy, -s.yz, s.yy};
  if constexpr (kind == Turn::kMinus90) return {s.xx, s.xz, s.zz, -s.xy, -s.yz, s.yy};
  if constexpr (kind == Turn::kHalf) return {s.xx, -s.xy, s.yy, -s.xz, s.yz, s.zz};
  if constexpr (kind == Turn::kGeneral) return conjugate(link.general, s);
}

// Child to parent, R u, and back, R' u.
template <Turn kind, class A, class S>
[[gnu::always_inline]] inline Vec3<S> to_parent(const Link<A>& link, const S& c, const S& s,
                                                const Vec3<S>& u) {
  return turn<kind>(link, Vec3<S>{mul_add(c, u.x, -(s * u.y)), mul_add(s, u.x, c * u.y), u.z});
}
template <Turn kind, class A, class S>
[[gnu::always_inline]] inline Vec3<S> to_child(const Link<A>& link, const S& c, const S& s,
                                               const Vec3<S>& u) {
  const Vec3<S> t = turn_back<kind>(link, u);
  return {mul_add(c, t.x, s * t.y), mul_add(c, t.y, -(s * t.x)), t.z};
}

/// Adds the inertia of the child, with its frame at p, to that of the parent.
template <Turn kind, class A, class S, class V>
[[gnu::always_inline]] inline void add_to_parent(const Link<A>& link, const S& c, const S& s,
                                                 const V& p, const Inertia<S>& child,
                                                 Inertia<S>& sum) {
  const Sym3<S>& t = child.sigma;
  const S u = mul_add(c, t.xx, -(s * t.xy));
  const S w = mul_add(c, t.xy, -(s * t.yy));
  const S xx = mul_add(c, u, -(s * w));
  const Sym3<S> r =
      turn<kind>(link, Sym3<S>{xx, mul_add(s, u, c * w), t.xx + t.yy - xx,
                               mul_add(c, t.xz, -(s * t.yz)), mul_add(s, t.xz, c * t.yz), t.zz});
  const Vec3<S> h = to_parent<kind>(link, c, s, child.h);
  const Vec3<S> g{mul_add(p.x, child.m, h.x), mul_add(p.y, child.m, h.y),
                  mul_add(p.z, child.m, h.z)};
  sum.m += child.m;
  sum.h.x += g.x;
  sum.h.y += g.y;
  sum.h.z += g.z;
  sum.sigma.xx = mul_add(p.x, h.x + g.x, sum.sigma.xx + r.xx);
  sum.sigma.xy = mul_add(p.y, h.x, mul_add(p.x, g.y, sum.sigma.xy + r.xy));
  sum.sigma.yy = mul_add(p.y, h.y + g.y, sum.sigma.yy + r.yy);
  sum.sigma.xz = mul_add(p.z, h.x, mul_add(p.x, g.z, sum.sigma.xz + r.xz));
  sum.sigma.yz = mul_add(p.z, h.y, mul_add(p.y, g.z, sum.sigma.yz + r.yz));
  sum.sigma.zz = mul_add(p.z, h.z + g.z, sum.sigma.zz + r.zz);
}

/// Second moment of mass from I, and its transpose: the map back of an adjoint.
template <class S>
[[gnu::always_inline]] inline Sym3<S> second_moment(const Sym3<S>& I) {
  const S half_trace = S(0.5) * (I.xx + I.yy + I.zz);
  return {half_trace - I.xx, -I.xy, half_trace - I.yy, -I.xz, -I.yz, half_trace - I.zz};
}

// Internal inertia from the standard parameters of a link: for any Q, and when Q only swaps axes.
template <class A, class S>
void load_turned(const Link<A>& link, const S* pi, Inertia<S>& out) {
  const Mat3<A> Qt = transpose(link.Q);
  out.m = pi[0];
  out.h = multiply(Qt, Vec3<S>{pi[1], pi[2], pi[3]});
  out.sigma = second_moment(conjugate(Qt, Sym3<S>{pi[4], pi[5], pi[6], pi[7], pi[8], pi[9]}));
}
template <class A, class S>
[[gnu::always_inline]] inline void load_swapped(const Link<A>& link, const S* pi, Inertia<S>& out) {
  const auto h = [&](size_t k) { return flip(link.first_zero[k], pi[link.first[k]]); };
  const auto product = [&](size_t k) { return flip(-link.second_zero[k], pi[link.second[k]]); };
  const S xx = pi[link.second[0]], yy = pi[link.second[2]], zz = pi[link.second[5]];
  const S half_trace = S(0.5) * (xx + yy + zz);
  out.m = pi[0];
  out.h = {h(0), h(1), h(2)};
  out.sigma = {half_trace - xx, product(1), half_trace - yy,
               product(3),      product(4), half_trace - zz};
}

/// The transpose of both: adds the adjoint `bar` to pi_bar. Off-diagonal adjoints belong to
/// the pair of entries.
template <class A, class S>
[[gnu::always_inline]] inline void store_inertia(const Link<A>& link, const Inertia<S>& bar,
                                                 S* pi_bar) {
  pi_bar[0] += bar.m;
  const Sym3<S> I = second_moment(bar.sigma);
  if (link.swaps) {
    const S h[3] = {bar.h.x, bar.h.y, bar.h.z};
    const S i[6] = {I.xx, I.xy, I.yy, I.xz, I.yz, I.zz};
    for (size_t k = 0; k < 3; ++k) pi_bar[link.first[k]] += flip(link.first_zero[k], h[k]);
    for (size_t k = 0; k < 6; ++k) pi_bar[link.second[k]] += flip(link.second_zero[k], i[k]);
    return;
  }
  const Vec3<S> h = multiply(link.Q, bar.h);
  const S half(0.5);
  const Sym3<S> full =
      conjugate(link.Q, Sym3<S>{I.xx, half * I.xy, I.yy, half * I.xz, half * I.yz, I.zz});
  const S values[9] = {
      h.x,    h.y, h.z, full.xx, full.xy + full.xy, full.yy, full.xz + full.xz, full.yz + full.yz,
      full.zz};
  for (size_t k = 0; k < 9; ++k) pi_bar[1 + k] += values[k];
}

}  // namespace fricid::dynamics::detail
