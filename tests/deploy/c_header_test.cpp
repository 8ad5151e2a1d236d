// The C99 header against the engine, for everything that the tables of laws have.
#include "fricid/deploy/c_header.hpp"

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/deploy/export.hpp"
#include "held_out.hpp"
#include "law_errors.hpp"
#include "temporary_folder.hpp"

namespace fricid::deploy::test {
namespace {

using testing::HasSubstr;
using testing::Not;

// Elementary functions of the C library and of the engine differ by an ulp or two; the steps
// contract, so that this does not grow.
constexpr double kBar = 1e-12, kSingleBar = 1e-5;

void expect_equal_to_engine(const std::string& compiler, const std::string& options, double bar) {
  const OwnFolder folder;
  const auto models = all_models();
  const auto errors = header_errors(models, motion(), kDt, compiler, options, folder.path());
  for (std::size_t i = 0; i < models.size(); ++i)
    EXPECT_LE(errors[i], bar) << models[i].name << " by " << compiler << " " << options;
}

TEST(CHeader, EveryLawAndModifierIsTheEngineWithEveryCompiler) {
  for (const std::string& compiler : c_compilers()) expect_equal_to_engine(compiler, "", kBar);
}

// A sample that is lost or overflows: of one joint, of the other, of both.
TEST(CHeader, KeepsStateAndTorqueWhereInputsAreNotFinite) {
  std::vector<friction::Input<double>> inputs = motion();
  const std::size_t n = 2;
  for (std::size_t k = 0; k < inputs.size() / n; ++k) {
    if (k % 40 < 3) inputs[k * n] = {kNan, kNan, kNan, kNan};
    if (k % 40 == 2 || k % 40 == 9)
      inputs[k * n + 1] = {kInfinity, -kInfinity, kInfinity, kInfinity};
  }
  const OwnFolder folder;
  const auto models = all_models();
  const auto errors = header_errors(models, inputs, kDt, c_compilers().front(), "", folder.path());
  for (std::size_t i = 0; i < models.size(); ++i) EXPECT_LE(errors[i], kBar) << models[i].name;
}

TEST(CHeader, FollowsHeldOutMotion) {
  for (const char* name : {"kr6_demo", "kr6_stickslip"}) {
    const HeldOut held = held_out(name);
    const OwnFolder folder;
    for (const auto& [options, bar] :
         {std::pair("", kBar), std::pair("-DFRICID_FLOAT", kSingleBar)})
      EXPECT_LE(header_errors({held.model}, inputs_of(held.truth.trace), held.truth.dt(),
                              c_compilers().front(), options, folder.path())[0],
                bar)
          << name << " " << options;
  }
}

TEST(CHeader, NeedsMathAloneAndNoHeap) {
  for (const data::ModelFile& model : all_models()) {
    const std::string header = c_header(model);
    EXPECT_THAT(header, HasSubstr("#include <math.h>")) << model.name;
    EXPECT_EQ(header.find("#include"), header.rfind("#include")) << model.name;
    EXPECT_THAT(header, Not(HasSubstr("alloc"))) << model.name;
  }
}

TEST(CHeader, SanitizersFindNothing) {
  const std::string sanitizers =
      "-O0 -fsanitize=undefined,float-divide-by-zero,float-cast-overflow -fno-sanitize-recover=all";
  expect_equal_to_engine(c_compilers().front(), sanitizers, kBar);
  expect_equal_to_engine(c_compilers().front(), sanitizers + " -DFRICID_FLOAT", kSingleBar);
}

TEST(CHeader, FloatCompilesAndFollows) {
  for (const std::string& compiler : c_compilers())
    expect_equal_to_engine(compiler, "-DFRICID_FLOAT", kSingleBar);
}

TEST(CHeader, SameModelSameBytes) {
  for (const data::ModelFile& model : all_models()) EXPECT_EQ(c_header(model), c_header(model));
}

TEST(CHeader, FrictionOfASlidingJointIsAForce) {
  data::ModelFile model = robot_with("lugre");
  EXPECT_THAT(c_header(model), Not(HasSubstr("Fc [N] ")));
  model.arm.robot.joints[0].type = dynamics::JointType::kPrismatic;
  add_linear_torque(model.arm.robot, {.name = "offset", .joint = 0}, 2);
  add_linear_torque(model.arm.robot, {.name = "other", .joint = 1}, 3);
  EXPECT_THAT(c_header(model), HasSubstr("Fc [N] "));
  EXPECT_THAT(c_header(model), HasSubstr("Fc [N m] "));
  EXPECT_THAT(export_model(model, "c").losses,
              testing::IsSupersetOf(
                  {HasSubstr("offset (2 N) is left out"), HasSubstr("other (3 N m) is left out")}));
}

TEST(Csv, NamesTheUnitsOfJointsThatSlide) {
  data::ModelFile model = robot_with("lugre");
  const auto lines_of = [&] { return export_model(model, "csv").files[0].text; };
  EXPECT_THAT(lines_of(), testing::StartsWith("joint,velocity_rad_s,friction_Nm\n"));
  for (dynamics::Joint& joint : model.arm.robot.joints) joint.name = "j";
  model.arm.robot.joints[0].type = dynamics::JointType::kPrismatic;
  EXPECT_THAT(lines_of(),
              testing::StartsWith(
                  "joint,velocity_rad_s,friction_Nm,velocity_m_s,friction_N\n\"j\",,,-3,-"));
  EXPECT_THAT(lines_of(), testing::ContainsRegex("\n\"j\",-3,-[0-9.]*,,\n"));
  model.arm.robot.joints[1].type = dynamics::JointType::kPrismatic;
  EXPECT_THAT(lines_of(), testing::StartsWith("joint,velocity_m_s,friction_N\n\"j\",-3,-"));
}

TEST(CHeader, NamesAreIdentifiers) {
  data::ModelFile model;
  model.name = "1-a.b";
  model.seed = 3;
  EXPECT_EQ(code_name(model), "m1_a_b_s3");
}

TEST(Export, UnknownFormatNamesTheKnown) {
  try {
    export_model(all_models()[0], "matlab");
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(),
                 "unknown format 'matlab'; allowed: c, csv, urdf, mjcf, "
                 "mjcf_friction, plugin, fmu, onnx");
  }
}

}  // namespace
}  // namespace fricid::deploy::test
