#include "symbol.hpp"

#include <bit>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace fricid::deploy {
namespace {

double fold(Op op, double a, double b) {
  switch (op) {
    case Op::kAdd:
      return a + b;
    case Op::kSubtract:
      return a - b;
    case Op::kMultiply:
      return a * b;
    case Op::kDivide:
      return a / b;
    case Op::kNegate:
      return -a;
    case Op::kMin:
      return a < b ? a : b;
    case Op::kMax:
      return a > b ? a : b;
    case Op::kPow:
      return std::pow(a, b);
    case Op::kAbs:
      return std::fabs(a);
    case Op::kSign:
      return a > 0 ? 1 : a < 0 ? -1 : 0;
    case Op::kSqrt:
      return std::sqrt(a);
    case Op::kExp:
      return std::exp(a);
    case Op::kExpm1:
      return std::expm1(a);
    case Op::kPhi1:
      return a == 0 ? 1 : std::expm1(a) / a;
    case Op::kLog:
      return std::log(a);
    case Op::kLog1p:
      return std::log1p(a);
    case Op::kTanh:
      return std::tanh(a);
    case Op::kSoftplus:
      return (a > 0 ? a : 0) + std::log1p(std::exp(-std::fabs(a)));
    case Op::kMish:
      return a * std::tanh(std::log1p(std::exp(a)));
    case Op::kSin:
      return std::sin(a);
    case Op::kCos:
      return std::cos(a);
    default:
      throw std::logic_error("an operation that is not on numbers");
  }
}

// The step is a placeholder, so a plain double must not be computed from it.
void refuse_step(const Symbol& a) {
  if (a.is(kStep)) throw std::logic_error("a law computes with dt alone");
}

Graph* graph_of(const Symbol& a, const Symbol& b) { return a.graph() ? a.graph() : b.graph(); }

Symbol unary(Op op, const Symbol& a) {
  if (a.graph()) return {*a.graph(), a.graph()->add(op, a.in(*a.graph()))};
  refuse_step(a);
  return fold(op, a.value(), 0);
}

Symbol binary(Op op, const Symbol& a, const Symbol& b) {
  if (Graph* graph = graph_of(a, b)) {
    const int left = a.in(*graph), right = b.in(*graph);
    return {*graph, graph->add(op, left, right)};
  }
  refuse_step(a);
  refuse_step(b);
  return fold(op, a.value(), b.value());
}

Truth compare(Op op, const Symbol& a, const Symbol& b) {
  if (Graph* graph = graph_of(a, b)) {
    const int left = a.in(*graph), right = b.in(*graph);
    return {*graph, graph->add(op, left, right)};
  }
  refuse_step(a);
  refuse_step(b);
  const double x = a.value(), y = b.value();
  return Truth(op == Op::kLess ? x < y : op == Op::kLessEqual ? x <= y : x == y);
}

}  // namespace

int Graph::add(Op op, int a, int b, int c, double value) {
  const auto key = std::tuple(op, a, b, c, std::bit_cast<std::uint64_t>(value));
  const auto [known, is_new] = known_.try_emplace(key, static_cast<int>(nodes_.size()));
  if (is_new) nodes_.push_back({op, a, b, c, value});
  return known->second;
}

int Graph::add(Layer layer) {
  layers_.push_back(std::move(layer));
  return static_cast<int>(layers_.size()) - 1;
}

int Symbol::in(Graph& graph) const {
  if (graph_ == &graph) return node_;
  if (graph_) throw std::logic_error("a number of another graph");
  if (is(kStep)) return graph.add(Op::kDt);
  return graph.add(Op::kConstant, -1, -1, -1, value_);
}

Symbol operator+(const Symbol& a, const Symbol& b) {
  if (a.is(0)) return b;
  if (b.is(0)) return a;
  return binary(Op::kAdd, a, b);
}
Symbol operator-(const Symbol& a, const Symbol& b) { return binary(Op::kSubtract, a, b); }
Symbol operator*(const Symbol& a, const Symbol& b) { return binary(Op::kMultiply, a, b); }
Symbol operator/(const Symbol& a, const Symbol& b) { return binary(Op::kDivide, a, b); }
Symbol operator-(const Symbol& a) { return unary(Op::kNegate, a); }

Truth operator<(const Symbol& a, const Symbol& b) { return compare(Op::kLess, a, b); }
Truth operator<=(const Symbol& a, const Symbol& b) { return compare(Op::kLessEqual, a, b); }
Truth operator==(const Symbol& a, const Symbol& b) { return compare(Op::kEqual, a, b); }

Truth operator&(const Truth& a, const Truth& b) {
  if (a.is_constant()) return a.value() ? b : a;
  if (b.is_constant()) return b.value() ? a : b;
  return {*a.graph_, a.graph_->add(Op::kAnd, a.node_, b.node_)};
}
Truth operator|(const Truth& a, const Truth& b) {
  if (a.is_constant()) return a.value() ? a : b;
  if (b.is_constant()) return b.value() ? b : a;
  return {*a.graph_, a.graph_->add(Op::kOr, a.node_, b.node_)};
}
Truth operator!(const Truth& a) {
  if (a.is_constant()) return Truth(!a.value());
  return {*a.graph_, a.graph_->add(Op::kNot, a.node_)};
}

Symbol select(const Truth& condition, const Symbol& a, const Symbol& b) {
  if (condition.is_constant()) return condition.value() ? a : b;
  Graph& graph = *condition.graph();
  const int left = a.in(graph), right = b.in(graph);
  return {graph, graph.add(Op::kSelect, condition.node(), left, right)};
}

Symbol min(const Symbol& a, const Symbol& b) { return binary(Op::kMin, a, b); }
Symbol max(const Symbol& a, const Symbol& b) { return binary(Op::kMax, a, b); }
Symbol pow(const Symbol& a, const Symbol& b) { return binary(Op::kPow, a, b); }
Symbol abs(const Symbol& a) { return unary(Op::kAbs, a); }
Symbol sign(const Symbol& a) { return unary(Op::kSign, a); }
Symbol sqrt(const Symbol& a) { return unary(Op::kSqrt, a); }
Symbol exp(const Symbol& a) { return unary(Op::kExp, a); }
Symbol expm1(const Symbol& a) { return unary(Op::kExpm1, a); }
Symbol phi1(const Symbol& a) { return unary(Op::kPhi1, a); }
Symbol log(const Symbol& a) { return unary(Op::kLog, a); }
Symbol log1p(const Symbol& a) { return unary(Op::kLog1p, a); }
Symbol tanh(const Symbol& a) { return unary(Op::kTanh, a); }
Symbol softplus(const Symbol& a) { return unary(Op::kSoftplus, a); }
Symbol mish(const Symbol& a) { return unary(Op::kMish, a); }
SymbolSinCos sincos(const Symbol& a) { return {unary(Op::kSin, a), unary(Op::kCos, a)}; }

void write_layer(int columns, int inputs, int outputs, const Symbol* layer, const Symbol* X,
                 Symbol* Y) {
  if (layer[0].is_constant()) throw std::logic_error("a network whose weights are constants");
  Graph& graph = *layer[0].graph();
  Layer written{.parameters = graph[layer[0].in(graph)].a,
                .inputs = inputs,
                .outputs = outputs,
                .columns = columns,
                .x = {}};
  for (int i = 0; i < outputs * (inputs + 1); ++i) {
    const Node& node = graph[layer[i].in(graph)];
    if (node.op != Op::kParameter || node.a != written.parameters + i)
      throw std::logic_error("a network whose weights are not parameters in a row");
  }
  for (int i = 0; i < inputs * columns; ++i) written.x.push_back(X[i].in(graph));
  const int index = graph.add(std::move(written));
  for (int i = 0; i < outputs * columns; ++i) Y[i] = {graph, graph.add(Op::kElement, index, i)};
}

}  // namespace fricid::deploy
