#include "fricid/deploy/c_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <vector>

#include "c_shape.hpp"
#include "c_text.hpp"
#include "writers.hpp"

namespace fricid::deploy {
namespace {

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

// What a law reads.
std::set<Field> fields_of(const Shape& shape) {
  std::set<Field> fields = shape.torque.fields;
  if (shape.has_step()) fields.insert(shape.step.fields.begin(), shape.step.fields.end());
  return fields;
}

// What a function of some laws reads.
std::set<Field> fields_of(bool step, const std::vector<const Shape*>& shapes) {
  std::set<Field> all;
  for (const Shape* shape : shapes)
    if (!step || shape->has_step()) all.merge(fields_of(*shape));
  return all;
}

// "(void)q;" for inputs that this model does not read.
std::string unread(bool step, const std::vector<const Shape*>& shapes) {
  std::string text;
  const std::set<Field> fields = fields_of(step, shapes);
  const bool moves = step && std::ranges::any_of(shapes, &Shape::has_step);
  if (step && !moves) text += "  (void)s;\n";
  for (const Field field : {Field::kQ, Field::kV, Field::kLoad, Field::kTemperature})
    if (!fields.contains(field))
      text += fmt::format("  (void){};\n", kFieldNames[static_cast<int>(field)]);
  if (step && !moves) text += "  (void)dt;\n";
  return text;
}

// "isfinite(v[0]) && isfinite(load[0])": that the inputs that are read can be used.
std::string finite(const std::set<Field>& fields, const std::string& index) {
  std::string condition;
  for (const Field field : fields)
    condition += fmt::format("{}isfinite({}{})", condition.empty() ? "" : " && ",
                             kFieldNames[static_cast<int>(field)], index);
  return condition;
}

// A statement of one joint, where its inputs can be used.
std::string if_finite(const std::set<Field>& fields, const std::string& index,
                      const std::string& statement) {
  if (fields.empty()) return statement;
  return fmt::format("if ({}) {}", finite(fields, index), statement);
}

// Statements of the robot: a law of the whole robot needs the inputs of every joint.
std::string if_all_finite(const Parts& parts, const std::set<Field>& fields,
                          const std::string& statements) {
  if (parts.whole < 0 || fields.empty() || statements.empty()) return statements;
  return fmt::format(
      "  int known = 1, i;\n  for (i = 0; i < {}; ++i) known = known && {};\n  if (known) {{\n{}"
      "  }}\n",
      parts.n(), finite(fields, "[i]"), statements);
}

// Ends a function where a step is none.
std::string no_step(const std::string& prefix) {
  return fmt::format("  if (!(dt > {}_R(0.0) && isfinite(dt))) return;\n", prefix);
}

std::string joint_functions(const Parts& parts) {
  const std::string& p = parts.prefix;
  std::vector<const Shape*> shapes;
  std::string torques, steps;
  for (int j = 0; j < parts.n(); ++j)
    if (const Shape* shape = parts.of(j)) {
      shapes.push_back(shape);
      torques += fmt::format(
          "    case {}: {} break;\n", j,
          if_finite(fields_of(*shape), "",
                    fmt::format("s->tau_f[{}] = {});", j, call(parts, *shape, j, false, ""))));
      if (shape->has_step())
        steps += fmt::format(
            "    case {}: {} break;\n", j,
            if_finite(fields_of(*shape), "", call(parts, *shape, j, true, "") + ", dt);"));
    }
  const std::string inputs =
      fmt::format("{0}_real q, {0}_real v, {0}_real load, {0}_real temperature", p);
  std::string text = fmt::format(
      "/* The same for one joint, 0 .. {2}. */\n"
      "static inline {0}_real {0}_joint_torque({0}_state *s, int joint, {1}) {{\n{3}"
      "  switch (joint) {{\n{4}    default: return {0}_R(0.0);\n  }}\n"
      "  return s->tau_f[joint];\n}}\n\n",
      p, inputs, parts.n() - 1, unread(false, shapes), torques);
  text += fmt::format(
      "static inline void {0}_joint_step({0}_state *s, int joint, {1}, {0}_real dt) {{\n{2}", p,
      inputs, unread(true, shapes));
  if (steps.empty()) return text + "  (void)joint;\n}\n\n";
  return text + fmt::format("{}  switch (joint) {{\n{}    default: break;\n  }}\n}}\n\n",
                            no_step(p), steps);
}

std::string robot_functions(const Parts& parts) {
  const std::string& p = parts.prefix;
  std::vector<const Shape*> shapes;
  std::string torques, steps;
  const auto line = [](const std::string& statement) { return "  " + statement + "\n"; };
  for (int j = 0; j < parts.n(); ++j) {
    const Shape* shape = parts.of(j);
    const std::string index = fmt::format("[{}]", j), torque = fmt::format("s->tau_f[{}] = ", j);
    if (!shape) {
      torques += line(torque + p + "_R(0.0);");
      continue;
    }
    shapes.push_back(shape);
    torques += line(
        if_finite(fields_of(*shape), index, torque + call(parts, *shape, j, false, index) + ");"));
    if (shape->has_step())
      steps +=
          line(if_finite(fields_of(*shape), index, call(parts, *shape, j, true, index) + ", dt);"));
  }
  if (parts.whole >= 0) {
    const Shape& shape = parts.shapes.back();
    shapes.push_back(&shape);
    const std::string torque = call(parts, shape, -1, false, "");
    torques += line(torque + (torque.back() == '(' ? "" : ", ") + "s->tau_f);");
    if (shape.has_step()) steps += line(call(parts, shape, -1, true, "") + ", dt);");
  }
  const std::string inputs = fmt::format(
      "const {0}_real *q, const {0}_real *v,\n    const {0}_real *load, const {0}_real "
      "*temperature",
      p);
  return fmt::format(
             "/* tau_f[{1}]: friction torque of every joint [N m], > 0 resists v > 0. */\n"
             "static inline void {0}_torque({0}_state *s, {2},\n    {0}_real *tau_f) {{\n"
             "  int j;\n{3}{4}  for (j = 0; j < {1}; ++j) tau_f[j] = s->tau_f[j];\n}}\n\n",
             p, parts.n(), inputs, unread(false, shapes),
             if_all_finite(parts, fields_of(false, shapes), torques)) +
         fmt::format(
             "/* Moves the states by dt [s] with the inputs held; dt <= 0 moves nothing. */\n"
             "static inline void {0}_step({0}_state *s, {1},\n    {0}_real dt) {{\n{2}{3}{4}}}\n",
             p, inputs, unread(true, shapes), steps.empty() ? "" : no_step(p),
             if_all_finite(parts, fields_of(true, shapes), steps));
}

std::string preamble(const Parts& parts, const data::ModelFile& model, const std::string& helpers) {
  const std::string& p = parts.prefix;
  const int states = parts.friction.model.state_size();
  std::string read;
  for (const Field field : {Field::kQ, Field::kV, Field::kLoad, Field::kTemperature})
    if (parts.reads(field))
      read += fmt::format("{}{}", read.empty() ? "" : ", ", kFieldNames[static_cast<int>(field)]);
  std::string text = c_comment(fmt::format("Joint friction of model {} ({}), written by fricid.",
                                           model.name, title_of(model))) +
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
      " * Inputs that are not finite leave state and torque of {2} as they were.\n"
      " * double, or float where FRICID_FLOAT is defined. Needs C99 and <math.h> alone.\n"
      " */\n",
      p, read.empty() ? "nothing" : read, parts.whole < 0 ? "their joint" : "all joints");
  if (model.arm.robot.coupled())
    text += c_comment("Coupled motors: " + coordinates_in_words(model.arm.robot) + ".") + "\n";
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
      "/* States of the friction, all zero: bristles at rest; and its last torque. */\n"
      "typedef struct {{\n  {0}_real z[{1}], tau_f[{2}];\n}} {0}_state;\n\n"
      "static inline void {0}_init({0}_state *s) {{\n  int i;\n"
      "  for (i = 0; i < {1}; ++i) s->z[i] = {0}_R(0.0);\n"
      "  for (i = 0; i < {2}; ++i) s->tau_f[i] = {0}_R(0.0);\n}}\n\n"
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
  const Parts parts = parts_of(model, code_name(model));
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
