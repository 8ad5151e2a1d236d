// Layers of plain recurrent units on any scalar of the engine, forward and backward.
#pragma once

#include <cmath>

#include "fricid/base/rng.hpp"
#include "fricid/friction/mlp.hpp"

namespace fricid::friction {

/// kLayers stacked recurrent layers of `width` units and a linear output,
///
///     g_l = activation(W_l u_l + U_l h_l + b_l),   u_1 = x,   u_{l+1} = g_l,
///     y   = W g_kLayers + b,
///
/// where h is the memory of the layers and g their next memory (kLayers x width, row by row).
/// Weights (weight_count) are the layers in order, each (W U) row by row, then b.
template <Activation activation, int kLayers, int kMostWidth, int kMostInputs>
class RecurrentNet {
 public:
  static_assert(kLayers > 0 && kMostWidth > 0 && kMostInputs > 0);

  /// @param width   units per layer, 1 .. kMostWidth
  /// @param inputs  1 .. kMostInputs
  constexpr RecurrentNet(int width, int inputs, int outputs)
      : width_(width), inputs_(inputs), outputs_(outputs) {}

  constexpr int memory_size() const { return kLayers * width_; }
  constexpr int weight_count() const { return layer_begin(kLayers) + (width_ + 1) * outputs_; }

  static constexpr int kMostRow =
      (kMostInputs > kMostWidth ? kMostInputs : kMostWidth) + kMostWidth;

  /// Intermediate values that `remember_pullback` needs.
  template <class S>
  struct Tape {
    S input[kLayers][kMostRow];  // (u_l, h_l)
    S slope[kLayers][kMostWidth];
  };

  /// g (memory_size) from x (inputs) and h (memory_size).
  template <class S>
  [[gnu::noinline]] void remember(const S* weights, const S* x, const S* h, S* g,
                                  Tape<S>& tape) const {
    for (int l = 0; l < kLayers; ++l) {
      const int inputs = inputs_of(l);
      const S* u = l == 0 ? x : g + (l - 1) * width_;
      S* row = tape.input[l];
      for (int i = 0; i < inputs; ++i) row[i] = u[i];
      for (int i = 0; i < width_; ++i) row[inputs + i] = h[l * width_ + i];
      S* out = g + l * width_;
      dense<1>(inputs + width_, width_, weights + layer_begin(l), row, out);
      for (int i = 0; i < width_; ++i) {
        const Sloped<S> a = activate_with_slope<activation>(out[i]);
        out[i] = a.value;
        tape.slope[l][i] = a.slope;
      }
    }
  }

  /// y (outputs) from g.
  template <class S>
  void say(const S* weights, const S* g, S* y) const {
    dense<1>(width_, outputs_, weights + layer_begin(kLayers), last(g), y);
  }

  /// Vector-Jacobian product of `say`: adds to weights_bar and g_bar.
  template <class S>
  void say_pullback(const S* weights, const S* g, const S* y_bar, S* weights_bar, S* g_bar) const {
    const int begin = layer_begin(kLayers);
    dense_pullback<1>(width_, outputs_, weights + begin, last(g), y_bar, weights_bar + begin,
                      g_bar + (kLayers - 1) * width_);
  }

  /// Vector-Jacobian product of `remember`: adds to weights_bar, x_bar and h_bar. g_bar is
  /// overwritten.
  template <class S>
  [[gnu::noinline]] void remember_pullback(const S* weights, const Tape<S>& tape, S* g_bar,
                                           S* weights_bar, S* x_bar, S* h_bar) const {
    for (int l = kLayers; l-- > 0;) {
      const int inputs = inputs_of(l), begin = layer_begin(l);
      S* bar = g_bar + l * width_;
      for (int i = 0; i < width_; ++i) bar[i] *= tape.slope[l][i];
      S row_bar[kMostRow];
      for (int i = 0; i < inputs + width_; ++i) row_bar[i] = S(0);
      dense_pullback<1>(inputs + width_, width_, weights + begin, tape.input[l], bar,
                        weights_bar + begin, row_bar);
      S* u_bar = l == 0 ? x_bar : g_bar + (l - 1) * width_;
      for (int i = 0; i < inputs; ++i) u_bar[i] += row_bar[i];
      for (int i = 0; i < width_; ++i) h_bar[l * width_ + i] += row_bar[inputs + i];
    }
  }

  /// Random initial weights: W_l ~ N(0, 1/inputs of the layer), U_l ~ N(0, 1/(3 width)), so that
  /// memory fades, the output's W times `output_scale`, b = 0.
  void initialise(double* weights, Rng& rng, double output_scale) const {
    for (int l = 0; l < kLayers; ++l) {
      double* at = weights + layer_begin(l);
      for (int r = 0; r < width_; ++r) {
        for (int c = 0; c < inputs_of(l); ++c) *at++ = rng.normal() / std::sqrt(inputs_of(l));
        for (int c = 0; c < width_; ++c) *at++ = rng.normal() / std::sqrt(3.0 * width_);
      }
      for (int r = 0; r < width_; ++r) *at++ = 0;
    }
    double* at = weights + layer_begin(kLayers);
    for (int i = 0; i < outputs_ * width_; ++i)
      *at++ = output_scale * rng.normal() / std::sqrt(width_);
    for (int i = 0; i < outputs_; ++i) *at++ = 0;
  }

 private:
  template <class S>
  auto* last(S* g) const {
    return g + (kLayers - 1) * width_;
  }
  constexpr int inputs_of(int layer) const { return layer == 0 ? inputs_ : width_; }
  constexpr int layer_begin(int layer) const {
    return layer == 0 ? 0
                      : (inputs_ + width_ + 1) * width_ + (layer - 1) * (2 * width_ + 1) * width_;
  }

  int width_, inputs_, outputs_;
};

}  // namespace fricid::friction
