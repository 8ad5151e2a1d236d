// The friction of a model as shapes: structures of friction that joints share, each two functions
// of C and a table of parameters per joint.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "c_function.hpp"
#include "fricid/data/model_file.hpp"
#include "trace.hpp"

namespace fricid::deploy {

/// A structure of friction that joints share, or that of the whole robot, with its two functions.
struct Shape {
  std::string name;  ///< of its functions
  friction::RobotFriction
      model;  ///< of one joint, or of n empty ones and the law of the whole robot
  bool whole = false;
  CBody torque, step;
  std::vector<Layer> layers;  ///< whose weights are stored by columns

  bool has_step() const { return model.state_size() > 0; }
};

/// The model's friction as shapes, and the shape of each joint.
struct Parts {
  std::string prefix;
  friction::Friction friction;  ///< with the parameters of a trace
  std::vector<std::string> joint_names;
  std::vector<bool> slides;  ///< per joint
  std::vector<Shape> shapes;
  std::vector<int> shape_of;  ///< (n) -1: no friction
  int whole = -1;

  int n() const { return static_cast<int>(joint_names.size()); }
  const Shape* of(int joint) const {
    const int shape = shape_of[static_cast<std::size_t>(joint)];
    return shape < 0 ? nullptr : &shapes[static_cast<std::size_t>(shape)];
  }
  bool reads(Field field) const {
    return std::ranges::any_of(shapes, [&](const Shape& shape) {
      return shape.torque.fields.contains(field) || shape.step.fields.contains(field);
    });
  }
};

/// @param prefix  of every name of the header
Parts parts_of(const data::ModelFile& model, std::string prefix);

/// Formal or actual arguments of a body: p, inputs and z, as far as it reads them.
template <class Named>
std::string arguments(const CBody& body, bool z_always, Named named) {
  std::string text;
  const auto add = [&](const std::string& argument) {
    text += text.empty() ? argument : fmt::format(", {}", argument);
  };
  if (body.parameters) add(named("p"));
  for (const Field field : body.fields) add(named(kFieldNames[static_cast<int>(field)]));
  if (body.states || z_always) add(named("z"));
  return text;
}

/// The functions NAME_torque and NAME_step of a shape.
std::string functions_of(const Shape& shape, const std::string& prefix);
/// The parameters of every joint as its functions read them.
std::string tables(const Parts& parts);

}  // namespace fricid::deploy
