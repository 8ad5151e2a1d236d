#include "c_function.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <optional>

namespace fricid::deploy {
namespace {

constexpr std::size_t kLongest = 72;  // characters of an expression that is inlined

bool is_truth(Op op) { return op >= Op::kLess && op <= Op::kNot; }

/// The text of a helper; @ is the prefix.
struct Helper {
  Op op;
  const char* name;
  const char* text;
};
constexpr Helper kHelpers[] = {
    {Op::kMin, "min",
     "static inline @_real @_min(@_real a, @_real b) {\n  return a < b ? a : b;\n}\n"},
    {Op::kMax, "max",
     "static inline @_real @_max(@_real a, @_real b) {\n  return a > b ? a : b;\n}\n"},
    {Op::kSign, "sign",
     "static inline @_real @_sign(@_real x) {\n"
     "  return x > @_R(0.0) ? @_R(1.0) : x < @_R(0.0) ? @_R(-1.0) : "
     "@_R(0.0);\n}\n"},
    {Op::kPhi1, "phi1",
     "/* (exp(x) - 1) / x */\n"
     "static inline @_real @_phi1(@_real x) {\n"
     "  const @_real rise = @_F(expm1)(x);\n"
     "  return x < @_R(0.0) || x > @_R(0.0) ? rise / x : @_R(1.0);\n}\n"},
    {Op::kSoftplus, "softplus",
     "/* log(1 + exp(x)) */\n"
     "static inline @_real @_softplus(@_real x) {\n"
     "  return (x > @_R(0.0) ? x : @_R(0.0)) + "
     "@_F(log1p)(@_F(exp)(-@_F(fabs)(x)));\n}\n"},
    {Op::kMish, "mish",
     "/* x tanh(log(1 + exp(x))); beyond 24 it is x */\n"
     "static inline @_real @_mish(@_real x) {\n"
     "  const @_real e = @_F(exp)(x < @_R(24.0) ? x : @_R(24.0));\n"
     "  const @_real n = e * (e + @_R(2.0));\n"
     "  return x * (n / (n + @_R(2.0)));\n}\n"},
    {Op::kElement, "layer",
     "/* y = W x + b for `columns` inputs one after the other; layer: W by columns, then b */\n"
     "static inline void @_layer(const @_real *layer, const @_real *x, int inputs, int outputs,\n"
     "                                int columns, @_real *y) {\n"
     "  int k, r, c;\n"
     "  for (k = 0; k < columns; ++k, x += inputs, y += outputs) {\n"
     "    const @_real *w = layer;\n"
     "    for (r = 0; r < outputs; ++r) y[r] = layer[inputs * outputs + r];\n"
     "    for (c = 0; c < inputs; ++c, w += outputs)\n"
     "      for (r = 0; r < outputs; ++r) y[r] += w[r] * x[c];\n"
     "  }\n}\n"},
};

const char* function_of(Op op) {
  switch (op) {
    case Op::kPow:
      return "pow";
    case Op::kAbs:
      return "fabs";
    case Op::kSqrt:
      return "sqrt";
    case Op::kExp:
      return "exp";
    case Op::kExpm1:
      return "expm1";
    case Op::kLog:
      return "log";
    case Op::kLog1p:
      return "log1p";
    case Op::kTanh:
      return "tanh";
    case Op::kSin:
      return "sin";
    case Op::kCos:
      return "cos";
    default:
      return nullptr;
  }
}

const char* infix_of(Op op) {
  switch (op) {
    case Op::kAdd:
      return "+";
    case Op::kSubtract:
      return "-";
    case Op::kMultiply:
      return "*";
    case Op::kDivide:
      return "/";
    case Op::kLess:
      return "<";
    case Op::kLessEqual:
      return "<=";
    case Op::kAnd:
      return "&&";
    case Op::kOr:
      return "||";
    default:
      return nullptr;
  }
}

// An expression without its outer parentheses.
std::string bare(const std::string& text) {
  if (text.empty() || text.front() != '(' || text.back() != ')') return text;
  int depth = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
    if (depth == 0) return text;
  }
  return text.substr(1, text.size() - 2);
}

class Writer {
 public:
  Writer(const Graph& graph, const std::vector<int>& outputs, const LeafNames& names)
      : graph_(graph), names_(names), p_(names.prefix) {
    const std::size_t size = graph.nodes().size();
    live_.resize(size);
    uses_.resize(size);
    user_.resize(size, -1);
    text_.resize(size);
    for (const int output : outputs) use(output, -1);
    for (std::size_t i = size; i-- > 0;)
      if (live_[i]) visit_operands(static_cast<int>(i));
    for (std::size_t i = 0; i < size; ++i)
      if (live_[i] && text_[i].empty()) write(static_cast<int>(i));
    for (const int output : outputs) body_.outputs.push_back(bare(text(output)));
  }

  CBody take() { return std::move(body_); }

 private:
  std::size_t at(int i) const { return static_cast<std::size_t>(i); }
  const std::string& text(int node) const { return text_[at(node)]; }

  void use(int node, int user) {
    live_[at(node)] = true;
    ++uses_[at(node)];
    user_[at(node)] = user;
  }

  void visit_operands(int i) {
    const Node& node = graph_[i];
    if (node.op == Op::kElement) {
      if (!layers_.try_emplace(node.a).second) return;
      for (const int x : graph_.layers()[at(node.a)].x) use(x, i);
      return;
    }
    if (node.op <= Op::kInput) return;
    for (const int operand : {node.a, node.b, node.c})
      if (operand >= 0) use(operand, i);
  }

  void write(int i) {
    const Node& node = graph_[i];
    if (node.op == Op::kElement) return write_layer(node.a);
    if (node.op <= Op::kInput) {
      text_[at(i)] = leaf(node);
      return;
    }
    const std::string expression = expression_of(node);
    if (uses_[at(i)] == 1 && expression.size() <= kLongest) {
      text_[at(i)] = expression;
      return;
    }
    const bool truth = is_truth(node.op);
    text_[at(i)] = fmt::format("{}{}", truth ? "b" : "t", next_++);
    body_.statements += fmt::format("  const {} {} = {};\n", truth ? "int" : p_ + "_real", text(i),
                                    bare(expression));
  }

  std::string leaf(const Node& node) {
    switch (node.op) {
      case Op::kConstant:
        return c_number(node.value, p_);
      case Op::kDt:
        return "dt";
      case Op::kParameter: {
        body_.parameters = true;
        const std::string& name = names_.parameters[at(node.a)];
        if (name.empty()) return fmt::format("p[{}]", node.a);
        body_.statements += fmt::format("  const {}_real {} = p[{}];\n", p_, name, node.a);
        return name;
      }
      case Op::kState:
        body_.states = true;
        return fmt::format("z[{}]", node.a);
      default: {
        body_.fields.insert(static_cast<Field>(node.b));
        const char* name = kFieldNames[node.b];
        return names_.whole_robot ? fmt::format("{}[{}]", name, node.a) : std::string(name);
      }
    }
  }

  std::string expression_of(const Node& node) {
    if (const char* infix = infix_of(node.op))
      return fmt::format("({} {} {})", text(node.a), infix, text(node.b));
    if (const char* function = function_of(node.op)) {
      if (node.op == Op::kPow)
        return fmt::format("{}_F({})({}, {})", p_, function, bare(text(node.a)),
                           bare(text(node.b)));
      return fmt::format("{}_F({})({})", p_, function, bare(text(node.a)));
    }
    switch (node.op) {
      case Op::kNegate:
        return fmt::format("(-{})", text(node.a));
      case Op::kNot:
        return fmt::format("(!{})", text(node.a));
      case Op::kEqual:  // avoids the compiler warning for ==
        return fmt::format("({0} <= {1} && {0} >= {1})", text(node.a), text(node.b));
      case Op::kSelect:
        return fmt::format("({} ? {} : {})", text(node.a), text(node.b), text(node.c));
      default:
        break;
    }
    body_.helpers.insert(node.op);
    for (const Helper& helper : kHelpers)
      if (helper.op == node.op)
        return node.b < 0 ? fmt::format("{}_{}({})", p_, helper.name, bare(text(node.a)))
                          : fmt::format("{}_{}({}, {})", p_, helper.name, bare(text(node.a)),
                                        bare(text(node.b)));
    return {};
  }

  // The node of the activation that every output of a layer goes through, as a pattern.
  struct Activation {
    Op op;
    int b;
    bool operator==(const Activation&) const = default;
  };
  std::optional<Activation> activation_of(const std::vector<int>& elements) const {
    std::optional<Activation> common;
    for (const int element : elements) {
      if (element < 0 || uses_[at(element)] != 1 || user_[at(element)] < 0) return {};
      const Node& user = graph_[user_[at(element)]];
      if (user.op != Op::kMish && user.op != Op::kTanh && user.op != Op::kMax) return {};
      if (user.a != element) return {};
      if (user.op == Op::kMax && graph_[user.b].op != Op::kConstant) return {};
      const Activation own{user.op, user.b};
      if (common && !(*common == own)) return {};
      common = own;
    }
    return common;
  }

  void write_layer(int index) {
    const Layer& layer = graph_.layers()[at(index)];
    body_.parameters = true;
    body_.helpers.insert(Op::kElement);
    const int number = next_++;
    const std::string y = fmt::format("y{}", number);

    // inputs: the outputs of the layer before as they are, or gathered
    std::vector<std::string> inputs(layer.x.size());
    for (int c = 0; c < layer.inputs; ++c)
      for (int k = 0; k < layer.columns; ++k)
        inputs[at(k * layer.inputs + c)] = bare(text(layer.x[at(c * layer.columns + k)]));
    std::string x = array_of(inputs);
    if (x.empty()) {
      x = fmt::format("x{}", number);
      std::string list;
      for (const std::string& value : inputs) {
        const std::size_t line =
            list.size() - (list.rfind('\n') == std::string::npos ? 0 : list.rfind('\n') + 1);
        list += (list.empty() ? "" : line + value.size() > 90 ? ",\n      " : ", ") + value;
      }
      body_.statements +=
          fmt::format("  const {}_real {}[{}] = {{{}}};\n", p_, x, inputs.size(), list);
    }
    const int size = layer.outputs * layer.columns;
    body_.statements += fmt::format("  {0}_real {1}[{2}];\n", p_, y, size);
    pending_ += fmt::format("  {}_layer(p + {}, {}, {}, {}, {}, {});\n", p_, layer.parameters, x,
                            layer.inputs, layer.outputs, layer.columns, y);

    // outputs, through their activation where all have the same
    std::vector<int> elements(at(size), -1);
    for (std::size_t i = 0; i < graph_.nodes().size(); ++i)
      if (live_[i] && graph_.nodes()[i].op == Op::kElement && graph_.nodes()[i].a == index)
        elements[at(graph_.nodes()[i].b)] = static_cast<int>(i);
    const auto place = [&](int element) {
      return fmt::format("{}[{}]", y,
                         element % layer.columns * layer.outputs + element / layer.columns);
    };
    const std::optional<Activation> activation = activation_of(elements);
    for (int e = 0; e < size; ++e) {
      if (elements[at(e)] < 0) continue;
      text_[at(elements[at(e)])] = place(e);
      if (activation) text_[at(user_[at(elements[at(e)])])] = place(e);
    }
    if (activation) {
      const std::string old = fmt::format("{}[i]", y);
      std::string value;
      if (activation->op == Op::kTanh)
        value = fmt::format("{}_F(tanh)({})", p_, old);
      else if (activation->op == Op::kMish)
        value = fmt::format("{}_mish({})", p_, old);
      else
        value = fmt::format("{}_max({}, {})", p_, old, c_number(graph_[activation->b].value, p_));
      if (activation->op != Op::kTanh) body_.helpers.insert(activation->op);
      pending_ += fmt::format("  for (i = 0; i < {}; ++i) {} = {};\n", size, old, value);
      body_.loops = true;
    }
    body_.statements += pending_;
    pending_.clear();
  }

  // The name of an array whose elements are these, all in their order; empty: there is none.
  static std::string array_of(const std::vector<std::string>& values) {
    const std::string name = values[0].substr(0, values[0].find('['));
    if (name[0] != 'y') return {};
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i] != fmt::format("{}[{}]", name, i)) return {};
    return name;
  }

  const Graph& graph_;
  const LeafNames& names_;
  const std::string& p_;
  std::vector<bool> live_;
  std::vector<int> uses_, user_;
  std::vector<std::string> text_;  // of nodes that are written
  std::map<int, bool> layers_;     // that are used
  std::string pending_;
  int next_ = 1;
  CBody body_;
};

}  // namespace

CBody write_body(const Graph& graph, const std::vector<int>& outputs, const LeafNames& names) {
  return Writer(graph, outputs, names).take();
}

std::string c_helpers(const std::set<Op>& operations, const std::string& prefix) {
  std::string result;
  for (const Helper& helper : kHelpers) {
    if (!operations.contains(helper.op)) continue;
    for (const char c : std::string_view(helper.text))
      result += c == '@' ? prefix : std::string(1, c);
    result += '\n';
  }
  return result;
}

std::string c_number(double value, const std::string& prefix) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return fmt::format("{}_R({})", prefix, text);
}

}  // namespace fricid::deploy
