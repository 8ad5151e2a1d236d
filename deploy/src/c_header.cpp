#include "fricid/deploy/c_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <vector>

#include "c_function.hpp"
#include "c_text.hpp"
#include "trace.hpp"

namespace fricid::deploy {
namespace {

using friction::Friction;
using friction::JointSpec;
using friction::LawSpec;
using friction::RobotFriction;

bool same(const JointSpec& a, const JointSpec& b) {
  return std::ranges::equal(a.laws, b.laws, [](const LawSpec& x, const LawSpec& y) {
    return x.law == y.law && x.elements == y.elements &&
           std::ranges::equal(x.modifiers, y.modifiers, [](const auto& m, const auto& n) {
             return m.name == n.name && m.order == n.order;
           });
  });
}

// A structure of friction that joints share, or that of the whole robot, with its two functions.
struct Shape {
  std::string name;     ///< of its functions
  RobotFriction model;  ///< of one joint, or of n empty ones and the law of the whole robot
  bool whole = false;
  CBody torque, step;
  std::vector<Layer> layers;  ///< whose weights are stored by columns

  bool has_step() const { return model.state_size() > 0; }
};

std::vector<std::string> local_names(const RobotFriction& model) {
  std::vector<std::string> names;
  for (const friction::ParameterRef& parameter : model.parameters()) {
    const bool alone = model.joints()[0].laws.size() < 2;
    if (parameter.joint == friction::kWholeRobot || parameter.info.role == friction::Role::kWeight)
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

// The model's friction as shapes and who has which.
struct Parts {
  std::string prefix;
  const Friction& friction;
  std::vector<std::string> joint_names;
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

Parts parts_of(const data::ModelFile& model) {
  const RobotFriction& robot = model.arm.friction.model;
  Parts parts{.prefix = code_name(model),
              .friction = model.arm.friction,
              .joint_names = {},
              .shapes = {},
              .shape_of = {}};
  for (const dynamics::Joint& joint : model.arm.robot.joints)
    parts.joint_names.push_back(joint.name);
  parts.shape_of.assign(parts.joint_names.size(), -1);
  std::vector<JointSpec> known;
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const JointSpec& spec = robot.joints()[j];
    if (spec.laws.empty()) continue;
    auto found = std::ranges::find_if(known, [&](const JointSpec& k) { return same(k, spec); });
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

// ---- the functions of one shape

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

// Formal or actual arguments: what a body reads of p, the inputs and z.
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

std::string formal(const CBody& body, bool z_always, bool whole, const std::string& prefix) {
  return arguments(body, z_always, [&](const std::string& name) {
    if (name == "p" || (name == "z" && !z_always) || (name != "z" && whole))
      return fmt::format("const {}_real *{}", prefix, name);
    if (name == "z") return fmt::format("{}_real *z", prefix);
    return fmt::format("{}_real {}", prefix, name);
  });
}

std::string loop_variable(const CBody& body) { return body.loops ? "  int i;\n" : ""; }

// What is the same at every state is said without names.
std::string none_if_empty(const std::string& text) { return text.empty() ? "void" : text; }

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

// ---- the tables

std::string table(const std::string& name, const std::vector<double>& values,
                  const std::vector<friction::ParameterRef>& refs, const std::string& prefix) {
  std::string text = fmt::format("static const {}_real {}[{}] = {{\n", prefix, name, values.size());
  std::string weights;
  const auto end_line = [&] {
    if (!weights.empty()) text += fmt::format("  {}\n", weights);
    weights.clear();
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string number = c_number(values[i], prefix) + (i + 1 < values.size() ? "," : "");
    if (refs[i].info.role == friction::Role::kWeight) {
      if (weights.size() + number.size() > 96) end_line();
      weights += (weights.empty() ? "" : " ") + number;
      continue;
    }
    end_line();
    text += fmt::format(
        "  {} {}\n", number,
        c_comment(fmt::format("{} {} [{}]", refs[i].owner, refs[i].symbol, refs[i].info.unit)));
  }
  end_line();
  return text + "};\n\n";
}

std::string tables(const Parts& parts) {
  std::string text;
  const RobotFriction& model = parts.friction.model;
  const std::span<const double> theta(parts.friction.theta);
  const auto add = [&](const Shape& shape, int joint, const std::string& name) {
    const auto begin = static_cast<std::size_t>(model.parameter_begin(joint));
    const auto size = static_cast<std::size_t>(shape.model.parameter_count());
    if (size > 0)
      text += table(name, stored(shape, theta.subspan(begin, size)), shape.model.parameters(),
                    parts.prefix);
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

// ---- the functions that a user calls

std::string call(const Parts& parts, const Shape& shape, int joint, bool step,
                 const std::string& index) {
  const CBody& body = step ? shape.step : shape.torque;
  const int state = joint < 0 ? parts.friction.model.state_begin(parts.n())
                              : parts.friction.model.state_begin(joint);
  const std::string list = arguments(body, step, [&](const std::string& name) -> std::string {
    if (name == "p")
      return joint < 0 ? parts.prefix + "_p_robot" : fmt::format("{}_p{}", parts.prefix, joint);
    if (name == "z") return fmt::format("s->z + {}", state);
    return name + index;
  });
  return fmt::format("{}_{}({}", shape.name, step ? "step" : "torque", list);
}

// "(void)q;" for what this model does not read.
std::string unread(bool step, const std::vector<const Shape*>& shapes) {
  std::string text;
  const auto bodies = [&](auto predicate) {
    return std::ranges::any_of(shapes, [&](const Shape* shape) {
      return predicate(step ? shape->step : shape->torque) && (!step || shape->has_step());
    });
  };
  if (!bodies([&](const CBody& body) { return step || body.states; })) text += "  (void)s;\n";
  for (const Field field : {Field::kQ, Field::kV, Field::kLoad, Field::kTemperature})
    if (!bodies([&](const CBody& body) { return body.fields.contains(field); }))
      text += fmt::format("  (void){};\n", kFieldNames[static_cast<int>(field)]);
  if (step && !bodies([](const CBody&) { return true; })) text += "  (void)dt;\n";
  return text;
}

std::string joint_functions(const Parts& parts) {
  const std::string& p = parts.prefix;
  std::vector<const Shape*> shapes;
  std::string torques, steps;
  for (int j = 0; j < parts.n(); ++j)
    if (const Shape* shape = parts.of(j)) {
      shapes.push_back(shape);
      torques += fmt::format("    case {}: return {});\n", j, call(parts, *shape, j, false, ""));
      if (shape->has_step())
        steps += fmt::format("    case {}: {}, dt); break;\n", j, call(parts, *shape, j, true, ""));
    }
  const std::string inputs =
      fmt::format("{0}_real q, {0}_real v, {0}_real load, {0}_real temperature", p);
  std::string text = fmt::format(
      "/* The same for one joint, 0 .. {2}. */\n"
      "static inline {0}_real {0}_joint_torque(const {0}_state *s, int joint, {1}) {{\n{3}"
      "  switch (joint) {{\n{4}    default: return {0}_R(0.0);\n  }}\n}}\n\n",
      p, inputs, parts.n() - 1, unread(false, shapes), torques);
  text += fmt::format(
      "static inline void {0}_joint_step({0}_state *s, int joint, {1}, {0}_real dt) {{\n{2}", p,
      inputs, unread(true, shapes));
  if (steps.empty()) return text + "  (void)joint;\n}\n\n";
  return text + fmt::format(
                    "  if (!(dt > {}_R(0.0))) return;\n  switch (joint) {{\n{}    default: "
                    "break;\n  }}\n}}\n\n",
                    p, steps);
}

std::string robot_functions(const Parts& parts) {
  const std::string& p = parts.prefix;
  std::vector<const Shape*> shapes;
  std::string torques, steps;
  for (int j = 0; j < parts.n(); ++j) {
    const Shape* shape = parts.of(j);
    const std::string index = fmt::format("[{}]", j);
    torques += fmt::format("  tau_f[{}] = {};\n", j,
                           shape ? call(parts, *shape, j, false, index) + ")" : p + "_R(0.0)");
    if (!shape) continue;
    shapes.push_back(shape);
    if (shape->has_step())
      steps += fmt::format("  {}, dt);\n", call(parts, *shape, j, true, index));
  }
  if (parts.whole >= 0) {
    const Shape& shape = parts.shapes.back();
    shapes.push_back(&shape);
    const std::string torque = call(parts, shape, -1, false, "");
    torques += fmt::format("  {}{}tau_f);\n", torque, torque.back() == '(' ? "" : ", ");
    if (shape.has_step()) steps += fmt::format("  {}, dt);\n", call(parts, shape, -1, true, ""));
  }
  const std::string inputs = fmt::format(
      "const {0}_real *q, const {0}_real *v,\n    const {0}_real *load, const {0}_real "
      "*temperature",
      p);
  return fmt::format(
             "/* tau_f[{1}]: friction torque of every joint [N m], > 0 resists v > 0. */\n"
             "static inline void {0}_torque(const {0}_state *s, {2},\n    {0}_real *tau_f) {{\n"
             "{3}{4}}}\n\n",
             p, parts.n(), inputs, unread(false, shapes), torques) +
         fmt::format(
             "/* Moves the states by dt [s] with the inputs held; dt <= 0 moves nothing. */\n"
             "static inline void {0}_step({0}_state *s, {1},\n    {0}_real dt) {{\n{2}{3}{4}}}\n",
             p, inputs, unread(true, shapes),
             steps.empty() ? "" : fmt::format("  if (!(dt > {}_R(0.0))) return;\n", p), steps);
}

std::string preamble(const Parts& parts, const data::ModelFile& model, const std::string& helpers) {
  const std::string& p = parts.prefix;
  const int states = parts.friction.model.state_size();
  std::string read;
  for (const Field field : {Field::kQ, Field::kV, Field::kLoad, Field::kTemperature})
    if (parts.reads(field))
      read += fmt::format("{}{}", read.empty() ? "" : ", ", kFieldNames[static_cast<int>(field)]);
  std::string text =
      c_comment(fmt::format("Joint friction of model {} ({}), robot {}, written by fricid.",
                            model.name, model.label, model.arm.robot.name)) +
      "\n";
  text += fmt::format(
      "/*\n"
      " * Every control or simulation step of dt seconds:\n"
      " *\n"
      " *     {0}_torque(&state, q, v, load, temperature, tau_f);   M a + h(q, v) + tau_f = tau\n"
      " *     ... q and v move ...\n"
      " *     {0}_step(&state, q, v, load, temperature, dt);        with the new q and v\n"
      " *\n"
      " * q [rad], v [rad/s], load: motor torque [N m], temperature [K]; for prismatic joints m,\n"
      " * m/s, N. This model reads {1}; arrays of the others may be null.\n"
      " * double, or float where FRICID_FLOAT is defined. Needs C99 and <math.h> alone.\n"
      " */\n",
      p, read.empty() ? "nothing" : read);
  text += fmt::format(
      "#ifndef {0}_FRICTION_H\n#define {0}_FRICTION_H\n\n#include <math.h>\n\n"
      "#ifdef FRICID_FLOAT\ntypedef float {0}_real;\n#define {0}_R(x) ((float)(x))\n"
      "#define {0}_F(name) name##f\n#else\ntypedef double {0}_real;\n#define {0}_R(x) (x)\n"
      "#define {0}_F(name) name\n#endif\n\n"
      "enum {{ {0}_JOINTS = {1}, {0}_STATES = {2} }};\n\n",
      p, parts.n(), states);
  text += fmt::format("static const char *const {}_joint_names[{}] = {{\n", p, parts.n());
  for (int j = 0; j < parts.n(); ++j)
    text += fmt::format("  {}{}\n", c_string(parts.joint_names[static_cast<std::size_t>(j)]),
                        j + 1 < parts.n() ? "," : "");
  text += "};\n\n";
  text += fmt::format(
      "/* States of the friction; all zero: bristles at rest. */\n"
      "typedef struct {{\n  {0}_real z[{1}];\n}} {0}_state;\n\n"
      "static inline void {0}_init({0}_state *s) {{\n  int i;\n"
      "  for (i = 0; i < {1}; ++i) s->z[i] = {0}_R(0.0);\n}}\n\n"
      "static inline const char *{0}_joint_name(int joint) {{\n"
      "  return joint >= 0 && joint < {2} ? {0}_joint_names[joint] : \"\";\n}}\n\n",
      p, std::max(states, 1), parts.n());
  return text + helpers;
}

}  // namespace

std::string code_name(const data::ModelFile& model) {
  std::string name;
  for (const char c : fmt::format("{}_s{}", model.name, model.seed))
    name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return std::isalpha(static_cast<unsigned char>(name[0])) ? name : fmt::format("m{}", name);
}

std::string c_header(const data::ModelFile& model) {
  const Parts parts = parts_of(model);
  std::set<Op> operations;
  for (const Shape& shape : parts.shapes) {
    operations.insert(shape.torque.helpers.begin(), shape.torque.helpers.end());
    if (shape.has_step()) operations.insert(shape.step.helpers.begin(), shape.step.helpers.end());
  }
  std::string text = preamble(parts, model, c_helpers(operations, parts.prefix)) + tables(parts);
  for (const Shape& shape : parts.shapes) text += functions_of(shape, parts.prefix);
  text += robot_functions(parts);
  if (parts.whole < 0) text += fmt::format("\n{}", joint_functions(parts));
  while (text.ends_with("\n\n")) text.pop_back();
  return text + fmt::format("\n#endif /* {}_FRICTION_H */\n", parts.prefix);
}

}  // namespace fricid::deploy
