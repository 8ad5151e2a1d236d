#include "fricid/workflow/section.hpp"

#include <fmt/format.h>
#include <algorithm>

namespace fricid::workflow {

scene::Problem part_of(const scene::Problem& problem, std::span<const Section> sections) {
  const scene::Scene& scene = problem.scene;
  scene::Scene part;
  bool has_robot = false, has_logs = false;
  for (const Section section : sections) switch (section) {
      case Section::kName:
        part.name = scene.name;
        break;
      case Section::kDescription:
        part.description = scene.description;
        break;
      case Section::kSeed:
        part.seed = scene.seed;
        break;
      case Section::kRobot:
        part.robot = scene.robot;
        has_robot = true;
        break;
      case Section::kFriction:
        part.friction = scene.friction;
        break;
      case Section::kPlant:
        part.plant = scene.plant;
        break;
      case Section::kController:
        part.controller = scene.controller;
        break;
      case Section::kExcitation:
        part.excitation = scene.excitation;
        break;
      case Section::kSensors:
        part.sensors = scene.sensors;
        break;
      case Section::kData:
        part.data = scene.data;
        has_logs = true;
        break;
      case Section::kIdentify:
        part.identify = scene.identify;
        break;
      case Section::kModels:
        part.models = scene.models;
        break;
      case Section::kEvaluate:
        part.evaluate = scene.evaluate;
        break;
      case Section::kPayload:
        part.payload = scene.payload;
        has_logs = true;
        break;
      case Section::kCompensation:
        part.compensation = scene.compensation;
        break;
      case Section::kContact:
        part.contact = scene.contact;
        break;
      case Section::kRender:
        part.render = scene.render;
        break;
    }
  if (has_robot) part.joints = scene.joints;
  if (has_logs) part.origin = scene.origin;               // relative names of logs start there
  if (!has_robot) part.identify.linear_prior_sd.clear();  // given in [robot]
  return {.scene = std::move(part),
          .robot = has_robot ? problem.robot : dynamics::RobotModel(),
          .urdf_path = has_robot ? problem.urdf_path : std::filesystem::path(),
          .mjcf_path = has_robot ? problem.mjcf_path : std::filesystem::path(),
          .contract_path = has_logs ? problem.contract_path : std::filesystem::path()};
}

scene::Problem with_scene(const scene::Problem& problem, scene::Scene scene) {
  return {.scene = std::move(scene),
          .robot = problem.robot,
          .urdf_path = problem.urdf_path,
          .mjcf_path = problem.mjcf_path,
          .contract_path = problem.contract_path,
          .inputs = problem.inputs};
}

void declare(Inputs& inputs, const scene::Problem& problem, std::span<const Section> sections) {
  for (const Section section : sections) {
    scene::Scene only = part_of(problem, std::span(&section, 1)).scene;
    only.joints = problem.scene.joints;  // per-joint values are by joint
    inputs.text(fmt::format("scene {}", name_of(section)), scene::to_toml(only));
  }
  if (std::ranges::find(sections, Section::kRobot) != sections.end())
    inputs.file("URDF", problem.urdf_path);
}

}  // namespace fricid::workflow
