// Errors of the elementary functions in units in the last place (ulp), against long double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "fricid/base/math.hpp"

namespace fricid {
namespace {

constexpr int kPoints = 1'000'000;  // per grid

/// Distance of y from the exact value in ulp of the exact value, at least that of a subnormal.
template <class T>
double ulp_error(T y, long double exact) {
  const T rounded = static_cast<T>(exact);
  if (std::isnan(y) || std::isnan(rounded)) return std::isnan(y) && std::isnan(rounded) ? 0 : 1e9;
  if (std::isinf(y) || std::isinf(rounded)) return y == rounded ? 0 : 1e9;
  const int digits = std::numeric_limits<T>::digits;
  const int lowest = std::numeric_limits<T>::min_exponent - digits;
  const int exponent = exact == 0 ? lowest : std::max(std::ilogb(exact) + 1 - digits, lowest);
  return static_cast<double>(std::scalbn(std::fabs(y - exact), -exponent));
}

/// Equally spaced values.
template <class T>
std::vector<T> linear_grid(double low, double high) {
  std::vector<T> x(kPoints);
  for (int i = 0; i < kPoints; ++i)
    x[static_cast<std::size_t>(i)] = static_cast<T>(low + (high - low) * i / (kPoints - 1));
  return x;
}

/// Values whose bit patterns are equally spaced from `low` to `high` >= 0: all exponents alike,
/// with subnormals; `sign` = -1 negates them.
template <class T>
std::vector<T> bit_grid(T low, T high, T sign = 1) {
  std::vector<T> x(kPoints);
  const auto first = to_bits(low), span = to_bits(high) - first;
  for (int i = 0; i < kPoints; ++i) {
    const long double share = static_cast<long double>(i) / (kPoints - 1);
    const auto offset = static_cast<decltype(first)>(share * static_cast<long double>(span) + 0.5L);
    x[static_cast<std::size_t>(i)] = sign * from_bits(first + offset);
  }
  return x;
}

template <class T>
using Grids = std::vector<std::vector<T>>;

template <class T>
constexpr T kMax = std::numeric_limits<T>::max();

/// All finite numbers of both signs, by bit pattern, and [-8, 8].
template <class T>
Grids<T> everywhere() {
  return {bit_grid<T>(0, kMax<T>), bit_grid<T>(0, kMax<T>, -1), linear_grid<T>(-8, 8)};
}

/// Largest error of a function of one argument; all widths must give the bits of the scalar.
template <class T, class Function, class Exact>
void expect_ulp(Function function, Exact exact, const Grids<T>& grids, double bound) {
  using P = std::conditional_t<std::is_same_v<T, double>, PackD, PackF>;
  double worst = 0;
  T worst_at = 0;
  for (const std::vector<T>& grid : grids) {
    for (std::size_t i = 0; i + P::kLanes <= grid.size(); i += P::kLanes) {
      P x(0);
      for (int k = 0; k < P::kLanes; ++k) x.set(k, grid[i + static_cast<std::size_t>(k)]);
      const P y = function(x);
      for (int k = 0; k < P::kLanes; ++k) {
        const T scalar = function(x[k]);
        const T packed = y[k];
        ASSERT_TRUE(to_bits(scalar) == to_bits(packed) ||
                    (std::isnan(scalar) && std::isnan(packed)))
            << "x = " << x[k] << ", scalar " << scalar << ", lane " << packed;
        const double error = ulp_error(packed, exact(static_cast<long double>(x[k])));
        if (error > worst) {
          worst = error;
          worst_at = x[k];
        }
      }
    }
  }
  ::testing::Test::RecordProperty("max_ulp", std::to_string(worst));
  std::printf("  max error %.3f ulp at %.9g\n", worst, static_cast<double>(worst_at));
  EXPECT_LE(worst, bound) << "at x = " << worst_at;
}

template <class T>
class Accuracy : public ::testing::Test {};
using Reals = ::testing::Types<double, float>;
TYPED_TEST_SUITE(Accuracy, Reals);

template <class T>
constexpr bool kDouble = std::is_same_v<T, double>;

TYPED_TEST(Accuracy, Exp) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(kDouble<T> ? linear_grid<T>(-746, 710) : linear_grid<T>(-104, 89));
  expect_ulp<T>([](auto x) { return exp(x); }, [](long double x) { return std::exp(x); }, grids, 1);
}

/// Its error is promised as an absolute one.
TYPED_TEST(Accuracy, Decay) {
  using T = TypeParam;
  constexpr double kUlpOfOne = std::numeric_limits<T>::epsilon();
  for (const auto& grid : {bit_grid<T>(0, kMax<T>), linear_grid<T>(0, 60)}) {
    double worst = 0;
    for (const T x : grid) {
      const auto exact = std::exp(-std::min(static_cast<long double>(x), 60.0L));
      worst = std::max(worst, static_cast<double>(std::fabs(decay(x) - exact)) / kUlpOfOne);
      ASSERT_LE(decay(x), T(1)) << x;
    }
    EXPECT_LE(worst, 0.75);
    std::printf("  max error %.3f of the distance of 1 to the next number\n", worst);
  }
  using P = std::conditional_t<kDouble<T>, PackD, PackF>;
  const std::vector<T> x = linear_grid<T>(0, 70);
  for (std::size_t i = 0; i + P::kLanes <= x.size(); i += P::kLanes) {
    P lanes(0);
    for (int k = 0; k < P::kLanes; ++k) lanes.set(k, x[i + static_cast<std::size_t>(k)]);
    const P y = decay(lanes);
    for (int k = 0; k < P::kLanes; ++k) ASSERT_EQ(y[k], decay(lanes[k])) << lanes[k];
  }
  EXPECT_EQ(decay(T(0)), T(1));
}

TYPED_TEST(Accuracy, Expm1) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(kDouble<T> ? linear_grid<T>(-50, 710) : linear_grid<T>(-30, 89));
  grids.push_back(linear_grid<T>(-0.5, 1.5));
  expect_ulp<T>([](auto x) { return expm1(x); }, [](long double x) { return std::expm1(x); }, grids,
                2);
}

TYPED_TEST(Accuracy, Log) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(linear_grid<T>(0.5, 2));
  grids.push_back(linear_grid<T>(0.999, 1.001));
  expect_ulp<T>([](auto x) { return log(x); }, [](long double x) { return std::log(x); }, grids, 1);
}

TYPED_TEST(Accuracy, Log1p) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(linear_grid<T>(-1, 1.5));
  grids.push_back(linear_grid<T>(-0.3, 0.5));
  expect_ulp<T>([](auto x) { return log1p(x); }, [](long double x) { return std::log1p(x); }, grids,
                2);
}

TYPED_TEST(Accuracy, Sin) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(linear_grid<T>(-1e5, 1e5));
  grids.push_back(linear_grid<T>(-1e9, 1e9));
  expect_ulp<T>([](auto x) { return sincos(x).sin; }, [](long double x) { return std::sin(x); },
                grids, 2);
}

TYPED_TEST(Accuracy, Cos) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(linear_grid<T>(-1e5, 1e5));
  grids.push_back(linear_grid<T>(-1e9, 1e9));
  expect_ulp<T>([](auto x) { return sincos(x).cos; }, [](long double x) { return std::cos(x); },
                grids, 2);
}

/// The doubles nearest to the multiples of pi/2, where reduction cancels most.
TYPED_TEST(Accuracy, SinCosNextToMultiplesOfHalfPi) {
  using T = TypeParam;
  std::vector<T> x;
  const long double half_pi = std::acos(0.0L);
  for (int i = 0; i < kPoints; ++i) x.push_back(static_cast<T>(half_pi * i));
  expect_ulp<T>([](auto v) { return sincos(v).sin; }, [](long double v) { return std::sin(v); },
                {x}, 2);
  expect_ulp<T>([](auto v) { return sincos(v).cos; }, [](long double v) { return std::cos(v); },
                {x}, 2);
}

TYPED_TEST(Accuracy, Tanh) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(linear_grid<T>(-0.7, 0.7));
  grids.push_back(linear_grid<T>(-30, 30));
  expect_ulp<T>([](auto x) { return tanh(x); }, [](long double x) { return std::tanh(x); }, grids,
                3);
}

TYPED_TEST(Accuracy, Softplus) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(kDouble<T> ? linear_grid<T>(-746, 50) : linear_grid<T>(-104, 20));
  expect_ulp<T>(
      [](auto x) { return softplus(x); },
      [](long double x) { return std::max(x, 0.0L) + std::log1p(std::exp(-std::fabs(x))); }, grids,
      3);
}

TYPED_TEST(Accuracy, Mish) {
  using T = TypeParam;
  // below it e^x is subnormal
  const T low = kDouble<T> ? 708 : 87;
  Grids<T> grids = {bit_grid<T>(0, kMax<T>), bit_grid<T>(0, low, -1), linear_grid<T>(-8, 8),
                    linear_grid<T>(-low, 30)};
  expect_ulp<T>([](auto x) { return mish(x); },
                [](long double x) { return x * std::tanh(std::log1p(std::exp(x))); }, grids, 5);
}

TYPED_TEST(Accuracy, Phi1) {
  using T = TypeParam;
  auto grids = everywhere<T>();
  grids.push_back(kDouble<T> ? linear_grid<T>(-746, 717) : linear_grid<T>(-104, 94));
  grids.push_back(linear_grid<T>(-1, 1));
  expect_ulp<T>([](auto x) { return phi1(x); },
                [](long double x) { return x == 0 ? 1 : std::expm1(x) / x; }, grids, 3);
}

TYPED_TEST(Accuracy, Pow) {
  using T = TypeParam;
  struct Case {
    T y;
    double bound;
  };
  // The last: |y log x| <= 122, so 1 + 122 / 4.
  for (const auto [y, bound] : {Case{T(0.8), 2}, Case{T(-1.5), 2}, Case{T(300.7), 31.5}}) {
    expect_ulp<T>(
        [power = y](auto x) { return pow(x, power); },
        [power = y](long double x) { return std::pow(x, static_cast<long double>(power)); },
        {bit_grid<T>(0, kMax<T>), linear_grid<T>(0.7, 1.5)}, bound);
  }
}

/// Below -708 (-87) e^x is subnormal and has few digits left.
TYPED_TEST(Accuracy, MishOfVeryNegativeIsAbsolute) {
  using T = TypeParam;
  const double low = kDouble<T> ? -760 : -110, high = kDouble<T> ? -708 : -87;
  for (const T x : linear_grid<T>(low, high)) {
    const long double exact = static_cast<long double>(x) * std::exp(static_cast<long double>(x));
    ASSERT_LE(std::fabs(mish(x) - exact), kDouble<T> ? 2e-320L : 1e-42L) << x;
  }
}

}  // namespace
}  // namespace fricid
