// Options of one model to fit, as in a scene.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"
#include "fricid/estimate/options/em.hpp"
#include "fricid/estimate/options/multi_step.hpp"
#include "fricid/estimate/options/torque.hpp"

namespace fricid::estimate {

/// How a model is fitted.
enum class Method {
  kConventional,  ///< to the torque that the rigid body leaves, by a search
  kTorque,        ///< the same by gradients
  kMultiStep,     ///< open-loop windows
  kEm,            ///< expectation-maximisation
  kJoint          ///< to the torque together with the rigid body, then open-loop windows
};
constexpr std::string_view names(Method) { return "conventional|torque|multi_step|em|joint"; }

/// [[model.law]]: one law of a sum.
struct LawOptions {
  std::string law;
  int elements = 4;
  std::vector<std::string> modifiers;

  template <class Archive>
  void visit(Archive& archive) {
    archive("law", law, required(text("friction law without networks")));
    archive("elements", elements, number("", 1, 64, "elements of laws that have several"));
    archive("modifiers", modifiers, text("its modifiers, innermost first"));
  }
};

/// [[model]]: one thing to fit.
struct ModelOptions {
  std::string name;
  std::string label;
  std::string law;               ///< of the law table, or lvm; empty in a scene: the name
  std::vector<LawOptions> laws;  ///< the sum of laws in the place of `law`
  std::optional<Method> method;  ///< none in a scene: by the law
  int elements = 4;
  int n_z = 2;                                    ///< latent states of lvm_paper
  double length = 2e-3;                           ///< over which they change at first [rad]
  bool cross = false;                             ///< weights between joints of lvm_paper
  std::string rigid_body_of = "coulomb_viscous";  ///< where laws of the whole robot start
  std::vector<std::string> modifiers;
  std::string prior;      ///< model file of an arm of the same type
  double prior_sd = 0.2;  ///< of friction about it, relative
  bool networks = true;   ///< of the lvm
  int starts = 4;
  std::vector<int> seeds{1};
  TorqueOptions torque;
  MultiStepOptions train;
  EmOptions em;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name,
            required(text("name of its files, used once: letters, digits, _ - and .")));
    archive("label", label, text("name in tables and plots; empty: the name"));
    archive.text_unless_tables(
        "law", law,
        text("friction law fitted to every joint, or law of the whole robot, or lvm: the sum that "
             "contains the laws, or injected: the sum of the laws of [friction], but none of their "
             "values; empty: the name (simple: coulomb_viscous); or [[model.law]] tables of law, "
             "elements and modifiers: their sum"));
    if constexpr (requires { archive.refuse_unknown(); }) take_defaults_of_law();  // where read
    archive(
        "method", method,
        choice("conventional, torque: fitted to the torque residual of the rigid body, by a search "
               "or by gradients; multi_step, em: from there by open-loop windows or "
               "expectation-maximisation; joint: to the torque together with the rigid body, then "
               "by windows; empty: multi_step for learned laws, joint for sums, else "
               "conventional"));
    archive(
        "elements", elements,
        number("", 1, 64, "elements of laws that have several; width of the nets of learned ones"));
    archive("n_z", n_z, number("", 1, 12, "latent states of lvm_paper"));
    archive(
        "length", length,
        number("rad", 1e-6, 1, "travel over which the latent states of lvm_paper change at first"));
    archive("cross", cross,
            flag("train the weights of lvm_paper between joints and on positions too"));
    archive(
        "rigid_body_of", rigid_body_of,
        text("law whose conventional fit gives laws of the whole robot the rigid body that they "
             "start from, or keep"));
    archive("modifiers", modifiers,
            text("modifiers of the law, innermost first: asymmetry, load, temperature, ..."));
    archive("prior", prior,
            text("model file of an arm of the same type, RUN/models/NAME_sSEED.json, that friction "
                 "and rigid body are pulled to; method joint"));
    archive("prior_sd", prior_sd,
            number("1", 1e-3, 10,
                   "relative standard deviation of each friction parameter about the prior's"));
    archive(
        "networks", networks,
        flag("of the lvm: whether networks may stand for what its laws leave; false to see what "
             "they gain"));
    archive("starts", starts, number("", 1, 1000, "starts of the optimiser"));
    archive("seeds", seeds, number("", 0, 1e9, "one fit per seed"));
    archive.section("torque", torque,
                    "method torque, and multi_step of laws of the whole robot before its windows");
    archive.section("train", train, "methods multi_step and joint");
    archive.section("em", em, "method em");
    archive.tables_unless_text("law", laws, "a law of the sum");
  }

  /// Sets the law's own defaults of the keys below `law`.
  void take_defaults_of_law() {
    if ((law.empty() ? name : law) != "lvm_paper") return;
    elements = 32;
    method = Method::kEm;
    em.e_step = EStep::kAdapted;
    em.m_step = MStep::kTransitions;
    em.iterations = 8;
    em.m_steps = 1000;
    em.batch = 512;
    em.rate = 0.003;
    em.torque_noise = 1;
    em.z_noise_last = 0.03;
    em.rigid_body = false;
    em.lengths = true;
    em.keep = Keep::kLast;
  }
};

}  // namespace fricid::estimate
