// Enums of a scene by their names.
#include <gmock/gmock.h>

#include "fricid/scene/problem.hpp"
#include "scene_folder.hpp"

namespace fricid::scene {
namespace {

using testing::HasSubstr;

// The last value of every enum has the last name: none is missing, none is one too many.
static_assert(name_of(Mount::kRpy) == "rpy");
static_assert(name_of(sim::ControlLaw::kCascade) == "cascade");
static_assert(name_of(sim::Criterion::kNone) == "none");
static_assert(name_of(sim::Drive::kMeasured) == "measured");
static_assert(name_of(estimate::Method::kEm) == "em");
static_assert(name_of(estimate::Optimiser::kGaussNewton) == "gauss_newton");
static_assert(name_of(estimate::EStep::kBootstrap) == "bootstrap");
static_assert(name_of(estimate::MStep::kTransitions) == "transitions");
static_assert(name_of(estimate::Keep::kLast) == "last");
static_assert(name_of(film::Layout::kSideBySide) == "side_by_side");
static_assert(name_of(film::Quality::kFinal) == "final");

class SceneOptions : public FolderTest {
 protected:
  Scene with(const std::string& section) const {
    return load_scene(write("scene.toml", std::string(kScene) + section));
  }

  /// Reads every name of an enum under a key, writes it and reads it back.
  template <class E, class Get>
  void expect_every_name(const std::string& section, const std::string& key, Get get) const {
    int value = 0;
    for (const std::string& name : all_names<E>()) {
      SCOPED_TRACE(key + " = " + name);
      const Scene scene = with(section + key + " = \"" + name + "\"\n");
      EXPECT_EQ(get(scene), static_cast<E>(value++));
      const Scene again = load_scene(write("again.toml", to_toml(scene)));
      EXPECT_EQ(get(again), get(scene));
    }
    const std::string refused = message_of([&] { with(section + key + " = \"" + "other\"\n"); });
    for (const std::string& name : all_names<E>()) EXPECT_THAT(refused, HasSubstr(name));
    EXPECT_THAT(refused, HasSubstr(key + " = \"other\"; allowed: "));
  }
};

TEST_F(SceneOptions, EnumsAreReadAndWrittenByName) {
  const std::string model = "[[model]]\nname = \"gms\"\n";
  expect_every_name<sim::ControlLaw>("[controller]\n", "kind",
                                     [](const Scene& s) { return s.controller.kind; });
  expect_every_name<sim::Criterion>("[excitation]\n", "criterion",
                                    [](const Scene& s) { return s.excitation.criterion; });
  expect_every_name<sim::Drive>("[compensation]\n", "drive",
                                [](const Scene& s) { return s.compensation.drive; });
  expect_every_name<film::Layout>("[render]\n", "layout",
                                  [](const Scene& s) { return s.render.layout; });
  expect_every_name<film::Quality>("[render]\n", "quality",
                                   [](const Scene& s) { return s.render.quality; });
  expect_every_name<estimate::Method>(model, "method",
                                      [](const Scene& s) { return *s.models[0].method; });
  expect_every_name<estimate::Optimiser>(
      model + "[model.train]\n", "optimiser",
      [](const Scene& s) { return s.models[0].train.optimiser; });
  expect_every_name<estimate::EStep>(model + "[model.em]\n", "e_step",
                                     [](const Scene& s) { return s.models[0].em.e_step; });
  expect_every_name<estimate::MStep>(model + "[model.em]\n", "m_step",
                                     [](const Scene& s) { return s.models[0].em.m_step; });
  expect_every_name<estimate::Keep>(model + "[model.em]\n", "keep",
                                    [](const Scene& s) { return s.models[0].em.keep; });
}

// Which method a model has where the scene says none is known once its law is.
TEST_F(SceneOptions, TheMethodIsThatOfTheLaw) {
  const Scene scene = with(
      "[[model]]\nname = \"gms\"\n[[model]]\nname = \"lvm_bristles\"\n[[model]]\nname = \"lvm\"\n");
  EXPECT_FALSE(scene.models[0].method);
  const Problem problem = resolve(scene);
  EXPECT_EQ(problem.scene.models[0].method, estimate::Method::kConventional);
  EXPECT_EQ(problem.scene.models[1].method, estimate::Method::kMultiStep);
  EXPECT_EQ(problem.scene.models[2].method, estimate::Method::kJoint);
}

// A model may be any sum of laws without networks; what it is stays when the scene is written.
TEST_F(SceneOptions, AModelMayBeASumOfLaws) {
  const std::string model =
      "[[model]]\nname = \"mine\"\n[[model.law]]\nlaw = \"gms\"\nelements = 3\n";
  const Scene scene =
      with(model + "modifiers = [\"load\"]\n[[model.law]]\nlaw = \"viscous_power\"\n");
  const Problem problem = resolve(scene);
  const estimate::ModelOptions& sum = problem.scene.models[0];
  EXPECT_EQ(sum.method, estimate::Method::kJoint);
  ASSERT_EQ(sum.laws.size(), 2u);
  EXPECT_EQ(sum.laws[0].elements, 3);
  EXPECT_EQ(sum.laws[0].modifiers, std::vector<std::string>{"load"});
  const std::string text = to_toml(problem.scene);
  EXPECT_NE(text.find("[[model.law]]\nlaw = \"viscous_power\""), std::string::npos) << text;

  EXPECT_NE(message_of([&] {
              resolve(with(model + "[[model.law]]\nlaw = \"lvm_bristles\"\n"));
            }).find("model[1].law[2].law = \"lvm_bristles\"; allowed: none, coulomb_viscous"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              resolve(with("[[model]]\nname = \"lvm\"\nmodifiers = [\"load\"]\n"));
            }).find("allowed for lvm, whose parts the data decide: none"),
            std::string::npos);
}

// What the data allow is seen by a model of the injected laws, none of whose values it knows.
TEST_F(SceneOptions, AModelMayHaveTheInjectedLaws) {
  std::string model = "[[model]]\nname = \"known\"\nlaw = \"injected\"\n";
  const std::string laws =
      "[[friction.law]]\nlaw = \"maxwell_slip\"\nelements = 2\n"
      "K = {elements = [1, 2], joints = 1000}\nW = {elements = [1, 2], joints = 1}\n"
      "asymmetry = {a = [0.1, 0.2]}\n"
      "[[friction.law]]\nlaw = \"viscous_power\"\nc = 2\np = 0.7\nv0 = 0.01\n";
  const auto scene = [&](const std::string& friction) {
    return resolve(load_scene(write(
        "scene.toml", "[robot]\nurdf = \"arm.urdf\"\nmjcf = \"arm.xml\"\n" + friction + model)));
  };
  const estimate::ModelOptions known = scene(laws).scene.models[0];
  EXPECT_EQ(known.method, estimate::Method::kJoint);
  ASSERT_EQ(known.laws.size(), 2u);
  EXPECT_EQ(known.laws[0].law, "maxwell_slip");
  EXPECT_EQ(known.laws[0].elements, 2);
  EXPECT_EQ(known.laws[0].modifiers, std::vector<std::string>{"asymmetry"});
  EXPECT_EQ(known.laws[1].law, "viscous_power");

  const std::string of_one =
      replaced(laws, "law = \"viscous_power\"", "law = \"viscous_power\"\njoints = [\"shoulder\"]");
  EXPECT_THAT(
      message_of([&] { scene(of_one); }),
      HasSubstr("model[1].law = \"injected\"; allowed: where [friction] has the same laws"));
  model = "[[model]]\nname = \"injected\"\n";  // the law by its name
  EXPECT_EQ(scene(laws).scene.models[0].laws.size(), 2u);
}

// A scene made in code is one like any other; its messages have no file to name.
TEST_F(SceneOptions, AScenesOriginMayBeEmpty) {
  Scene scene;
  scene.name = "code";
  scene.robot.urdf = path("arm.urdf").string();
  scene.friction.emplace();
  EXPECT_EQ(resolve(scene).scene.friction->model.joints().size(), 2u);
  scene.robot.urdf = path("leg.urdf").string();
  EXPECT_EQ(message_of([&] { resolve(scene); }), "scene: robot.urdf: leg.urdf does not exist");
}

}  // namespace
}  // namespace fricid::scene
