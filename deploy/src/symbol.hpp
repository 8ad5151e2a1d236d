// A scalar that records the operations done with it. The laws are templates on their scalar: with
// this one they yield a graph of operations, from which code in other languages is written, so
// exported code is made from the same source as the program's own.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

namespace fricid::deploy {

enum class Op {
  kConstant,   ///< value
  kDt,         ///< the step
  kParameter,  ///< theta[a]
  kState,      ///< z[a]
  kInput,      ///< field b of joint a, see Field
  kAdd,        ///< a + b
  kSubtract,
  kMultiply,
  kDivide,
  kNegate,  ///< -a
  kMin,
  kMax,
  kPow,  ///< a^b
  kAbs,
  kSign,
  kSqrt,
  kExp,
  kExpm1,
  kPhi1,  ///< (e^a - 1) / a
  kLog,
  kLog1p,
  kTanh,
  kSoftplus,
  kMish,
  kSin,
  kCos,
  kLess,  ///< from here on truths: a < b
  kLessEqual,
  kEqual,
  kAnd,
  kOr,
  kNot,
  kSelect,  ///< a ? b : c, a number
  kElement  ///< output b of layer a
};

enum class Field { kQ, kV, kLoad, kTemperature };

struct Node {
  Op op = Op::kConstant;
  int a = -1, b = -1, c = -1;
  double value = 0;
};

/// Y = W X + b of a network (friction/mlp.hpp), kept whole: row-major W (outputs x inputs) and b
/// from theta[parameters] on.
struct Layer {
  int parameters = 0;
  int inputs = 0, outputs = 0, columns = 0;
  std::vector<int> x;  ///< nodes (inputs x columns), row-major
};

/// Operations in topological order, without duplicates.
class Graph {
 public:
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<Layer>& layers() const { return layers_; }
  const Node& operator[](int i) const { return nodes_[static_cast<std::size_t>(i)]; }

  int add(Op op, int a = -1, int b = -1, int c = -1, double value = 0);
  int add(Layer layer);

 private:
  std::vector<Node> nodes_;
  std::vector<Layer> layers_;
  std::map<std::tuple<Op, int, int, int, std::uint64_t>, int> known_;
};

/// Placeholder for the step dt, which laws take as a plain number: they convert it to their scalar
/// before computing with it, which gives Op::kDt.
inline constexpr double kStep = 0x1.3c0ffee1badc5p-7;

/// A number of a graph, or a constant that belongs to no graph yet.
class Symbol {
 public:
  Symbol() = default;
  Symbol(double value) : value_(value) {}
  Symbol(Graph& graph, int node) : graph_(&graph), node_(node) {}

  bool is_constant() const { return graph_ == nullptr; }
  bool is(double value) const { return is_constant() && value_ == value; }
  double value() const { return value_; }
  Graph* graph() const { return graph_; }
  /// Its node in `graph`; a constant is added to it.
  int in(Graph& graph) const;

  friend Symbol operator+(const Symbol& a, const Symbol& b);
  friend Symbol operator-(const Symbol& a, const Symbol& b);
  friend Symbol operator*(const Symbol& a, const Symbol& b);
  friend Symbol operator/(const Symbol& a, const Symbol& b);
  friend Symbol operator-(const Symbol& a);
  Symbol& operator+=(const Symbol& b) { return *this = *this + b; }
  Symbol& operator-=(const Symbol& b) { return *this = *this - b; }
  Symbol& operator*=(const Symbol& b) { return *this = *this * b; }
  Symbol& operator/=(const Symbol& b) { return *this = *this / b; }

 private:
  Graph* graph_ = nullptr;
  int node_ = -1;
  double value_ = 0;
};

/// A truth value of a graph, or a known one.
class Truth {
 public:
  Truth() = default;
  explicit Truth(bool value) : value_(value) {}
  Truth(Graph& graph, int node) : graph_(&graph), node_(node) {}

  bool is_constant() const { return graph_ == nullptr; }
  bool value() const { return value_; }
  Graph* graph() const { return graph_; }
  int node() const { return node_; }

  friend Truth operator&(const Truth& a, const Truth& b);
  friend Truth operator|(const Truth& a, const Truth& b);
  friend Truth operator!(const Truth& a);

 private:
  Graph* graph_ = nullptr;
  int node_ = -1;
  bool value_ = false;
};

Truth operator<(const Symbol& a, const Symbol& b);
Truth operator<=(const Symbol& a, const Symbol& b);
Truth operator==(const Symbol& a, const Symbol& b);
inline Truth operator>(const Symbol& a, const Symbol& b) { return b < a; }
inline Truth operator>=(const Symbol& a, const Symbol& b) { return b <= a; }
inline Truth operator!=(const Symbol& a, const Symbol& b) { return !(a == b); }

/// Both sides of a branch are recorded.
inline bool any(const Truth& truth) { return !truth.is_constant() || truth.value(); }

Symbol select(const Truth& condition, const Symbol& a, const Symbol& b);
Symbol min(const Symbol& a, const Symbol& b);
Symbol max(const Symbol& a, const Symbol& b);
Symbol pow(const Symbol& a, const Symbol& b);
Symbol abs(const Symbol& a);
Symbol sign(const Symbol& a);
Symbol sqrt(const Symbol& a);
Symbol exp(const Symbol& a);
Symbol expm1(const Symbol& a);
Symbol phi1(const Symbol& a);
Symbol log(const Symbol& a);
Symbol log1p(const Symbol& a);
Symbol tanh(const Symbol& a);
Symbol softplus(const Symbol& a);
Symbol mish(const Symbol& a);
inline Symbol decay(const Symbol& a) { return exp(-a); }
inline Symbol clamp(const Symbol& x, const Symbol& low, const Symbol& high) {
  return min(high, max(low, x));
}
inline Symbol fma(const Symbol& a, const Symbol& b, const Symbol& c) { return a * b + c; }

struct SymbolSinCos {
  Symbol sin, cos;
};
SymbolSinCos sincos(const Symbol& a);

/// A layer of a network whose weights are consecutive parameters of `graph`.
void write_layer(int columns, int inputs, int outputs, const Symbol* layer, const Symbol* X,
                 Symbol* Y);

/// The overload of friction/mlp.hpp for this scalar.
template <int kColumns>
void dense(int inputs, int outputs, const Symbol* layer, const Symbol* X, Symbol* Y) {
  write_layer(kColumns, inputs, outputs, layer, X, Y);
}

}  // namespace fricid::deploy
