#include "fricid/estimate/remarks.hpp"

#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "fricid/base/not_finite.hpp"

namespace fricid::estimate {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// Two joints with LuGre friction that nothing can be said against.
struct Fitted {
  friction::RobotFriction friction{std::vector(2, friction::JointSpec{{{"lugre", 0, {}}}})};
  std::vector<data::FittedJoint> joints;

  Fitted() {
    for (const char* name : {"shoulder", "elbow"}) {
      data::FittedJoint& joint = joints.emplace_back();
      joint.joint = name;
      joint.parameters = {{"Fc", 4, 0.1, 0.01},    {"Fs", 5, 0.1, 0.01},
                          {"vs", 0.1, 0.01, 0.01}, {"sigma0", 4000, 900, 900},
                          {"sigma1", 5, kNan, {}}, {"sigma2", 2, 0.1, 0.01}};
    }
  }
  std::vector<data::FittedRemark> remarks() const { return remarks_on(joints, friction); }
};

TEST(Remarks, NoneOnAGoodFit) { EXPECT_THAT(Fitted().remarks(), IsEmpty()); }

TEST(Remarks, StiffnessThatTheMotionDoesNotResolve) {
  Fitted fitted;
  fitted.joints[1].parameters[3].motion_error = 1600;
  const auto remarks = fitted.remarks();
  ASSERT_THAT(remarks, SizeIs(1));
  EXPECT_THAT(remarks[0].found, HasSubstr("sigma0 of elbow by 40 %"));
  EXPECT_THAT(remarks[0].found, Not(HasSubstr("shoulder")));
  EXPECT_THAT(remarks[0].remedy, HasSubstr("log at a higher rate"));
}

TEST(Remarks, StaticFrictionFarBelowThatOfSliding) {
  Fitted fitted;
  fitted.joints[0].parameters[1].value = 1.9;
  const auto remarks = fitted.remarks();
  ASSERT_THAT(remarks, SizeIs(1));
  EXPECT_THAT(remarks[0].found, HasSubstr("shoulder (Fs 1.9 of 4)"));
  EXPECT_THAT(remarks[0].meaning, HasSubstr("no break-away torque"));
}

TEST(Remarks, AStribeckTorqueBesideTheLawIsStaticFrictionToo) {
  Fitted fitted;
  std::vector<friction::JointSpec> specs = fitted.friction.joints();
  for (friction::JointSpec& spec : specs) spec.laws.push_back({"stribeck_peak", 0, {}});
  fitted.friction = friction::RobotFriction(std::move(specs));
  for (data::FittedJoint& joint : fitted.joints)
    for (const char* symbol : {"Ts", "vs", "v0"})
      joint.parameters.push_back({symbol, symbol == std::string("Ts") ? 1.0 : 0.1, 0.01, 0.01});
  fitted.joints[0].parameters[1].value = 1.5;
  EXPECT_THAT(fitted.remarks(), IsEmpty());
  fitted.joints[0].parameters[1].value = 0.5;
  EXPECT_THAT(fitted.remarks(), SizeIs(1));
}

TEST(Remarks, BreakAwayThatFallsWithinTheLeastSpeed) {
  Fitted fitted;
  fitted.joints[0].parameters[2].value = 0.02;
  fitted.joints[0].at_bound = {"vs"};
  const auto remarks = fitted.remarks();
  ASSERT_THAT(remarks, SizeIs(1));
  EXPECT_THAT(remarks[0].found, HasSubstr("Fs of shoulder (vs on its least, 0.02 rad/s)"));
  fitted.joints[0].parameters[1].value = 4.1;  // it hardly falls
  EXPECT_THAT(fitted.remarks(), IsEmpty());
}

TEST(Remarks, StaticFrictionThatIsAGuess) {
  Fitted fitted;
  fitted.joints[0].guessed = {"Fs"};
  const auto remarks = fitted.remarks();
  ASSERT_THAT(remarks, SizeIs(1));
  EXPECT_THAT(remarks[0].found, HasSubstr("static friction is not seen: Fs of shoulder ("));
}

TEST(Remarks, TorqueThatBendsWithTheTorque) {
  const Fitted fitted;
  const std::vector<TorqueBend> bends{{.at_largest = 0.042, .share = 0.57},
                                      {.at_largest = 0.05, .share = 0.3}};
  const auto remarks = remarks_on(fitted.joints, fitted.friction, {}, bends);
  ASSERT_THAT(remarks, SizeIs(1));
  EXPECT_THAT(remarks[0].found, HasSubstr("shoulder (57 % by +4.2 % at the largest torque)"));
}

TEST(Remarks, TorqueThatGoesWithThePosition) {
  const Fitted fitted;
  std::vector<PositionWave> waves{{.n = 6, .share = 0.35}, {.n = 2, .share = 0.1}};
  const auto remarks = remarks_on(fitted.joints, fitted.friction, waves);
  ASSERT_THAT(remarks, SizeIs(1));
  EXPECT_THAT(remarks[0].found, HasSubstr("shoulder (35 % by 6 periods per turn)"));
  waves[0] = {.n = 314.159, .share = 0.35, .slides = true};
  EXPECT_THAT(remarks_on(fitted.joints, fitted.friction, waves)[0].found,
              HasSubstr("shoulder (35 % by waves of 20 mm, N = 314.2)"));
  EXPECT_THAT(remarks[0].found, Not(HasSubstr("elbow")));
}

}  // namespace
}  // namespace fricid::estimate
