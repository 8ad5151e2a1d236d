// Parts of a scene, so that a stage sees no more of it than it declares.
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
  kRender
};
constexpr std::string_view names(Section) {
  return "name|description|seed|[robot]|[friction]|[plant]|[controller]|[excitation]|[sensors]|"
         "[data]|[identify]|[[model]]|[evaluate]|[render]";
}

/// A scene of which only these sections are as given; the others are at their defaults. Where the
/// robot is among them, its model and its files are too.
scene::Problem part_of(const scene::Problem& problem, std::span<const Section> sections);

/// The same problem with another scene; its robot and its files stay.
scene::Problem with_scene(const scene::Problem& problem, scene::Scene scene);

/// Declares sections of a scene, with the robot the content of its URDF. @throws UserError
void declare(Inputs& inputs, const scene::Problem& problem, std::span<const Section> sections);

}  // namespace fricid::workflow
