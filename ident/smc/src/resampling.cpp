#include "fricid/smc/resampling.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "fricid/base/math.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/smc/lanes.hpp"

namespace fricid::smc {
namespace {

/// Walks through the cumulated weights: next(x) is the first index with W_0 + .. + W_i > x, for
/// x that never fall. The walk ends on the last positive weight, whatever rounding did to the sum.
class Walk {
 public:
  explicit Walk(std::span<const double> W) : W_(W), last_(W.size() - 1) {
    while (last_ > 0 && !(W[last_] > 0)) --last_;
    sum_ = W[0];
  }
  int next(double x) {
    while (sum_ <= x && index_ < last_) sum_ += W_[++index_];
    return static_cast<int>(index_);
  }

 private:
  std::span<const double> W_;
  std::size_t index_ = 0, last_;
  double sum_;
};

/// Offspring of i are the k with (k + u) / N between the weights cumulated before and after i. No
/// branch depends on the weights: each i writes its number where its offspring begin, to be written
/// over where there are none, and a running maximum fills the places between.
void resample_systematic(std::span<const double> W, double u, std::span<int> ancestors) {
  const auto count = static_cast<std::ptrdiff_t>(ancestors.size());
  const auto N = static_cast<double>(count);
  auto last = std::ssize(W) - 1;
  while (last > 0 && !(W[static_cast<std::size_t>(last)] > 0)) --last;
  std::fill(ancestors.begin(), ancestors.end(), 0);
  double sum = 0;
  std::ptrdiff_t begin = 0;
  for (std::ptrdiff_t i = 0; i <= last && begin < count; ++i) {
    ancestors[static_cast<std::size_t>(begin)] = static_cast<int>(i);
    sum += W[static_cast<std::size_t>(i)];
    begin = std::max(begin, static_cast<std::ptrdiff_t>(std::ceil(N * sum - u)));
  }
  int running = 0;
  for (int& a : ancestors) a = running = std::max(running, a);
}

void resample_multinomial(std::span<const double> W, std::span<const double> uniforms,
                          std::span<int> ancestors) {
  // sorted uniforms are cumulated exponentials over their total
  const std::size_t count = ancestors.size();
  double total = 0;
  for (std::size_t k = 0; k <= count; ++k) total -= log(uniforms[k]);
  Walk walk(W);
  double reached = 0;
  for (std::size_t k = 0; k < count; ++k) {
    reached -= log(uniforms[k]);
    ancestors[k] = walk.next(reached / total);
  }
}

void resample_killing(std::span<const double> W, std::span<const double> uniforms,
                      std::span<int> ancestors) {
  assert(ancestors.size() == W.size());
  const double largest = *std::max_element(W.begin(), W.end());
  const std::size_t count = W.size();
  std::size_t killed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool survives = uniforms[i] * largest < W[i];
    killed += survives ? 0 : 1;
    ancestors[i] = survives ? static_cast<int>(i) : -1;
  }
  if (killed == 0) return;
  // the places of the killed, drawn anew: sorted uniforms over as many as were killed
  double total = 0;
  for (std::size_t k = 0; k <= killed; ++k) total -= log(uniforms[count + k]);
  Walk walk(W);
  double reached = 0;
  std::size_t drawn = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (ancestors[i] >= 0) continue;
    reached -= log(uniforms[count + drawn++]);
    ancestors[i] = walk.next(reached / total);
  }
}

}  // namespace

std::optional<WeightSum> normalise(std::span<const double> lw, std::span<double> W) {
  assert(W.size() >= lw.size());
  double largest = -kInfinity;
  for (const double x : lw) largest = std::max(largest, x);
  if (!(std::abs(largest) < kInfinity)) return {};

  constexpr std::size_t kLanes = PackD::kLanes;
  PackD sums(0.0), squares(0.0);
  std::size_t i = 0;
  for (; i + kLanes <= lw.size(); i += kLanes) {
    const PackD w = exp(load<PackD>(lw.data() + i) - PackD(largest));
    store(w, W.data() + i);
    sums += w;
    squares = fma(w, w, squares);
  }
  double sum = add_lanes(sums), square = add_lanes(squares);
  for (; i < lw.size(); ++i) {
    W[i] = exp(lw[i] - largest);
    sum += W[i];
    square += W[i] * W[i];
  }
  if (!(sum > 0)) return {};
  const double scale = 1 / sum;
  for (std::size_t k = 0; k < lw.size(); ++k) W[k] *= scale;
  return WeightSum{largest + log(sum), sum * sum / square};
}

std::size_t uniforms_needed(Resampling scheme, std::size_t count) {
  switch (scheme) {
    case Resampling::kSystematic:
      return 1;
    case Resampling::kStratified:
      return count;
    case Resampling::kMultinomial:
      return count + 1;
    case Resampling::kKilling:
      return 2 * count + 1;
  }
  return 0;
}

void resample(Resampling scheme, std::span<const double> W, std::span<const double> uniforms,
              std::span<int> ancestors) {
  const std::size_t count = ancestors.size();
  assert(uniforms.size() >= uniforms_needed(scheme, count));
  if (scheme == Resampling::kMultinomial) return resample_multinomial(W, uniforms, ancestors);
  if (scheme == Resampling::kKilling) return resample_killing(W, uniforms, ancestors);
  if (scheme == Resampling::kSystematic) return resample_systematic(W, uniforms[0], ancestors);
  Walk walk(W);
  for (std::size_t k = 0; k < count; ++k)
    ancestors[k] = walk.next((static_cast<double>(k) + uniforms[k]) / static_cast<double>(count));
}

void split_heaviest(std::span<const double> W, int renewed, double u, std::span<int> ancestors,
                    std::span<double> weights, std::span<int> copies) {
  assert(renewed >= 0 && renewed + 2 <= std::ssize(W));
  const auto weight = [&](int i) { return W[static_cast<std::size_t>(i)]; };
  const auto copies_of = [&](int i) -> int& { return copies[static_cast<std::size_t>(i)]; };
  std::iota(ancestors.begin(), ancestors.end(), 0);
  std::nth_element(
      ancestors.begin(), ancestors.begin() + renewed, ancestors.end(),
      [&](int a, int b) { return weight(a) != weight(b) ? weight(a) < weight(b) : a < b; });
  const auto light = ancestors.first(static_cast<std::size_t>(renewed) + 1);
  const auto heavy = ancestors.subspan(light.size());
  double light_weight = 0;
  for (const int i : light) light_weight += weight(i);
  double left = u * light_weight;
  int survivor = light.front();
  for (const int i : light) {
    copies_of(i) = 0;
    if (left >= 0) survivor = i;
    left -= weight(i);
  }
  copies_of(survivor) = 1;
  for (const int i : heavy) copies_of(i) = 1;
  for (int k = 0; k < renewed; ++k)
    ++copies_of(
        *std::ranges::max_element(heavy, {}, [&](int i) { return weight(i) / copies_of(i); }));
  std::size_t k = 0;
  for (int i = 0; i < std::ssize(W); ++i)
    for (int c = 0; c < copies_of(i); ++c, ++k) {
      ancestors[k] = i;
      weights[k] = i == survivor ? light_weight : weight(i) / copies_of(i);
    }
}

int pick(std::span<const double> W, double u) {
  double total = 0;
  for (const double w : W) total += w;
  return Walk(W).next(u * total);
}

}  // namespace fricid::smc
