// Pack: every lane does what the scalar does.
#include "fricid/base/pack.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/base/transpose.hpp"

namespace fricid {
namespace {

template <class P>
class PackLanes : public ::testing::Test {
 protected:
  using T = typename P::Scalar;
  static constexpr T kNaN = std::numeric_limits<T>::quiet_NaN();
  static constexpr T kInf = std::numeric_limits<T>::infinity();

  /// Packs whose lanes together hold all pairs of some awkward numbers.
  static std::vector<std::pair<P, P>> pairs() {
    const std::vector<T> values = {T(0),    T(-0.0),   T(1), T(-1.5), T(0.1),
                                   T(1e30), T(-1e-30), kNaN, kInf,    -kInf};
    std::vector<std::pair<T, T>> flat;
    for (const T a : values)
      for (const T b : values) flat.emplace_back(a, b);
    std::vector<std::pair<P, P>> packs;
    for (std::size_t i = 0; i < flat.size(); i += P::kLanes) {
      P a(0), b(0);
      for (int k = 0; k < P::kLanes; ++k) {
        const auto& pair = flat[(i + static_cast<std::size_t>(k)) % flat.size()];
        a.set(k, pair.first);
        b.set(k, pair.second);
      }
      packs.emplace_back(a, b);
    }
    return packs;
  }

  static bool same(T a, T b) {
    return to_bits(a) == to_bits(b) || (std::isnan(a) && std::isnan(b));
  }

  /// function(pack, pack) lane for lane as function(scalar, scalar).
  template <class Function>
  static void expect_as_scalar(Function function) {
    for (const auto& [a, b] : pairs()) {
      const P y = function(a, b);
      for (int k = 0; k < P::kLanes; ++k)
        EXPECT_TRUE(same(y[k], function(a[k], b[k]))) << a[k] << ", " << b[k] << ": " << y[k];
    }
  }
  template <class Comparison>
  static void expect_mask_as_scalar(Comparison compare) {
    for (const auto& [a, b] : pairs()) {
      const auto mask = compare(a, b);
      bool one = false, every = true;
      for (int k = 0; k < P::kLanes; ++k) {
        EXPECT_EQ(mask[k], compare(a[k], b[k])) << a[k] << ", " << b[k];
        one |= mask[k];
        every &= mask[k];
      }
      EXPECT_EQ(any(mask), one);
      EXPECT_EQ(all(mask), every);
    }
  }
};
using Packs = ::testing::Types<PackD, PackF, Pack<double, 1>, Pack<double, 2>, Pack<float, 4>>;
TYPED_TEST_SUITE(PackLanes, Packs);

TYPED_TEST(PackLanes, Arithmetic) {
  this->expect_as_scalar([](auto a, auto b) { return a + b; });
  this->expect_as_scalar([](auto a, auto b) { return a - b; });
  this->expect_as_scalar([](auto a, auto b) { return a * b; });
  this->expect_as_scalar([](auto a, auto b) { return a / b; });
  this->expect_as_scalar([](auto a, auto) { return -a; });
  this->expect_as_scalar([](auto a, auto b) { return a += b; });
  this->expect_as_scalar([](auto a, auto b) { return a -= b; });
  this->expect_as_scalar([](auto a, auto b) { return a *= b; });
  this->expect_as_scalar([](auto a, auto b) { return a /= b; });
  this->expect_as_scalar([](auto a, auto) { return 2 * a + 1; });
}

TYPED_TEST(PackLanes, Comparison) {
  this->expect_mask_as_scalar([](auto a, auto b) { return a < b; });
  this->expect_mask_as_scalar([](auto a, auto b) { return a <= b; });
  this->expect_mask_as_scalar([](auto a, auto b) { return a > b; });
  this->expect_mask_as_scalar([](auto a, auto b) { return a >= b; });
  this->expect_mask_as_scalar([](auto a, auto b) { return a == b; });
  this->expect_mask_as_scalar([](auto a, auto b) { return a != b; });
  this->expect_mask_as_scalar([](auto a, auto b) { return !(a < b); });
  this->expect_mask_as_scalar([](auto a, auto b) { return (a < b) & (b > 0); });
  this->expect_mask_as_scalar([](auto a, auto b) { return (a < b) | (b > 0); });
}

TYPED_TEST(PackLanes, ElementwiseFunctions) {
  this->expect_as_scalar([](auto a, auto b) { return select(a < b, a, b); });
  this->expect_as_scalar([](auto a, auto b) { return min(a, b); });
  this->expect_as_scalar([](auto a, auto b) { return max(a, b); });
  this->expect_as_scalar([](auto a, auto b) { return clamp(a, -1, b); });
  this->expect_as_scalar([](auto a, auto) { return abs(a); });
  this->expect_as_scalar([](auto a, auto) { return sign(a); });
  this->expect_as_scalar([](auto a, auto) { return sqrt(a); });
  this->expect_as_scalar([](auto a, auto b) { return fma(a, b, a); });
  this->expect_as_scalar(
      [](auto a, auto) { return from_bits(to_bits(a) ^ to_bits(a) ^ to_bits(a)); });
}

/// One true lane anywhere is enough for any(), one false lane too many for all().
TYPED_TEST(PackLanes, AnyAndAllSeeEveryLane) {
  using P = TypeParam;
  EXPECT_FALSE(any(P(0) != P(0)));
  EXPECT_TRUE(all(P(0) == P(0)));
  for (int k = 0; k < P::kLanes; ++k) {
    P x(0);
    set_lane(x, k, typename P::Scalar(1));
    EXPECT_TRUE(any(x != P(0))) << k;
    EXPECT_FALSE(all(x == P(0))) << k;
    EXPECT_EQ(lane(x, k), 1);
  }
}

/// (1 + e)(1 - e) - 1 = -e^2, which rounding the product would lose.
TYPED_TEST(PackLanes, FmaRoundsOnce) {
  using P = TypeParam;
  using Real = typename P::Scalar;
  const Real e = std::numeric_limits<Real>::epsilon();
  const P y = fma(P(1 + e), P(1 - e), P(-1));
  for (int k = 0; k < P::kLanes; ++k) EXPECT_EQ(y[k], -e * e);
}

/// std::sin serves the lanes beyond the limit and those alone.
TYPED_TEST(PackLanes, SinCosOfOneLargeLaneLeavesTheOthers) {
  using P = TypeParam;
  using Real = typename P::Scalar;
  for (int k = 0; k < P::kLanes; ++k) {
    P x(Real(0.7));
    x.set(k, Real(1e15));
    const SinCos<P> y = sincos(x);
    for (int i = 0; i < P::kLanes; ++i) {
      const SinCos<Real> expected = sincos(x[i]);
      EXPECT_EQ(y.sin[i], expected.sin);
      EXPECT_EQ(y.cos[i], expected.cos);
    }
    EXPECT_NEAR(y.sin[k], std::sin(Real(1e15)), 1e-6);
  }
}

TEST(Pack, ScalarsReadAsPacksOfOneLane) {
  double x = 2;
  set_lane(x, 0, 3.0);
  EXPECT_EQ(lane(x, 0), 3);
  EXPECT_EQ(kLaneCount<double>, 1);
  EXPECT_EQ(kLaneCount<PackD>, PackD::kLanes);
  EXPECT_EQ(static_cast<int>(sizeof(PackD)), kRegisterBytes);
  EXPECT_EQ(static_cast<int>(sizeof(PackF)), kRegisterBytes);
}

TEST(Pack, TransposesRowsAndLanes) {
  std::array<PackF, PackF::kLanes> x;
  for (int row = 0; row < PackF::kLanes; ++row)
    for (int k = 0; k < PackF::kLanes; ++k)
      x[static_cast<std::size_t>(row)].set(k, static_cast<float>(100 * row + k));
  transpose(x);
  for (int row = 0; row < PackF::kLanes; ++row)
    for (int k = 0; k < PackF::kLanes; ++k)
      EXPECT_EQ(x[static_cast<std::size_t>(row)][k], static_cast<float>(100 * k + row));
}

}  // namespace
}  // namespace fricid
