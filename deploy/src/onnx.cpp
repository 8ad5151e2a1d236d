// Friction as ONNX, its state an input and an output.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>

#include "fricid/deploy/c_header.hpp"
#include "trace.hpp"
#include "writers.hpp"

namespace fricid::deploy {
namespace {

/// Bytes of a message of protocol buffers. Field numbers are those of onnx.proto.
class Message {
 public:
  void number(int field, std::uint64_t value) {
    varint(static_cast<std::uint64_t>(field) << 3);
    varint(value);
  }
  void bytes(int field, std::string_view value) {
    varint(static_cast<std::uint64_t>(field) << 3 | 2u);
    varint(value.size());
    text_ += value;
  }
  void message(int field, const Message& value) { bytes(field, value.text_); }
  const std::string& text() const { return text_; }

 private:
  void varint(std::uint64_t value) {
    for (; value > 0x7f; value >>= 7) text_ += static_cast<char>(value | 0x80u);
    text_ += static_cast<char>(value);
  }
  std::string text_;
};

constexpr int kFloat = 1, kInt64 = 7;  // TensorProto.DataType

template <class T>
std::string raw(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// A graph of ONNX. Values are columns: (batch, 1), or constants of shape (1).
class OnnxGraph {
 public:
  /// Adds a node and returns the name of its output.
  std::string node(const std::string& op, const std::vector<std::string>& inputs,
                   const std::vector<std::pair<std::string, int>>& attributes = {}) {
    const std::string output = fmt::format("x{}", next_++);
    add(op, inputs, {output}, attributes);
    return output;
  }

  void add(const std::string& op, const std::vector<std::string>& inputs,
           const std::vector<std::string>& outputs,
           const std::vector<std::pair<std::string, int>>& attributes = {}) {
    constexpr int kInt = 2;  // AttributeProto.AttributeType
    Message node;
    for (const std::string& input : inputs) node.bytes(1, input);
    for (const std::string& output : outputs) node.bytes(2, output);
    node.bytes(4, op);
    for (const auto& [name, value] : attributes) {
      Message attribute;
      attribute.bytes(1, name);
      attribute.number(3, static_cast<std::uint64_t>(value));
      attribute.number(20, kInt);
      node.message(5, attribute);
    }
    graph_.message(1, node);
  }

  std::string constant(double value) {
    const auto [known, is_new] = constants_.try_emplace(static_cast<float>(value), "");
    if (is_new) known->second = tensor({1}, std::vector<float>{static_cast<float>(value)});
    return known->second;
  }

  template <class T>
  std::string tensor(const std::vector<std::int64_t>& shape, const std::vector<T>& values) {
    const std::string name = fmt::format("c{}", next_++);
    Message tensor;
    for (const std::int64_t size : shape) tensor.number(1, static_cast<std::uint64_t>(size));
    tensor.number(2, std::is_same_v<T, float> ? kFloat : kInt64);
    tensor.bytes(8, name);
    tensor.bytes(9, raw(values));
    graph_.message(5, tensor);
    return name;
  }

  /// An input (field 11) or output (field 12) of shape (batch, columns), or (1) for columns = 0.
  void value(int field, const std::string& name, int columns) {
    Message shape, tensor, type, value;
    const auto dimension = [&](int size) {
      Message dim;
      if (size < 0)
        dim.bytes(2, "batch");
      else
        dim.number(1, static_cast<std::uint64_t>(size));
      shape.message(1, dim);
    };
    if (columns > 0) dimension(-1);
    dimension(std::max(columns, 1));
    tensor.number(1, kFloat);
    tensor.message(2, shape);
    type.message(1, tensor);
    value.bytes(1, name);
    value.message(2, type);
    graph_.message(field, value);
  }

  std::string model(const std::string& name, const std::string& about) {
    constexpr int kIrVersion = 8, kOpset = 18;  // the first with Mish
    Message opset, model;
    graph_.bytes(2, name);
    opset.number(2, kOpset);
    model.number(1, kIrVersion);
    model.bytes(2, "fricid");
    model.bytes(6, about);
    model.message(7, graph_);
    model.message(8, opset);
    return model.text();
  }

 private:
  Message graph_;
  std::map<float, std::string> constants_;
  int next_ = 0;
};

/// Names of the columns of the inputs.
struct Leaves {
  std::array<std::vector<std::string>, 4> fields;  // of every joint
  std::vector<std::string> z;
};

/// Writes the operations of a traced friction.
class OnnxWriter {
 public:
  OnnxWriter(OnnxGraph& onnx, const Graph& graph, std::span<const double> theta,
             const Leaves& leaves)
      : onnx_(onnx),
        graph_(graph),
        theta_(theta),
        leaves_(leaves),
        text_(graph.nodes().size()),
        layers_(graph.layers().size()) {}

  /// The name of a value. Operands come before what uses them, so the depth is that of the law.
  const std::string& value(int i) {
    std::string& text = text_[static_cast<std::size_t>(i)];
    if (text.empty()) text = written(graph_[i]);
    return text;
  }

 private:
  std::string written(const Node& node) {
    switch (node.op) {
      case Op::kConstant:
        return onnx_.constant(node.value);
      case Op::kDt:
        return "dt";
      case Op::kParameter:
        return onnx_.constant(theta_[static_cast<std::size_t>(node.a)]);
      case Op::kState:
        return leaves_.z[static_cast<std::size_t>(node.a)];
      case Op::kInput:
        return leaves_.fields[static_cast<std::size_t>(node.b)][static_cast<std::size_t>(node.a)];
      case Op::kExpm1:
        return expm1(value(node.a));
      case Op::kPhi1: {
        const std::string& x = value(node.a);
        const std::string rise = expm1(x), zero = onnx_.node("Equal", {x, onnx_.constant(0)});
        return onnx_.node("Where", {zero, onnx_.constant(1), onnx_.node("Div", {rise, x})});
      }
      case Op::kLog1p:
        return log1p(value(node.a));
      case Op::kElement:
        return layer(node.a)[static_cast<std::size_t>(node.b)];
      default:
        break;
    }
    std::vector<std::string> operands;
    for (const int operand : {node.a, node.b, node.c})
      if (operand >= 0) operands.push_back(value(operand));
    return onnx_.node(name_of(node.op), operands);
  }

  static const char* name_of(Op op) {
    switch (op) {
      case Op::kAdd:
        return "Add";
      case Op::kSubtract:
        return "Sub";
      case Op::kMultiply:
        return "Mul";
      case Op::kDivide:
        return "Div";
      case Op::kNegate:
        return "Neg";
      case Op::kMin:
        return "Min";
      case Op::kMax:
        return "Max";
      case Op::kPow:
        return "Pow";
      case Op::kAbs:
        return "Abs";
      case Op::kSign:
        return "Sign";
      case Op::kSqrt:
        return "Sqrt";
      case Op::kExp:
        return "Exp";
      case Op::kLog:
        return "Log";
      case Op::kTanh:
        return "Tanh";
      case Op::kSoftplus:
        return "Softplus";
      case Op::kMish:
        return "Mish";
      case Op::kSin:
        return "Sin";
      case Op::kCos:
        return "Cos";
      case Op::kLess:
        return "Less";
      case Op::kLessEqual:
        return "LessOrEqual";
      case Op::kEqual:
        return "Equal";
      case Op::kAnd:
        return "And";
      case Op::kOr:
        return "Or";
      case Op::kNot:
        return "Not";
      case Op::kSelect:
        return "Where";
      default:
        throw std::logic_error("an operation without a name in ONNX");
    }
  }

  // e^x - 1 = 2 t/(1 - t), t = tanh(x/2), without cancellation at x = 0; by exp where t is near 1.
  std::string expm1(const std::string& x) {
    const std::string one = onnx_.constant(1), two = onnx_.constant(2);
    const std::string t = onnx_.node("Tanh", {onnx_.node("Div", {x, two})});
    const std::string near =
        onnx_.node("Div", {onnx_.node("Mul", {two, t}), onnx_.node("Sub", {one, t})});
    const std::string far = onnx_.node("Sub", {onnx_.node("Exp", {x}), one});
    return onnx_.node("Where", {onnx_.node("Less", {x, one}), near, far});
  }

  // log(1 + x) = x log(u)/(u - 1), u = 1 + x rounded (Kahan).
  std::string log1p(const std::string& x) {
    const std::string one = onnx_.constant(1), u = onnx_.node("Add", {one, x});
    const std::string ratio =
        onnx_.node("Div", {onnx_.node("Log", {u}), onnx_.node("Sub", {u, one})});
    return onnx_.node("Where", {onnx_.node("Equal", {u, one}), x, onnx_.node("Mul", {x, ratio})});
  }

  // The outputs of a layer (outputs x columns), row-major.
  const std::vector<std::string>& layer(int index) {
    std::vector<std::string>& done = layers_[static_cast<std::size_t>(index)];
    if (!done.empty()) return done;
    const Layer& layer = graph_.layers()[static_cast<std::size_t>(index)];
    const auto weights = theta_.begin() + layer.parameters;
    const auto size = layer.outputs * layer.inputs;
    const std::string W =
        onnx_.tensor<float>({layer.outputs, layer.inputs}, {weights, weights + size});
    const std::string b =
        onnx_.tensor<float>({layer.outputs}, {weights + size, weights + size + layer.outputs});
    std::vector<std::string> all(static_cast<std::size_t>(layer.outputs * layer.columns));
    for (int k = 0; k < layer.columns; ++k) {
      std::vector<std::string> x, y;
      for (int c = 0; c < layer.inputs; ++c)
        x.push_back(value(layer.x[static_cast<std::size_t>(c * layer.columns + k)]));
      const std::string Y =
          onnx_.node("Gemm", {onnx_.node("Concat", x, {{"axis", 1}}), W, b}, {{"transB", 1}});
      for (int r = 0; r < layer.outputs; ++r) y.push_back(fmt::format("{}_{}", Y, r));
      onnx_.add("Split", {Y}, y, {{"axis", 1}, {"num_outputs", layer.outputs}});
      for (int r = 0; r < layer.outputs; ++r)
        all[static_cast<std::size_t>(r * layer.columns + k)] = y[static_cast<std::size_t>(r)];
    }
    layers_[static_cast<std::size_t>(index)] = all;
    return layers_[static_cast<std::size_t>(index)];
  }

  OnnxGraph& onnx_;
  const Graph& graph_;
  std::span<const double> theta_;
  const Leaves& leaves_;
  std::vector<std::string> text_;
  std::vector<std::vector<std::string>> layers_;
};

/// Whether the inputs of each joint are finite, and last whether those of all are.
std::vector<std::string> finite_inputs(OnnxGraph& onnx, const Leaves& leaves) {
  std::vector<std::string> finite;
  const std::string zero = onnx.constant(0);
  std::string all = zero;
  for (std::size_t j = 0; j < leaves.fields[0].size(); ++j) {
    std::string own = zero;
    // x - x is 0 of finite x alone
    for (const std::vector<std::string>& field : leaves.fields)
      own = onnx.node("Add", {own, onnx.node("Sub", {field[j], field[j]})});
    finite.push_back(onnx.node("Equal", {own, zero}));
    all = onnx.node("Add", {all, own});
  }
  finite.push_back(onnx.node("Equal", {all, zero}));
  return finite;
}

/// The joint that has a state; one more than there are: the whole robot has it.
int owner_of(const friction::RobotFriction& friction, int state) {
  int owner = 0;
  while (owner < friction.joint_count() && state >= friction.state_begin(owner + 1)) ++owner;
  return owner;
}

}  // namespace

Exported write_onnx(const data::ModelFile& model) {
  const friction::RobotFriction& friction = model.arm.friction.model;
  const Traced traced = trace(friction);
  const int n = friction.joint_count(), states = friction.state_size();
  constexpr std::array kFields{"q", "v", "load", "temperature"};
  OnnxGraph onnx;

  // inputs, and their columns
  const auto columns = [&](const std::string& matrix, int count) {
    onnx.value(11, matrix, count);
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) names.push_back(fmt::format("{}_{}", matrix, i));
    onnx.add("Split", {matrix}, names, {{"axis", 1}, {"num_outputs", count}});
    return names;
  };
  Leaves before;
  for (std::size_t f = 0; f < kFields.size(); ++f) before.fields[f] = columns(kFields[f], n);
  if (states > 0) before.z = columns("z", states);
  onnx.value(11, "dt", 0);

  // a constant as a column
  const std::string batch = onnx.node("Shape", {before.fields[0][0]});
  const auto matrix = [&](const std::string& name, const std::vector<std::string>& values) {
    std::vector<std::string> full;
    for (const std::string& value : values) full.push_back(onnx.node("Expand", {value, batch}));
    onnx.add("Concat", full, {name}, {{"axis", 1}});
    onnx.value(12, name, static_cast<int>(values.size()));
  };

  const std::vector<double> theta = traced_theta(model.arm.friction);
  Leaves after = before;
  if (states > 0) {
    OnnxWriter step(onnx, traced.step, theta, before);
    const std::vector<std::string> finite = finite_inputs(onnx, before);
    const std::string moves = onnx.node("Less", {onnx.constant(0), "dt"});
    for (int i = 0; i < states; ++i) {
      std::string& z = after.z[static_cast<std::size_t>(i)];
      const std::string& next = step.value(traced.z_next[static_cast<std::size_t>(i)]);
      const std::string& known = finite[static_cast<std::size_t>(owner_of(friction, i))];
      z = onnx.node("Where", {onnx.node("And", {moves, known}), next, z});
    }
  }
  OnnxWriter torque(onnx, traced.torque, theta, after);
  std::vector<std::string> tau_f;
  for (const int node : traced.tau_f) tau_f.push_back(torque.value(node));
  matrix("tau_f", tau_f);
  if (states > 0) matrix("z_next", after.z);

  const std::string name = code_name(model);
  Exported exported{
      .files = {{name + "_friction.onnx",
                 onnx.model(name, fmt::format("joint friction of {}: z_next = step(q, v, load, "
                                              "temperature, z, dt), tau_f at z_next; dt = 0 "
                                              "leaves z",
                                              title_of(model)))}},
      .losses = torques_left_out(model.arm.robot, false)};
  exported.losses.emplace_back("single precision");
  if (model.arm.robot.coupled()) exported.losses.push_back(coordinates_in_words(model.arm.robot));
  return exported;
}

}  // namespace fricid::deploy
