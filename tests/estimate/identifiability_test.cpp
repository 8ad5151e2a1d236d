#include "fricid/estimate/rigid_body/identifiability.hpp"

#include <gmock/gmock.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "arm_data.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/estimate/fit.hpp"
#include "temporary_folder.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;

static_assert(name_of(Verdict::kNot) == "not identifiable");

data::Dataset noisy(data::Dataset log, double torque_sd, double encoder_sd, std::uint64_t seed) {
  Rng rng(seed, 7);
  for (Eigen::Index k = 0; k < log.q.rows(); ++k)
    for (Eigen::Index j = 0; j < log.q.cols(); ++j) {
      log.q(k, j) += encoder_sd * rng.normal();
      log.tau(k, j) += torque_sd * rng.normal();
    }
  return log;
}

Identifiability examine(const dynamics::RobotModel& robot, const std::vector<data::Dataset>& logs) {
  std::vector<signals::Recording> recordings;
  for (const data::Dataset& log : logs) recordings.push_back(signals::make_recording(log, 10));
  return examine_data(robot, recordings, {});
}

const ParameterVerdict& find(const Identifiability& report, const std::string& name) {
  for (const ParameterVerdict& v : report.parameters)
    if (v.name == name) return v;
  throw std::runtime_error("no parameter " + name);
}

// What a joint that stands leaves unknown is nothing of the others.
TEST(Identifiability, AJointThatStandsLeavesTheOthersKnown) {
  const Arm arm = coulomb_arm(5e-3);
  const auto n = static_cast<std::size_t>(arm.robot.n());
  data::Dataset log = make_log(arm, {.seconds = 24});
  const double w = 2 * std::numbers::pi / 6;
  dynamics::Workspace<double> ws(arm.robot);
  std::vector<double> q(n), v(n), a(n), tau(n);
  for (int k = 0; k < log.length(); ++k) {
    for (std::size_t j = 1; j < n; ++j) {  // the first stands
      q[j] = v[j] = a[j] = 0;
      for (const double m : {1.0, 2.0, 3.0}) {
        const double f = m * w, phase = f * log.t[k] + 2 * static_cast<double>(j) * m;
        q[j] += 0.3 * std::sin(phase);
        v[j] += 0.3 * f * std::cos(phase);
        a[j] -= 0.3 * f * f * std::sin(phase);
      }
    }
    dynamics::rnea<double>(arm.robot, ws,
                           {arm.robot.pi.data(), static_cast<std::size_t>(arm.robot.pi.size())}, q,
                           v, a, tau);
    for (std::size_t j = 0; j < n; ++j) {
      log.q(k, static_cast<Eigen::Index>(j)) = q[j];
      log.tau(k, static_cast<Eigen::Index>(j)) = tau[j] + 2 * (v[j] > 0 ? 1 : -1) + v[j];
    }
    log.tau(k, 0) = tau[0];
  }
  const Identifiability report = examine(arm.robot, {noisy(log, 0.02, 1e-5, 3)});
  for (const char* name : {"j2", "j3"})
    for (const char* kind : {" Coulomb friction", " viscous friction"})
      EXPECT_EQ(find(report, std::string(name) + kind).verdict, Verdict::kIdentified)
          << name << kind;
  const auto identified =
      std::ranges::count(report.parameters, Verdict::kIdentified, &ParameterVerdict::verdict);
  EXPECT_GE(identified, 10);
  for (const ParameterVerdict& verdict : report.parameters)
    EXPECT_FALSE(std::isnan(verdict.standard_error) && verdict.name.starts_with("j3"))
        << verdict.name;
}

// Oracle: the spread of the estimates over 50 draws of the sensors' noise on one motion.
// Predictions scatter as well, by the few blocks of a log: their mean square is judged.
TEST(Identifiability, PredictedErrorsAreTheSpreadOverSeeds) {
  constexpr int kSeeds = 50;
  const Arm arm = coulomb_arm();
  std::vector<data::Dataset> clean(2);
  parallel_for(2, 2, [&](int i) {
    clean[static_cast<std::size_t>(i)] =
        make_log(arm, {.substeps = 80, .seed = 100 + static_cast<std::uint64_t>(i)});
  });
  std::vector<Identifiability> reports(kSeeds);
  parallel_for(kSeeds, 2, [&](int s) {
    std::vector<data::Dataset> logs;
    for (std::size_t i = 0; i < clean.size(); ++i)
      logs.push_back(noisy(clean[i], 0.5, 4e-6, 1000 * i + static_cast<std::uint64_t>(s)));
    reports[static_cast<std::size_t>(s)] = examine(arm.robot, logs);
  });

  int identified = 0, agree = 0;
  for (std::size_t i = 0; i < reports[0].parameters.size(); ++i) {
    if (reports[0].parameters[i].verdict != Verdict::kIdentified) continue;
    double sum = 0, squares = 0, predicted = 0;
    for (const Identifiability& report : reports) {
      sum += report.parameters[i].value;
      squares += report.parameters[i].value * report.parameters[i].value;
      predicted += std::pow(report.parameters[i].standard_error, 2) / kSeeds;
    }
    const double mean = sum / kSeeds;
    const double spread = std::sqrt((squares - kSeeds * mean * mean) / (kSeeds - 1));
    const double ratio = spread / std::sqrt(predicted);
    ++identified;
    const bool good = ratio > 1 / 1.5 && ratio < 1.5;
    if (good) ++agree;
    if (!good)
      ADD_FAILURE() << reports[0].parameters[i].name << ": spread over prediction " << ratio;
  }
  EXPECT_GE(identified, 14);
  EXPECT_GE(agree, 0.95 * identified);
}

// Claim: what the motion does not excite is said, and with what it is confused.
TEST(Identifiability, AJointThatRestsTellsNothing) {
  const Arm arm = coulomb_arm();
  data::Dataset log = noisy(make_log(arm, {}), 0.5, 4e-6, 1);
  const Identifiability moving = examine(arm.robot, {log});
  EXPECT_EQ(find(moving, "j3 Coulomb friction").verdict, Verdict::kIdentified);

  log.q.col(2).setConstant(0.3);
  const Identifiability resting = examine(arm.robot, {log});
  for (const ParameterVerdict& v : resting.parameters) EXPECT_NE(v.name, "j3 Coulomb friction");
  int lost = 0;
  for (const ParameterVerdict& v : resting.parameters) {
    if (v.verdict != Verdict::kNot) continue;
    ++lost;
    EXPECT_NE(v.words, "") << v.name;
  }
  EXPECT_GE(lost, 3);
  const FamilyVerdict& family = resting.families[0];
  EXPECT_EQ(family.family, "coulomb_viscous, viscous, viscous_power");
  EXPECT_FALSE(family.supported);
  EXPECT_THAT(family.words, HasSubstr("j3"));
  EXPECT_TRUE(moving.families[0].supported) << moving.families[0].words;
}

// Slow motion makes no torque of inertias: what is off by more than the links have is not
// identified, however little torque it makes.
TEST(Identifiability, InertiaOfSlowMotionIsUnknown) {
  const Arm arm = coulomb_arm();
  const data::Dataset log = noisy(make_log(arm, {.seconds = 40, .peak_speed = 0.1}), 0.02, 4e-6, 1);
  for (const ParameterVerdict& v : examine(arm.robot, {log}).parameters)
    if (v.verdict == Verdict::kIdentified && v.name.find(" I") != std::string::npos) {
      EXPECT_LT(v.standard_error, 0.3) << v.name;  // [kg m^2], of links with .01 to .2
    }
}

// "4.000 +- 0.001": a value has the digits that its error leaves.
TEST(Identifiability, ValuesHaveTheDigitsThatTheirErrorsLeave) {
  const Arm arm = coulomb_arm();
  const data::Dataset log = noisy(make_log(arm, {.seconds = 40}), 0.02, 4e-6, 1);
  const Identifiability report = examine(arm.robot, {log});
  const ParameterVerdict Fc = find(report, "j1 Coulomb friction");
  const auto decimals = static_cast<int>(-std::floor(std::log10(Fc.standard_error)));
  ASSERT_GE(decimals, 3);
  EXPECT_THAT(to_summary(report, arm.robot),
              HasSubstr(fmt::format("{:.{}f} +-", Fc.value, decimals)));
}

// In the range of the Stribeck effect friction falls with the speed: that is no viscous friction.
TEST(Identifiability, NegativeViscousFrictionIsNone) {
  Arm arm = coulomb_arm();
  arm.friction = same_law("stribeck", {4, 8, 0.1, 0.5, 5e-3}, arm.robot.n());
  const data::Dataset log = noisy(make_log(arm, {.seconds = 40, .peak_speed = 0.1}), 0.05, 4e-6, 1);
  const ParameterVerdict found = find(examine(arm.robot, {log}), "j1 viscous friction");
  EXPECT_LT(found.value, 0);
  EXPECT_EQ(found.verdict, Verdict::kNot);
  EXPECT_THAT(found.words, HasSubstr("negative"));
}

// Friction that lags behind the speed looks like a negative inertia, which a fit does not believe.
TEST(Identifiability, AJointWhoseTorqueShowsNoInertiaIsNamed) {
  const Arm arm = coulomb_arm();
  data::Dataset log = make_log(arm, {});
  EXPECT_TRUE(examine(arm.robot, {log}).without_inertia.empty());

  const double armature = arm.robot.pi[arm.robot.armature_begin() + 2];
  log.tau.col(2) -= 3 * armature * signals::make_recording(log, 10).narrow.a.col(2);
  const Identifiability lagging = examine(arm.robot, {log});
  ASSERT_EQ(lagging.without_inertia.size(), 1U);
  EXPECT_EQ(lagging.without_inertia[0].joint, 2);
  EXPECT_THAT(to_summary(lagging, arm.robot),
              HasSubstr("no inertia in the torque of j3: a fit holds the armature\n"));
  EXPECT_EQ(checked(lagging, arm.robot).without_inertia, std::vector<std::string>{"j3"});
}

// Every law and modifier that demands anything of the data is named once, in the family of its
// demands, and what its parameters' roles demand is what is found lacking.
TEST(Identifiability, FamiliesFollowFromTheRolesOfTheLaws) {
  const Arm arm = coulomb_arm();
  data::Dataset log = noisy(make_log(arm, {}), 0.5, 4e-6, 1);
  log.q.col(2).setConstant(0.3);             // lacks everything
  std::map<std::string, std::string> words;  // by law or modifier
  for (const FamilyVerdict& f : examine(arm.robot, {log}).families) {
    std::string_view names(f.family);
    const std::string_view mark = " (modifier)";
    if (names.ends_with(mark)) names.remove_suffix(mark.size());
    for (std::size_t end; !names.empty(); names.remove_prefix(std::min(names.size(), end + 2))) {
      end = std::min(names.find(", "), names.size());
      EXPECT_TRUE(words.emplace(names.substr(0, end), f.words).second) << f.family;
    }
  }
  for (const friction::LawInfo& law : friction::law_table()) {
    const auto parameters = friction::parameters_of_law(law.name, 1);
    if (parameters.empty()) continue;
    ASSERT_TRUE(words.contains(std::string(law.name))) << law.name;
    const std::string& found = words[std::string(law.name)];
    const auto has = [&](friction::Role role) {
      return std::ranges::count(parameters, role, &friction::ParameterInfo::role) > 0;
    };
    EXPECT_THAT(found, HasSubstr("speeds up to")) << law.name;
    const bool presliding = has(friction::Role::kStiffness) || has(friction::Role::kLength) ||
                            has(friction::Role::kWeight);
    EXPECT_EQ(found.find("in presliding after") != std::string::npos, presliding) << law.name;
    EXPECT_EQ(found.find("needed") != std::string::npos, has(friction::Role::kWeight)) << law.name;
  }
  EXPECT_THAT(words["temperature"], HasSubstr("warming"));
  EXPECT_EQ(words["temperature"], words["viscosity"]);
}

// Motion without slow stretches: a rule has no use for laws with a memory, held-out torque has.
TEST(Identifiability, AMemoryThatHeldOutTorqueShowsCanBeFitted) {
  const auto dahl = [](const Arm& arm) {
    LogOptions fast;
    fast.peak_speed = 8;
    const data::Dataset log = noisy(make_log(arm, fast), 0.1, 4e-6, 1);
    for (const FamilyVerdict& f : examine(arm.robot, {log}).families)
      if (f.family.find("dahl") != std::string::npos) return f;
    return FamilyVerdict{};
  };
  Arm bristles = coulomb_arm();
  bristles.friction = same_law("dahl", {4, 100, 2}, bristles.robot.n());
  const FamilyVerdict seen = dahl(bristles), unseen = dahl(coulomb_arm());
  EXPECT_THAT(seen.words, HasSubstr("half a second below the Stribeck speed lacking"));
  EXPECT_TRUE(seen.supported) << seen.words;
  EXPECT_THAT(seen.words, HasSubstr("held-out torque shows a memory"));
  EXPECT_FALSE(unseen.supported) << unseen.words;
}

// Claim: what the check calls not identifiable, a fit to the same data reports without a
// confidence, but for one under a prior, which says what the data do not.
TEST(Identifiability, AFitHasNoConfidenceInWhatTheCheckRefuses) {
  const Arm arm = coulomb_arm();
  ModelOptions config;
  config.name = "simple";
  const OwnFolder folder;
  const auto path = folder.path() / "fit.json";
  int refused = 0, told = 0;
  for (const bool rests : {false, true}) {
    data::Dataset log = noisy(make_log(arm, {}), 0.5, 4e-6, 1);
    if (rests) log.q.col(2).setConstant(0.3);
    const std::vector<data::Dataset> logs{log};
    const Identifiability check = examine(arm.robot, logs);
    data::save(fit_file(fit_conventional(prepare(arm.robot, {}, logs, 2), config, 1, 2)), path);
    const auto fit = data::load<data::FitFile>(path);
    for (const data::FittedBaseParameter& parameter : fit.rigid_body.base) {
      const std::string& name = parameter.name;
      if (name.ends_with(" 1")) continue;  // the constant torque: the check counts it as friction
      const bool has_error = std::isfinite(parameter.standard_error);
      const bool unknown = find(check, name).verdict == Verdict::kNot;
      EXPECT_FALSE(unknown && has_error && fit.rigid_body.prior.empty()) << name;
      refused += unknown;
      told += has_error;
    }
  }
  std::filesystem::remove(path);
  EXPECT_GE(refused, 3);
  EXPECT_GE(told, 3);
}

// A vertical sliding joint cannot tell mass and armature from a constant torque.
TEST(Identifiability, ErrorsAreThoseOfAFit) {
  Arm arm = coulomb_arm();
  arm.robot.joints[0].type = dynamics::JointType::kPrismatic;
  const std::vector<data::Dataset> logs{noisy(make_log(arm, {}), 0.5, 4e-6, 1)};
  const Identifiability check = examine(arm.robot, logs);
  const Prepared fit = prepare(arm.robot, {}, logs, 1);
  ASSERT_EQ(fit.rigid_body.prior, "");
  for (int j = 0; j < 3; ++j) {
    const std::string& joint = arm.robot.joints[static_cast<std::size_t>(j)].name;
    for (const auto& [name, error] : {std::pair{" Coulomb friction", fit.rigid_body.Fc_se[j]},
                                      {" viscous friction", fit.rigid_body.Fv_se[j]}})
      EXPECT_NEAR(find(check, joint + name).standard_error, error, 1e-6 * error) << joint << name;
  }
  int alike = 0;
  for (std::size_t i = 0; i < fit.rigid_body.base_names.size(); ++i)
    for (const ParameterVerdict& v : check.parameters)
      if (v.name == fit.rigid_body.base_names[i]) {
        const double error = fit.rigid_body.base_se[static_cast<Eigen::Index>(i)];
        EXPECT_NEAR(v.standard_error, error, 1e-6 * error) << v.name;
        ++alike;
      }
  EXPECT_GE(alike, 5);
}

TEST(Identifiability, SlidingJointsAreSlower) {
  Arm arm = coulomb_arm();
  const std::vector<data::Dataset> logs{make_log(arm, {.peak_speed = 0.1})};
  EXPECT_THAT(examine(arm.robot, logs).families[0].words, HasSubstr("lacking on j1"));
  arm.robot.joints[0].type = dynamics::JointType::kPrismatic;
  EXPECT_THAT(examine(arm.robot, logs).families[0].words, testing::Not(HasSubstr("lacking on j1")));
}

// Oracle: a link that turns about a vertical axis shows its inertia about it and nothing else.
TEST(Identifiability, NamesTheCombinationAParameterHidesIn) {
  const Arm arm = coulomb_arm();
  const Identifiability report = examine(arm.robot, {make_log(arm, {})});
  const auto words = [&](const std::string& name) {
    for (const Grouping& g : report.groupings)
      if (g.name == name) return g.words;
    return std::string();
  };
  EXPECT_EQ(words("j1 m"), "no effect on any torque of this robot");
  EXPECT_THAT(words("j2 m"), HasSubstr("only within j1 Izz"));
  const std::string text = to_text(report, arm.robot);
  EXPECT_THAT(text, HasSubstr("friction: j1: up to"));

  const data::CheckedIdentifiability file = checked(report, arm.robot);
  ASSERT_EQ(file.parameters.size(), report.parameters.size());
  const ParameterVerdict& first = report.parameters.front();
  EXPECT_EQ(file.parameters.front().verdict, name_of(first.verdict));
  EXPECT_DOUBLE_EQ(file.parameters.front().percent, 100 * first.standard_error / first.size);
  ASSERT_EQ(file.joints.size(), 3U);
  EXPECT_EQ(file.joints[0].joint, "j1");
  EXPECT_EQ(file.joints[0].load,
            (std::vector<double>{report.joints[0].load_low, report.joints[0].load_high}));
  EXPECT_TRUE(file.joints[0].temperature.empty());  // not measured
  EXPECT_EQ(file.groupings.size(), report.groupings.size());
  EXPECT_EQ(file.families.size(), report.families.size());
}

// Oracle: cosine motion, A sin(w t): 2 reversals per period, speed A w.
TEST(Identifiability, CountsReversalsAndSlowTime) {
  const Arm arm = coulomb_arm();
  data::Dataset log = make_log(arm, {});
  for (int j = 0; j < 3; ++j)
    for (int k = 0; k < log.length(); ++k)
      log.q(k, j) = (j == 2 ? 5e-4 : 0.5) * std::sin(2 * std::numbers::pi * log.t[k] / 2);
  const Identifiability report = examine(arm.robot, {log});
  EXPECT_EQ(report.joints[0].reversals, 12);
  EXPECT_NEAR(report.joints[0].fastest, 0.5 * std::numbers::pi, 0.02);
  // |cos| < 0.05 / (0.5 pi) in a share 2 asin(.) / pi of the time
  EXPECT_NEAR(report.joints[0].slow_s, 12 * 2 / std::numbers::pi * 0.0318, 0.06);
  EXPECT_EQ(report.joints[2].reversals, 0);
  EXPECT_EQ(report.joints[2].presliding, 12);
}

TEST(Identifiability, SlidingJointsHaveUnitsOfTheirOwn) {
  Arm arm = coulomb_arm();
  const Identifiability report = examine(arm.robot, {make_log(arm, {})});
  for (const std::string& text : {to_summary(report, arm.robot), to_text(report, arm.robot)})
    EXPECT_THAT(text, testing::Not(testing::HasSubstr("m/s")));
  arm.robot.joints[2].type = dynamics::JointType::kPrismatic;
  const std::string joint = arm.robot.joints[2].name;
  EXPECT_THAT(to_summary(report, arm.robot),
              testing::ContainsRegex("\n" + joint + " [^\n]*\\(m/s, N, N s/m\\)\n"));
  EXPECT_THAT(to_text(report, arm.robot),
              testing::ContainsRegex("friction: " + joint + ": up to [^\n]* m/s, [^\n]* N,"));
}

// Samples that are missing are neither slow motion nor seconds of data.
TEST(Identifiability, APauseThatIsMissingIsNoMotion) {
  const Arm arm = coulomb_arm();
  data::Dataset log = make_log(arm, {.seconds = 40});
  const Identifiability whole = examine(arm.robot, {log});
  for (RowMatrix* signal : {&log.q, &log.tau})
    signal->middleRows(2500, 5000).setConstant(std::nan(""));
  const Identifiability holed = examine(arm.robot, {log});
  for (std::size_t j = 0; j < whole.joints.size(); ++j) {
    EXPECT_LT(holed.joints[j].slow_s, whole.joints[j].slow_s);
    EXPECT_LT(holed.joints[j].reversals, whole.joints[j].reversals);
    EXPECT_LE(holed.joints[j].presliding, whole.joints[j].presliding);
  }
  const auto networks = [](const Identifiability& report) {
    return std::ranges::find_if(report.families,
                                [](const FamilyVerdict& f) {
                                  return f.family.find("memory_network") != std::string::npos;
                                })
        ->words;
  };
  EXPECT_THAT(networks(whole), testing::Not(HasSubstr("s of data")));
  EXPECT_THAT(networks(holed), HasSubstr("20 s of data, 30 s or more needed"));
}

// A second of held-out motion tells nothing: of a log of six seconds each half is predicted.
TEST(Identifiability, AMemoryIsSeenInALogOfSixSeconds) {
  Arm arm = coulomb_arm();
  EXPECT_FALSE(examine(arm.robot, {make_log(arm, {.seconds = 6.4})}).joints[0].memory);
  arm.friction = same_law("dahl", {4, 500, 2}, arm.robot.n());
  EXPECT_TRUE(examine(arm.robot, {make_log(arm, {.seconds = 6.4})}).joints[0].memory);
}

TEST(Identifiability, BaseInformationIsTheIntegralOfTheSquaredRegressor) {
  const Arm arm = coulomb_arm();
  const std::vector<signals::Recording> one{signals::make_recording(make_log(arm, {}), 10)};
  const std::vector<signals::Recording> two{one[0], one[0]};
  const Eigen::MatrixXd H = base_information(arm.robot, one, 10);
  EXPECT_NEAR((base_information(arm.robot, two, 10) - 2 * H).norm() / H.norm(), 0, 1e-12);
  EXPECT_NEAR((H - H.transpose()).norm() / H.norm(), 0, 1e-12);
}

}  // namespace
}  // namespace fricid::estimate
