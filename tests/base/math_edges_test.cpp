// Limits, signed zeros, infinities and NaN of the elementary functions, against <cmath>.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "fricid/base/math.hpp"

namespace fricid {
namespace {

template <class S>
using ScalarOf = decltype(lane(S(), 0));

template <class S>
class Edges : public ::testing::Test {
 protected:
  using T = ScalarOf<S>;
  using Limits = std::numeric_limits<T>;

  static std::vector<T> arguments() {
    return {T(0),
            T(-0.0),
            Limits::infinity(),
            -Limits::infinity(),
            Limits::quiet_NaN(),
            Limits::denorm_min(),
            -Limits::denorm_min(),
            Limits::min(),
            -Limits::min(),
            Limits::max(),
            -Limits::max(),
            T(1),
            T(-1)};
  }

  /// Every lane has the sign, the class and (to 4 ulp) the value that <cmath> finds.
  template <class Function, class Oracle>
  static void expect_as(Function function, Oracle oracle) {
    for (const T x : arguments()) {
      const S y = function(S(x));
      const T expected = oracle(x);
      for (int i = 0; i < kLaneCount<S>; ++i) {
        if (std::isnan(expected)) {
          EXPECT_TRUE(std::isnan(lane(y, i))) << x;
        } else if (std::isinf(expected) || expected == 0) {
          EXPECT_EQ(to_bits(lane(y, i)), to_bits(expected)) << x << ": " << lane(y, i);
        } else {
          EXPECT_NEAR(lane(y, i) / expected, 1, 4 * Limits::epsilon()) << x;
        }
      }
    }
  }
};
using Scalars = ::testing::Types<double, float, PackD, PackF, Pack<double, 2>, Pack<float, 4>>;
TYPED_TEST_SUITE(Edges, Scalars);

TYPED_TEST(Edges, Exp) {
  this->expect_as([](auto x) { return exp(x); }, [](auto x) { return std::exp(x); });
}
TYPED_TEST(Edges, Expm1) {
  this->expect_as([](auto x) { return expm1(x); }, [](auto x) { return std::expm1(x); });
}
TYPED_TEST(Edges, Log) {
  this->expect_as([](auto x) { return log(x); }, [](auto x) { return std::log(x); });
}
TYPED_TEST(Edges, Log1p) {
  this->expect_as([](auto x) { return log1p(x); }, [](auto x) { return std::log1p(x); });
}
TYPED_TEST(Edges, Sin) {
  this->expect_as([](auto x) { return sincos(x).sin; }, [](auto x) { return std::sin(x); });
}
TYPED_TEST(Edges, Cos) {
  this->expect_as([](auto x) { return sincos(x).cos; }, [](auto x) { return std::cos(x); });
}
TYPED_TEST(Edges, Tanh) {
  this->expect_as([](auto x) { return tanh(x); }, [](auto x) { return std::tanh(x); });
}

TYPED_TEST(Edges, Softplus) {
  this->expect_as(
      [](auto x) { return softplus(x); },
      [](auto x) { return std::fmax(x, decltype(x)(0)) + std::log1p(std::exp(-std::fabs(x))); });
}

TYPED_TEST(Edges, Mish) {
  // the product at -inf is -inf times 0, its limit -0
  this->expect_as([](auto x) { return mish(x); },
                  [](auto x) {
                    const auto y = x * std::tanh(std::log1p(std::exp(x)));
                    return std::isinf(x) && x < 0 ? decltype(x)(-0.0) : y;
                  });
}

TYPED_TEST(Edges, Phi1) {
  // at 0 and inf the quotient is 0/0 and inf/inf
  this->expect_as([](auto x) { return phi1(x); },
                  [](auto x) {
                    if (x == 0) return decltype(x)(1);
                    if (std::isinf(x) && x > 0) return x;
                    return std::expm1(x) / x;
                  });
}

TYPED_TEST(Edges, PowOfAnyBaseAndExponent) {
  using Real = ScalarOf<TypeParam>;
  for (const Real y : this->arguments()) {
    this->expect_as([y](auto x) { return pow(x, y); },
                    [y](Real x) {
                      // a negative base is refused, a negative zero counts as zero
                      if (x < 0 && y != 0) return std::numeric_limits<Real>::quiet_NaN();
                      return std::pow(std::fabs(x), y);
                    });
  }
}

/// NaN must not turn into a number on its way through a clamp or a select.
TYPED_TEST(Edges, NaNStaysNaN) {
  using S = TypeParam;
  const S nan(std::numeric_limits<ScalarOf<S>>::quiet_NaN());
  for (const S y :
       {exp(nan), expm1(nan), log(nan), log1p(nan), sincos(nan).sin, sincos(nan).cos, tanh(nan),
        softplus(nan), decay(nan), mish(nan), phi1(nan), pow(nan, S(2)), pow(S(2), nan)}) {
    for (int i = 0; i < kLaneCount<S>; ++i) EXPECT_TRUE(std::isnan(lane(y, i)));
  }
}

}  // namespace
}  // namespace fricid
