#include "c_shape.hpp"

#include "c_text.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/friction/same_structure.hpp"

namespace fricid::deploy {
namespace {

using friction::JointSpec;
using friction::LawSpec;
using friction::RobotFriction;

std::vector<std::string> local_names(const RobotFriction& model) {
  std::vector<std::string> names;
  for (const friction::ParameterRef& parameter : model.parameters()) {
    const bool alone = model.joints()[0].laws.size() < 2;
    if (parameter.joint == friction::kWholeRobot || friction::is_weight(parameter.info.role))
      names.emplace_back();
    else
      names.push_back(fmt::format("{}{}_{}", parameter.owner,
                                  alone ? "" : std::to_string(parameter.law + 1),
                                  parameter.symbol));
  }
  return names;
}

Shape make_shape(std::string name, RobotFriction model, const std::string& prefix) {
  const Traced traced = trace(model);
  const LeafNames leaves{
      .prefix = prefix, .parameters = local_names(model), .whole_robot = model.has_whole()};
  Shape shape;
  shape.name = std::move(name);
  shape.whole = model.has_whole();
  shape.model = std::move(model);
  shape.torque = write_body(traced.torque, traced.tau_f, leaves);
  shape.step = write_body(traced.step, traced.z_next, leaves);
  for (const Graph* graph : {&traced.torque, &traced.step})
    for (const Layer& layer : graph->layers())
      if (std::ranges::find(shape.layers, layer.parameters, &Layer::parameters) ==
          shape.layers.end())
        shape.layers.push_back(layer);
  return shape;
}

// The parameters of a shape as its functions read them.
std::vector<double> stored(const Shape& shape, std::span<const double> theta) {
  std::vector<double> values(theta.begin(), theta.end());
  for (const Layer& layer : shape.layers)
    for (int r = 0; r < layer.outputs; ++r)
      for (int c = 0; c < layer.inputs; ++c)
        values[static_cast<std::size_t>(layer.parameters + c * layer.outputs + r)] =
            theta[static_cast<std::size_t>(layer.parameters + r * layer.inputs + c)];
  return values;
}

std::string described(const JointSpec& joint) {
  std::string text;
  const auto line = [&](std::string_view name, std::span<const friction::LawInfo> table) {
    for (const friction::LawInfo& info : table)
      if (info.name == name) text += c_comment(fmt::format("{}: {}", name, info.equation)) + "\n";
  };
  for (const LawSpec& law : joint.laws) {
    line(law.law, friction::law_table());
    for (const friction::ModifierSpec& modifier : law.modifiers)
      line(modifier.name, friction::modifier_table());
  }
  return text;
}

std::string formal(const CBody& body, bool z_always, bool whole, const std::string& prefix) {
  return arguments(body, z_always, [&](const std::string& name) {
    if (name == "p" || (name == "z" && !z_always) || (name != "z" && whole))
      return fmt::format("const {}_real *{}", prefix, name);
    if (name == "z") return fmt::format("{}_real *z", prefix);
    return fmt::format("{}_real {}", prefix, name);
  });
}

std::string loop_variable(const CBody& body) { return body.loops ? "  int i;\n" : ""; }

// The parameter list of a C function: void if it is empty.
std::string none_if_empty(const std::string& text) { return text.empty() ? "void" : text; }

std::string table(const std::string& name, const std::vector<double>& values,
                  const std::vector<friction::ParameterRef>& refs, bool slides,
                  const std::string& prefix) {
  std::string text = fmt::format("static const {}_real {}[{}] = {{\n", prefix, name, values.size());
  std::string weights;
  const auto end_line = [&] {
    if (!weights.empty()) text += fmt::format("  {}\n", weights);
    weights.clear();
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string number = c_number(values[i], prefix) + (i + 1 < values.size() ? "," : "");
    if (friction::is_weight(refs[i].info.role)) {
      if (weights.size() + number.size() > 96) end_line();
      weights += (weights.empty() ? "" : " ") + number;
      continue;
    }
    end_line();
    text += fmt::format("  {} {}\n", number,
                        c_comment(fmt::format("{} {} [{}]", refs[i].owner, refs[i].symbol,
                                              unit_of_joint(refs[i].info.unit, slides))));
  }
  end_line();
  return text + "};\n\n";
}

}  // namespace

Parts parts_of(const data::ModelFile& model, std::string prefix) {
  const RobotFriction& robot = model.arm.friction.model;
  Parts parts{.prefix = std::move(prefix),
              .friction = {robot, traced_theta(model.arm.friction)},
              .joint_names = model.arm.robot.joint_names(),
              .slides = {},
              .shapes = {},
              .shape_of = {}};
  for (const dynamics::Joint& joint : model.arm.robot.joints)
    parts.slides.push_back(dynamics::slides(joint));
  parts.shape_of.assign(parts.joint_names.size(), -1);
  std::vector<JointSpec> known;
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const JointSpec& spec = robot.joints()[j];
    if (spec.laws.empty()) continue;
    auto found =
        std::ranges::find_if(known, [&](const JointSpec& k) { return same_structure(k, spec); });
    if (found == known.end()) {
      known.push_back(spec);
      parts.shapes.push_back(make_shape(fmt::format("{}_law{}", parts.prefix, known.size()),
                                        RobotFriction({spec}), parts.prefix));
      found = known.end() - 1;
    }
    parts.shape_of[j] = static_cast<int>(found - known.begin());
  }
  if (robot.has_whole()) {
    parts.whole = static_cast<int>(parts.shapes.size());
    parts.shapes.push_back(make_shape(
        parts.prefix + "_robot",
        RobotFriction(std::vector<JointSpec>(robot.joints().size()), robot.whole()), parts.prefix));
  }
  return parts;
}

std::string functions_of(const Shape& shape, const std::string& prefix) {
  std::string text;
  if (shape.whole) {
    for (const friction::LawInfo& info : friction::robot_law_table())
      if (info.name == shape.model.whole().law)
        text += c_comment(fmt::format("{}: {}", info.name, info.equation)) + "\n";
    const std::string tau = fmt::format("{}_real *tau_f", prefix);
    const std::string others = formal(shape.torque, false, true, prefix);
    text += fmt::format("static inline void {}_torque({}{}{}) {{\n", shape.name, others,
                        others.empty() ? "" : ", ", tau);
    text += loop_variable(shape.torque) + shape.torque.statements;
    for (std::size_t j = 0; j < shape.torque.outputs.size(); ++j)
      text += fmt::format("  tau_f[{}] += {};\n", j, shape.torque.outputs[j]);
    text += "}\n\n";
  } else {
    text += described(shape.model.joints()[0]);
    text += fmt::format("static inline {}_real {}_torque({}) {{\n", prefix, shape.name,
                        none_if_empty(formal(shape.torque, false, false, prefix)));
    text += loop_variable(shape.torque) + shape.torque.statements;
    text += fmt::format("  return {};\n}}\n\n", shape.torque.outputs[0]);
  }
  if (!shape.has_step()) return text;
  text += fmt::format("static inline void {}_step({}, {}_real dt) {{\n", shape.name,
                      formal(shape.step, true, shape.whole, prefix), prefix);
  text += loop_variable(shape.step) + shape.step.statements;
  std::string moves;
  for (std::size_t i = 0; i < shape.step.outputs.size(); ++i) {
    const std::string& value = shape.step.outputs[i];
    if (value == fmt::format("z[{}]", i)) continue;
    text += fmt::format("  const {}_real z{} = {};\n", prefix, i, value);
    moves += fmt::format("  z[{0}] = z{0};\n", i);
  }
  return text + moves + "}\n\n";
}

std::string tables(const Parts& parts) {
  std::string text;
  const RobotFriction& model = parts.friction.model;
  const std::span<const double> theta(parts.friction.theta);
  const auto add = [&](const Shape& shape, int joint, const std::string& name) {
    const auto begin = static_cast<std::size_t>(model.parameter_begin(joint));
    const auto size = static_cast<std::size_t>(shape.model.parameter_count());
    if (size > 0)
      text +=
          table(name, stored(shape, theta.subspan(begin, size)), shape.model.parameters(),
                joint < parts.n() && parts.slides[static_cast<std::size_t>(joint)], parts.prefix);
  };
  for (int j = 0; j < parts.n(); ++j)
    if (const Shape* shape = parts.of(j)) {
      text +=
          c_comment(fmt::format("joint {}", parts.joint_names[static_cast<std::size_t>(j)])) + "\n";
      add(*shape, j, fmt::format("{}_p{}", parts.prefix, j));
    }
  if (parts.whole >= 0) add(parts.shapes.back(), model.joint_count(), parts.prefix + "_p_robot");
  return text;
}

}  // namespace fricid::deploy
