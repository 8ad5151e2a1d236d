#include "models.hpp"

#include <algorithm>
#include <iterator>
#include <span>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/friction/signal_scales.hpp"
#include "fricid/friction/sum.hpp"

namespace fricid::scene {
namespace {

using estimate::Method;

constexpr std::string_view kInjected = "injected";  // as model.law: the laws of [friction]
constexpr std::string_view kSimple = "simple";      // as name: coulomb_viscous

void check_modifiers(const Scene& scene, const std::vector<std::string>& given,
                     const std::string& key, const std::string& shown) {
  std::vector<std::string_view> known;
  for (const friction::LawInfo& row : friction::modifier_table()) known.push_back(row.name);
  for (const std::string& modifier : given) {
    if (std::ranges::find(known, modifier) == known.end())
      throw UserError("{}: {}.modifiers = \"{}\"; allowed: {}",
                      scene.origin.place(key + ".modifiers"), shown, modifier,
                      fmt::join(known, ", "));
    if (std::ranges::count(given, modifier) > 1)
      throw UserError("{}: {}.modifiers names \"{}\" twice", scene.origin.place(key + ".modifiers"),
                      shown, modifier);
  }
}

// A sum of laws stands where a law would.
void check_sum(const Scene& scene, const estimate::ModelOptions& model, const std::string& key,
               const std::string& shown) {
  if (!model.modifiers.empty())
    throw UserError("{}: {}.modifiers beside a sum of laws; allowed: modifiers of each law",
                    scene.origin.place(key + ".modifiers"), shown);
  for (std::size_t l = 0; l < model.laws.size(); ++l) {
    const std::string at = fmt::format("{}.law[{}]", key, l);
    const estimate::LawOptions& law = model.laws[l];
    std::vector<std::string_view> allowed;
    for (const friction::LawInfo& row : friction::law_table())
      if (!friction::is_learned(row.name)) allowed.push_back(row.name);
    if (std::ranges::find(allowed, law.law) == allowed.end())
      throw UserError("{}: {}.law[{}].law = \"{}\"; allowed: {}", scene.origin.place(at + ".law"),
                      shown, l + 1, law.law, fmt::join(allowed, ", "));
    check_modifiers(scene, law.modifiers, at, fmt::format("{}.law[{}]", shown, l + 1));
  }
}

bool same_laws(const friction::JointSpec& a, const friction::JointSpec& b) {
  const auto same_modifier = [](const friction::ModifierSpec& x, const friction::ModifierSpec& y) {
    return x.name == y.name && x.order == y.order;
  };
  return std::ranges::equal(a.laws, b.laws,
                            [&](const friction::LawSpec& x, const friction::LawSpec& y) {
                              return x.law == y.law && x.elements == y.elements &&
                                     std::ranges::equal(x.modifiers, y.modifiers, same_modifier);
                            });
}

// The sum of the laws that the simulator injects: their form, none of their values.
void take_injected_laws(const Scene& scene, estimate::ModelOptions& model, const std::string& key,
                        const std::string& shown) {
  const auto require = [&](bool holds) {
    if (!holds)
      throw UserError(
          "{}: {}.law = \"{}\"; allowed: where [friction] has the same laws without networks in "
          "every joint, ripples of one wave",
          scene.origin.place(key + ".law"), shown, kInjected);
  };
  require(scene.simulates());
  const std::vector<friction::JointSpec>& joints = scene.friction->model.joints();
  for (const friction::JointSpec& joint : joints) require(same_laws(joint, joints.front()));
  for (const friction::LawSpec& law : joints.front().laws) {
    estimate::LawOptions& taken = model.laws.emplace_back();
    require(!friction::is_learned(law.law));
    taken.law = law.law;
    if (law.elements > 0) taken.elements = law.elements;
    for (const friction::ModifierSpec& modifier : law.modifiers) {
      require(modifier.order == 1);
      taken.modifiers.push_back(modifier.name);
    }
  }
  require(!model.laws.empty());
  model.law.clear();
}

/// What `law` may say.
std::vector<std::string_view> known_laws() {
  std::vector<std::string_view> laws{friction::kLvm, kInjected};
  for (const friction::LawInfo& row : friction::law_table()) laws.push_back(row.name);
  for (const friction::LawInfo& row : friction::robot_law_table()) laws.push_back(row.name);
  return laws;
}

// The law of a model and the method that suits it.
void complete_law(const Scene& scene, estimate::ModelOptions& model,
                  std::span<const std::string_view> laws, const std::string& key,
                  const std::string& shown) {
  const std::string said = model.law.empty() ? "name" : "law";
  if (model.law.empty()) model.law = model.name == kSimple ? "coulomb_viscous" : model.name;
  if (std::ranges::find(laws, model.law) == laws.end())
    throw UserError("{}: {}.{} = \"{}\"; allowed: {}", scene.origin.place(key + "." + said), shown,
                    said, model.law, fmt::join(laws, ", "));
  if (model.law == friction::kLvm) {
    const estimate::ModelOptions defaults;
    for (const auto& [decided, given] :
         {std::pair{"elements", model.elements != defaults.elements},
          std::pair{"modifiers", model.modifiers != defaults.modifiers}})
      if (given)
        throw UserError("{}: {}.{} is given; allowed for lvm, whose parts the data decide: none",
                        scene.origin.place(fmt::format("{}.{}", key, decided)), shown, decided);
    if (model.method.value_or(Method::kJoint) != Method::kJoint)
      throw UserError("{}: {}.method = \"{}\"; allowed for lvm: joint",
                      scene.origin.place(key + ".method"), shown, name_of(*model.method));
    model.method = Method::kJoint;
    return;
  }
  if (!model.modifiers.empty() && friction::is_robot_law(model.law))
    throw UserError("{}: {}.modifiers = \"{}\"; allowed for {}, a law of the whole robot: none",
                    scene.origin.place(key + ".modifiers"), shown, model.modifiers[0], model.law);
  check_modifiers(scene, model.modifiers, key, shown);
  const bool learned = friction::is_learned(model.law);
  if (!model.method) model.method = learned ? Method::kMultiStep : Method::kConventional;
  if (learned && (model.method == Method::kConventional || model.method == Method::kJoint))
    throw UserError("{}: {}.method = \"{}\"; allowed for {}: torque, multi_step, em",
                    scene.origin.place(key + ".method"), shown, name_of(*model.method), model.law);
}

/// Keys that laws of the whole robot alone have.
void check_robot_law_keys(const Scene& scene, const estimate::ModelOptions& model,
                          const std::string& key, const std::string& shown) {
  const estimate::ModelOptions defaults;
  const bool whole = model.laws.empty() && friction::is_robot_law(model.law);
  const bool latents = whole && friction::find_robot_law(model.law).most_latents > 0;
  const auto only = [&](bool applies, const std::string& name, const std::string& value) {
    if (!applies)
      throw UserError("{}: {}.{} = {}; allowed for {}: none", scene.origin.place(key + "." + name),
                      shown, name, value, model.laws.empty() ? model.law : "a sum of laws");
  };
  if (whole && std::ssize(scene.joints) > friction::kMostJoints)
    throw UserError("{}: {}.law = \"{}\" on a robot of {} joints; allowed: up to {}",
                    scene.origin.place(key + ".name"), shown, model.law, scene.joints.size(),
                    friction::kMostJoints);
  only(latents || model.n_z == defaults.n_z, "n_z", fmt::format("{}", model.n_z));
  only(latents || model.length == defaults.length, "length", fmt::format("{}", model.length));
  only(latents || model.cross == defaults.cross, "cross", "true");
  only(whole || model.rigid_body_of == defaults.rigid_body_of, "rigid_body_of",
       fmt::format("\"{}\"", model.rigid_body_of));
  std::vector<std::string_view> laws;
  for (const friction::LawInfo& row : friction::law_table())
    if (!friction::is_learned(row.name)) laws.push_back(row.name);
  if (std::ranges::find(laws, model.rigid_body_of) == laws.end())
    throw UserError("{}: {}.rigid_body_of = \"{}\"; allowed: {}",
                    scene.origin.place(key + ".rigid_body_of"), shown, model.rigid_body_of,
                    fmt::join(laws, ", "));
}

}  // namespace

estimate::ModelOptions model_of_law(Scene scene, const std::string& name) {
  std::vector<std::string_view> known{kSimple};
  std::ranges::copy(known_laws(), std::back_inserter(known));
  if (std::ranges::find(known, name) == known.end()) {
    for (const estimate::ModelOptions& model : scene.models) known.push_back(model.name);
    throw UserError("model {}: found no law and no model of the scene; allowed: {}", name,
                    fmt::join(known, ", "));
  }
  estimate::ModelOptions model;
  model.name = name;
  model.take_defaults_of_law();
  scene.models = {model};
  complete_models(scene);
  return scene.models.front();
}

void complete_models(Scene& scene) {
  const std::vector<std::string_view> laws = known_laws();
  for (std::size_t i = 0; i < scene.models.size(); ++i) {
    estimate::ModelOptions& model = scene.models[i];
    const std::string key = fmt::format("model[{}]", i), shown = fmt::format("model[{}]", i + 1);
    require_name(Named::kModel, model.name, scene.origin.place(key + ".name"));
    require_label(model.label, shown + ".label", scene.origin.place(key + ".label"));
    for (std::size_t other = 0; other < i; ++other)
      if (scene.models[other].name == model.name)
        throw UserError("{}: {}.name = \"{}\" is used twice", scene.origin.place(key + ".name"),
                        shown, model.name);
    if (model.label.empty()) model.label = model.name;
    const bool by_name = model.law.empty() && model.laws.empty();
    if ((by_name ? model.name : model.law) == kInjected)
      take_injected_laws(scene, model, key, shown);
    if (!model.laws.empty()) {
      check_sum(scene, model, key, shown);
      model.method = model.method.value_or(Method::kJoint);
    } else {
      complete_law(scene, model, laws, key, shown);
    }
    check_robot_law_keys(scene, model, key, shown);
    if (!model.prior.empty() && model.method != Method::kJoint)
      throw UserError("{}: {}.prior of a model of method {}; allowed: joint",
                      scene.origin.place(key + ".prior"), shown, name_of(*model.method));
    if (!model.networks && (!model.laws.empty() || model.law != friction::kLvm))
      throw UserError("{}: {}.networks of a model that is no lvm; allowed: law = \"{}\"",
                      scene.origin.place(key + ".networks"), shown, friction::kLvm);
    std::sort(model.seeds.begin(), model.seeds.end());
    model.seeds.erase(std::unique(model.seeds.begin(), model.seeds.end()), model.seeds.end());
  }
}

}  // namespace fricid::scene
