// Sections of a scene, so that a stage sees only those that it declares.
#pragma once

#include <span>
#include <string_view>

#include "fricid/base/enum_names.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/workflow/inputs.hpp"

namespace fricid::workflow {

enum class Section {
  kName,
  kDescription,
  kSeed,
  kRobot,
  kFriction,
  kPlant,
  kController,
  kExcitation,
  kSensors,
  kData,
  kIdentify,
  kModels,
  kEvaluate,
  kPayload,
  kCompensation,
  kContact,
  kRender
};
constexpr std::string_view names(Section) {
  return "name|description|seed|[robot]|[friction]|[plant]|[controller]|[excitation]|[sensors]|"
         "[data]|[identify]|[[model]]|[evaluate]|[payload]|[compensation]|[contact]|[render]";
}

/// The problem with only these sections of its scene, the others at their defaults. The robot's
/// model and files are kept if Section::kRobot is among them.
scene::Problem part_of(const scene::Problem& problem, std::span<const Section> sections);

/// The same problem and robot with another scene.
scene::Problem with_scene(const scene::Problem& problem, scene::Scene scene);

/// Declares sections of a scene; [robot] includes the content of the URDF. @throws UserError
void declare(Inputs& inputs, const scene::Problem& problem, std::span<const Section> sections);

}  // namespace fricid::workflow
