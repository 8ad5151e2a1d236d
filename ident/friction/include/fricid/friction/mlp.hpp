// Dense networks on any scalar of the engine, forward and backward: the blocks of the learned laws.
// Weights are part of the caller's theta, all memory is on the stack.
#pragma once

#include <cmath>
#include <cstddef>

#include "fricid/base/group.hpp"
#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"

namespace fricid::friction {

/// Activations: Mish x tanh(log(1 + e^x)), ReLU max(x, 0), tanh x.
enum class Activation { kMish, kRelu, kTanh };

template <Activation activation, class S>
S activate(const S& x) {
  if constexpr (activation == Activation::kMish) return mish(x);
  if constexpr (activation == Activation::kRelu) return max(x, S(0));
  if constexpr (activation == Activation::kTanh) return tanh(x);
}

/// Activates n units in place; Mish of several packs side by side.
template <Activation activation, class S>
[[gnu::noinline, gnu::flatten]] void activate_all(S* x, int n) {
  int i = 0;
  if constexpr (kIsPack<S> && activation == Activation::kMish) {
    // as many as registers hold: 32 of 64 bytes, 16 of 32
    constexpr int kSideBySide = kRegisterBytes == 64 ? 4 : 2;
    for (; i + kSideBySide <= n; i += kSideBySide) {
      using Several = Group<S, kSideBySide>;
      const auto y = activate<activation>(Several::of([&](int k) { return x[i + k]; }));
#pragma GCC unroll 4
      for (int k = 0; k < kSideBySide; ++k) x[i + k] = y.x[k];
    }
  }
  for (; i < n; ++i) x[i] = activate<activation>(x[i]);
}

/// A value with its derivative.
template <class S>
struct Sloped {
  S value, slope;
};

/// activate(x) with its derivative. Mish takes one exponential and one division for both:
/// with e = exp x and n = e (e + 2),
///
///     mish = x n/(n + 2),   mish' = n/(n + 2) + 4 x e (e + 1)/(n + 2)^2.
template <Activation activation, class S>
Sloped<S> activate_with_slope(const S& x) {
  if constexpr (activation == Activation::kMish) {
    const S e = exp(min(S(24), x));  // beyond, mish(x) = x in double precision
    const S n = e * (e + S(2));
    const S inverse = S(1) / (n + S(2));
    const S share = n * inverse;
    return {x * share, share + S(4) * x * (e * inverse) * ((e + S(1)) * inverse)};
  } else if constexpr (activation == Activation::kRelu) {
    return {max(x, S(0)), select(x > S(0), S(1), S(0))};
  } else {
    const S t = tanh(x);
    return {t, S(1) - t * t};
  }
}

/// One layer for kColumns inputs at once:  Y = W X + b.
///
/// `layer` holds W (outputs x inputs, row-major), then b (outputs); X (inputs x kColumns) and Y
/// (outputs x kColumns) are row-major. Every weight is read once for all columns, and four rows go
/// together, so that the chains of fused steps overlap.
template <int kColumns, int kRows, class S>
void dense_rows(int inputs, const S* W, const S* b, const S* X, S* Y) {
  S sum[kRows][kColumns];
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kColumns; ++k) sum[r][k] = b[r];
  for (int c = 0; c < inputs; ++c)
    for (int r = 0; r < kRows; ++r)
      for (int k = 0; k < kColumns; ++k)
        sum[r][k] = fma(W[r * inputs + c], X[c * kColumns + k], sum[r][k]);
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kColumns; ++k) Y[r * kColumns + k] = sum[r][k];
}
template <int kColumns, class S>
void dense(int inputs, int outputs, const S* layer, const S* X, S* Y) {
  constexpr int kBlock = 4;
  const S* b = layer + outputs * inputs;
  int r = 0;
  for (; r + kBlock <= outputs; r += kBlock)
    dense_rows<kColumns, kBlock>(inputs, layer + r * inputs, b + r, X, Y + r * kColumns);
  for (; r < outputs; ++r)
    dense_rows<kColumns, 1>(inputs, layer + r * inputs, b + r, X, Y + r * kColumns);
}

/// Vector-Jacobian product of `dense`: adds to the bars of W, b and X.
template <int kColumns, int kRows, class S>
void dense_rows_pullback(int inputs, const S* W, const S* X, const S* Y_bar, S* W_bar, S* b_bar,
                         S* X_bar) {
  S bar[kRows][kColumns];
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kColumns; ++k) {
      bar[r][k] = Y_bar[r * kColumns + k];
      b_bar[r] += bar[r][k];
    }
  for (int c = 0; c < inputs; ++c) {
    for (int k = 0; k < kColumns; ++k) {
      S sum = X_bar[c * kColumns + k];
      for (int r = 0; r < kRows; ++r) sum = fma(W[r * inputs + c], bar[r][k], sum);
      X_bar[c * kColumns + k] = sum;
    }
    for (int r = 0; r < kRows; ++r) {
      S sum = W_bar[r * inputs + c];
      for (int k = 0; k < kColumns; ++k) sum = fma(bar[r][k], X[c * kColumns + k], sum);
      W_bar[r * inputs + c] = sum;
    }
  }
}
template <int kColumns, class S>
void dense_pullback(int inputs, int outputs, const S* layer, const S* X, const S* Y_bar,
                    S* layer_bar, S* X_bar) {
  constexpr int kBlock = 4;
  S* b_bar = layer_bar + outputs * inputs;
  int r = 0;
  for (; r + kBlock <= outputs; r += kBlock)
    dense_rows_pullback<kColumns, kBlock>(inputs, layer + r * inputs, X, Y_bar + r * kColumns,
                                          layer_bar + r * inputs, b_bar + r, X_bar);
  for (; r < outputs; ++r)
    dense_rows_pullback<kColumns, 1>(inputs, layer + r * inputs, X, Y_bar + r * kColumns,
                                     layer_bar + r * inputs, b_bar + r, X_bar);
}

/// A layer of which only some weights act: row r of W sees the columns first(r), first(r) + step,
/// ... Weights of other columns are not read.
template <class S, class First>
void sparse_rows(int inputs, int outputs, int step, First first, const S* layer, const S* x, S* y) {
  const S* b = layer + outputs * inputs;
  for (int r = 0; r < outputs; ++r) {
    S sum = b[r];
    for (int c = first(r); c < inputs; c += step) sum = fma(layer[r * inputs + c], x[c], sum);
    y[r] = sum;
  }
}
template <class S, class First>
void sparse_rows_pullback(int inputs, int outputs, int step, First first, const S* layer,
                          const S* x, const S* y_bar, S* layer_bar, S* x_bar) {
  for (int r = 0; r < outputs; ++r) {
    const S bar = y_bar[r];
    layer_bar[outputs * inputs + r] += bar;
    for (int c = first(r); c < inputs; c += step) {
      const int at = r * inputs + c;
      x_bar[c] = fma(layer[at], bar, x_bar[c]);
      layer_bar[at] = fma(bar, x[c], layer_bar[at]);
    }
  }
}

/// The same by columns: column c of W is seen by the rows first(c), first(c) + step, ...
template <class S, class First>
void sparse_columns(int inputs, int outputs, int step, First first, const S* layer, const S* x,
                    S* y) {
  for (int r = 0; r < outputs; ++r) y[r] = layer[outputs * inputs + r];
  for (int c = 0; c < inputs; ++c)
    for (int r = first(c); r < outputs; r += step) y[r] = fma(layer[r * inputs + c], x[c], y[r]);
}
template <class S, class First>
void sparse_columns_pullback(int inputs, int outputs, int step, First first, const S* layer,
                             const S* x, const S* y_bar, S* layer_bar, S* x_bar) {
  for (int r = 0; r < outputs; ++r) layer_bar[outputs * inputs + r] += y_bar[r];
  for (int c = 0; c < inputs; ++c)
    for (int r = first(c); r < outputs; r += step) {
      const int at = r * inputs + c;
      x_bar[c] = fma(layer[at], y_bar[r], x_bar[c]);
      layer_bar[at] = fma(y_bar[r], x[c], layer_bar[at]);
    }
}

/// Layers in which every unit sees all of those below.
struct Dense {
  template <int kColumns, class S>
  static void layer(int, int inputs, int outputs, const S* layer, const S* X, S* Y) {
    dense<kColumns>(inputs, outputs, layer, X, Y);
  }
  template <int kColumns, class S>
  static void layer_pullback(int, int inputs, int outputs, const S* layer, const S* X,
                             const S* Y_bar, S* layer_bar, S* X_bar) {
    dense_pullback<kColumns>(inputs, outputs, layer, X, Y_bar, layer_bar, X_bar);
  }
};

/// Template argument for a size that is given to the constructor.
inline constexpr int kAtRunTime = 0;

/// A network with kHidden layers of `width` units,
///
///     h_0 = x,   h_l = activation(W_l h_{l-1} + b_l), l = 1 .. kHidden,   y = W h_kHidden + b,
///
/// for kColumns inputs at once. Arrays are row-major: x (kInputs x kColumns), y (kOutputs x
/// kColumns); weights (weight_count) are the layers in order, each W then b. kInputs and kOutputs
/// may be kAtRunTime. `wiring` evaluates layer l (kHidden: the output), see Dense.
template <Activation activation, int kInputs, int kHidden, int kOutputs, int kMostWidth>
class Mlp {
 public:
  static_assert(kInputs >= 0 && kHidden > 0 && kOutputs >= 0 && kMostWidth > 0);

  /// @param width  units per hidden layer, 1 .. kMostWidth
  explicit constexpr Mlp(int width, int inputs = kInputs, int outputs = kOutputs)
      : width_(width), inputs_(inputs), outputs_(outputs) {}

  constexpr int width() const { return width_; }
  constexpr int weight_count() const { return hidden_begin(kHidden) + (width_ + 1) * outputs(); }

  /// Intermediate values that `pullback` needs: units and the slopes of their activations.
  template <int kColumns, class S>
  struct Tape {
    S unit[kHidden][kMostWidth * kColumns];
    S slope[kHidden][kMostWidth * kColumns];
  };

  template <int kColumns, class S, class Wiring = Dense>
  void forward(const S* weights, const S* x, S* y, const Wiring& wiring = {}) const {
    S units[2][kMostWidth * kColumns];
    const S* last = x;
    for (int l = 0; l < kHidden; ++l) {
      S* next = units[l % 2];
      wiring.template layer<kColumns>(l, inputs_of(l), width_, weights + hidden_begin(l), last,
                                      next);
      activate_all<activation>(next, width_ * kColumns);
      last = next;
    }
    wiring.template layer<kColumns>(kHidden, width_, outputs(), weights + hidden_begin(kHidden),
                                    last, y);
  }

  /// kNets networks with weights and inputs of their own, one after the other in `weights`, x and
  /// y, each for one input: layer by layer, so that they share the processor.
  template <int kNets, class S>
  void forward_each(const S* weights, const S* x, S* y) const {
    S units[2][kNets * kMostWidth];
    const S* last = x;
    int size = inputs();  // of one network in `last`
    const auto layer = [&](int l, int outputs, S* next) {
      for (int k = 0; k < kNets; ++k)
        dense<1>(size, outputs, weights + k * weight_count() + hidden_begin(l), last + k * size,
                 next + k * outputs);
      size = outputs;
    };
    for (int l = 0; l < kHidden; ++l) {
      S* next = units[l % 2];
      layer(l, width_, next);
      activate_all<activation>(next, kNets * width_);
      last = next;
    }
    layer(kHidden, outputs(), y);
  }

  /// `forward`, recording the tape.
  template <int kColumns, class S, class Wiring = Dense>
  [[gnu::noinline]] void forward(const S* weights, const S* x, S* y, Tape<kColumns, S>& tape,
                                 const Wiring& wiring = {}) const {
    const S* last = x;
    for (int l = 0; l < kHidden; ++l) {
      S* unit = tape.unit[l];
      wiring.template layer<kColumns>(l, inputs_of(l), width_, weights + hidden_begin(l), last,
                                      unit);
      for (int i = 0; i < width_ * kColumns; ++i) {
        const Sloped<S> a = activate_with_slope<activation>(unit[i]);
        unit[i] = a.value;
        tape.slope[l][i] = a.slope;
      }
      last = unit;
    }
    wiring.template layer<kColumns>(kHidden, width_, outputs(), weights + hidden_begin(kHidden),
                                    last, y);
  }

  /// Vector-Jacobian product at the x of `tape`: adds to weights_bar and x_bar.
  template <int kColumns, class S, class Wiring = Dense>
  [[gnu::noinline]] void pullback(const S* weights, const S* x, const Tape<kColumns, S>& tape,
                                  const S* y_bar, S* weights_bar, S* x_bar,
                                  const Wiring& wiring = {}) const {
    const int units = width_ * kColumns;
    S bars[2][kMostWidth * kColumns];
    S* bar = bars[0];
    for (int i = 0; i < units; ++i) bar[i] = S(0);
    const int output = hidden_begin(kHidden);
    wiring.template layer_pullback<kColumns>(kHidden, width_, outputs(), weights + output,
                                             tape.unit[kHidden - 1], y_bar, weights_bar + output,
                                             bar);
    for (int l = kHidden - 1; l > 0; --l) {
      S* below = bars[(kHidden - l) % 2];
      for (int i = 0; i < units; ++i) {
        bar[i] *= tape.slope[l][i];
        below[i] = S(0);
      }
      const int begin = hidden_begin(l);
      wiring.template layer_pullback<kColumns>(l, width_, width_, weights + begin, tape.unit[l - 1],
                                               bar, weights_bar + begin, below);
      bar = below;
    }
    for (int i = 0; i < units; ++i) bar[i] *= tape.slope[0][i];
    wiring.template layer_pullback<kColumns>(0, inputs(), width_, weights, x, bar, weights_bar,
                                             x_bar);
  }

  /// Random initial weights: W ~ N(0, 1/inputs of the layer), the last layer times `output_scale`,
  /// b = 0. Draws weight_count() - biases numbers.
  void initialise(double* weights, Rng& rng, double output_scale) const {
    for (int l = 0; l <= kHidden; ++l) {
      const int inputs = inputs_of(l), outputs = l < kHidden ? width_ : this->outputs();
      const double scale = (l < kHidden ? 1 : output_scale) / std::sqrt(inputs);
      double* layer = weights + hidden_begin(l);
      for (int i = 0; i < inputs * outputs; ++i) layer[i] = scale * rng.normal();
      for (int i = 0; i < outputs; ++i) layer[inputs * outputs + i] = 0;
    }
  }

 private:
  // known to the compiler where they are template arguments
  constexpr int inputs() const { return kInputs == kAtRunTime ? inputs_ : kInputs; }
  constexpr int outputs() const { return kOutputs == kAtRunTime ? outputs_ : kOutputs; }
  constexpr int inputs_of(int layer) const { return layer == 0 ? inputs() : width_; }
  // where the weights of a layer begin; layer kHidden is the output
  constexpr int hidden_begin(int layer) const {
    return layer == 0 ? 0 : (inputs() + 1) * width_ + (layer - 1) * (width_ + 1) * width_;
  }

  int width_, inputs_, outputs_;
};

}  // namespace fricid::friction
