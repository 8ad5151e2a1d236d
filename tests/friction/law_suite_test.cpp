// The law suite: every law of the table and every composition keeps what it claims.
#include "gradient_checks.hpp"
#include "law_checks.hpp"

namespace fricid::friction::test {
namespace {

#define FOR_EACH_SUBJECT(check)              \
  for_each_subject([](const auto& subject) { \
    SCOPED_TRACE(subject.name);              \
    check;                                   \
  })

TEST(LawSuite, OddWhereClaimed) { FOR_EACH_SUBJECT(check_odd(subject)); }
TEST(LawSuite, StateIsBoundedAndContracts) {
  FOR_EACH_SUBJECT(check_bound_and_contraction(subject));
}
TEST(LawSuite, NoEnergyComesOut) { FOR_EACH_SUBJECT(check_dissipates(subject)); }
TEST(LawSuite, TwoHalfStepsAreOne) { FOR_EACH_SUBJECT(check_semigroup(subject)); }
TEST(LawSuite, SteadyTorqueIsTheLimit) { FOR_EACH_SUBJECT(check_steady_state(subject)); }
TEST(LawSuite, ZeroStepAndZeroSpeedKeepTheState) { FOR_EACH_SUBJECT(check_stuck(subject)); }
TEST(LawSuite, FiniteAtTheExtremes) { FOR_EACH_SUBJECT(check_extremes<PackD>(subject)); }
TEST(LawSuite, FiniteAtTheExtremesInSinglePrecision) {
  FOR_EACH_SUBJECT(check_extremes<PackF>(subject));
}
TEST(LawSuite, LaneEqualsScalarToTheLastBit) { FOR_EACH_SUBJECT(check_lanes(subject)); }
TEST(LawSuite, SinglePrecisionIsClose) { FOR_EACH_SUBJECT(check_single_precision(subject)); }
TEST(LawSuite, PullbackEqualsDualNumbers) {
  FOR_EACH_SUBJECT(check_pullback_against_dual(subject));
}
TEST(LawSuite, PullbackEqualsCentralDifferences) {
  FOR_EACH_SUBJECT(check_pullback_against_differences(subject));
}

TEST(LawSuite, HysteresisIsBoundedAndContractsForAMillionInputs) {
  constexpr int kInputs = 1000000;
  check_bound_and_contraction(LawSubject(Dahl{}), kInputs);
  check_bound_and_contraction(LawSubject(LuGre{}), kInputs);
  check_bound_and_contraction(LawSubject(Gms(4)), kInputs);
  check_bound_and_contraction(LawSubject(MaxwellSlip(4)), kInputs);
}

}  // namespace
}  // namespace fricid::friction::test
