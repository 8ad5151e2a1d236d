#include "fricid/deploy/c_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <vector>

#include "c_shape.hpp"
#include "c_text.hpp"

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

// "(void)q;" for inputs that this model does not read.
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
