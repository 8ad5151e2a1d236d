// Particles in lanes: block b holds the states of particles L b .. L b + L - 1, component i of all
// of them in one pack; L = kLaneCount<S>.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "fricid/base/pack.hpp"

namespace fricid::smc {

/// double or float, the number in a lane of S.
template <class S>
using Real = std::remove_cvref_t<decltype(lane(std::declval<S>(), 0))>;

/// Numbers in memory to lanes and back, converted to the lanes' type.
template <class S, class T>
S load(const T* from) {
  S x(0);
  if constexpr (std::is_same_v<T, Real<S>>) {
    std::memcpy(&x, from, sizeof(S));
  } else if constexpr (kLaneCount<S> == 1) {
    x = static_cast<S>(*from);
#if defined(__AVX512F__)
  } else if constexpr (std::is_same_v<T, float> && sizeof(S) == 64) {
    x = S((typename S::Vector)_mm512_cvtps_pd(_mm256_loadu_ps(from)));
#endif
  } else {
    typedef T Vector __attribute__((vector_size(sizeof(T) * kLaneCount<S>)));
    Vector v;
    std::memcpy(&v, from, sizeof(v));
    x = S(__builtin_convertvector(v, typename S::Vector));
  }
  return x;
}
template <class S, class T>
void store(S x, T* to) {
  if constexpr (std::is_same_v<T, Real<S>>) {
    std::memcpy(to, &x, sizeof(S));
  } else {
    for (int i = 0; i < kLaneCount<S>; ++i) to[i] = static_cast<T>(lane(x, i));
  }
}

/// Sum over the lanes, lane 0 first.
template <class S>
Real<S> add_lanes(S x) {
  Real<S> sum = lane(x, 0);
  for (int i = 1; i < kLaneCount<S>; ++i) sum += lane(x, i);
  return sum;
}

/// Random numbers are laid out for this many particles at a time, so that particle i sees the same
/// ones in lanes of any width.
inline constexpr int kPadding = 16;

/// `particles` rounded up to a multiple of kPadding.
constexpr int padded(int particles) { return (particles + kPadding - 1) / kPadding * kPadding; }

/// The states of `particles` particles and of the empty lanes behind them.
template <class S>
class Cloud {
 public:
  static constexpr int kLanes = kLaneCount<S>;

  Cloud() = default;
  Cloud(int state_size, int particles)
      : n_(state_size),
        blocks_((particles + kLanes - 1) / kLanes),
        x_(static_cast<std::size_t>(n_ * blocks_), S(0)) {}

  int state_size() const { return n_; }
  int blocks() const { return blocks_; }
  S* block(int b) { return x_.data() + static_cast<std::ptrdiff_t>(b) * n_; }
  const S* block(int b) const { return x_.data() + static_cast<std::ptrdiff_t>(b) * n_; }

  /// Component i of one particle.
  Real<S> at(int particle, int i) const {
    return reinterpret_cast<const Real<S>*>(x_.data())[offset(particle) + i * kLanes];
  }
  void set(int particle, int i, Real<S> value) {
    reinterpret_cast<Real<S>*>(x_.data())[offset(particle) + i * kLanes] = value;
  }

  /// Copies the particles ancestors[L b] .. ancestors[L b + L - 1] into a block of lanes; fastest
  /// where they are neighbours.
  void gather(int b, std::span<const int> ancestors, S* to) const {
    const int* from = ancestors.data() + b * kLanes;
#if defined(__AVX512F__)
    if constexpr (sizeof(S) == 64) {
      const auto [first, last] = std::minmax_element(from, from + kLanes);
      const int begin = *first / kLanes, end = *last / kLanes + 1;
      if (end - begin <= kMostNeighbours) return gather_neighbours(from, begin, end, to);
    }
#endif
    for (int k = 0; k < kLanes; ++k) {
      const Real<S>* particle = reinterpret_cast<const Real<S>*>(x_.data()) + offset(from[k]);
      Real<S>* lane_k = reinterpret_cast<Real<S>*>(to) + k;
      for (int i = 0; i < n_; ++i) lane_k[i * kLanes] = particle[i * kLanes];
    }
  }

 private:
  std::ptrdiff_t offset(int particle) const {
    return static_cast<std::ptrdiff_t>(particle / kLanes) * n_ * kLanes + particle % kLanes;
  }

#if defined(__AVX512F__)
  static constexpr int kMostNeighbours = 6;  // blocks

  /// The same where all are in the blocks [begin, end): lanes picked from two blocks at a time.
  void gather_neighbours(const int* from, int begin, int end, S* to) const {
    for (int pair = begin; pair < end; pair += 2) {
      const S *a = block(pair), *b = block(std::min(pair + 1, end - 1));
      if constexpr (kLanes == 16) {
        const __m512i lanes =
            _mm512_sub_epi32(_mm512_loadu_si512(from), _mm512_set1_epi32(pair * kLanes));
        const __mmask16 here = _mm512_cmplt_epu32_mask(lanes, _mm512_set1_epi32(2 * kLanes));
        for (int i = 0; i < n_; ++i)
          to[i] = (typename S::Vector)_mm512_mask_blend_ps(
              here, (__m512)to[i].v, _mm512_permutex2var_ps((__m512)a[i].v, lanes, (__m512)b[i].v));
      } else {
        const __m512i lanes = _mm512_sub_epi64(
            _mm512_cvtepi32_epi64(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))),
            _mm512_set1_epi64(pair * kLanes));
        const __mmask8 here = _mm512_cmplt_epu64_mask(lanes, _mm512_set1_epi64(2 * kLanes));
        for (int i = 0; i < n_; ++i)
          to[i] = (typename S::Vector)_mm512_mask_blend_pd(
              here, (__m512d)to[i].v,
              _mm512_permutex2var_pd((__m512d)a[i].v, lanes, (__m512d)b[i].v));
      }
    }
  }
#endif

  int n_ = 0, blocks_ = 0;
  std::vector<S> x_;
};

/// A matrix of constants times a vector of lanes; entries that are exactly zero cost nothing.
template <class S>
class LaneMatrix {
 public:
  LaneMatrix() = default;
  /// Room for rows x cols entries, so that assign does not allocate.
  LaneMatrix(Eigen::Index rows, Eigen::Index cols) {
    start_.reserve(static_cast<std::size_t>(rows) + 1);
    entries_.reserve(static_cast<std::size_t>(rows * cols));
  }

  explicit LaneMatrix(const Eigen::MatrixXd& A) : LaneMatrix(A.rows(), A.cols()) { assign(A); }

  void assign(const Eigen::Ref<const Eigen::MatrixXd>& A) {
    start_.clear();
    entries_.clear();
    start_.push_back(0);
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      for (Eigen::Index j = 0; j < A.cols(); ++j) {
        if (A(i, j) != 0) entries_.push_back({static_cast<Real<S>>(A(i, j)), static_cast<int>(j)});
      }
      start_.push_back(entries_.size());
    }
  }

  int rows() const { return static_cast<int>(start_.size()) - 1; }

  /// Row i times x, added to `sum`.
  S add_row(int i, const S* x, S sum) const {
    const Entry* entry = entries_.data() + start_[static_cast<std::size_t>(i)];
    const Entry* end = entries_.data() + start_[static_cast<std::size_t>(i) + 1];
    for (; entry != end; ++entry) sum = fma(S(entry->value), x[entry->column], sum);
    return sum;
  }

 private:
  struct Entry {
    Real<S> value;
    int column;
  };
  std::vector<std::size_t> start_;
  std::vector<Entry> entries_;
};

}  // namespace fricid::smc
