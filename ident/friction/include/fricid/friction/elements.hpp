// For laws and modifiers with a run-time number of elements or weights: names of their parameters
// ("k1" .. "k16", "w1" .. "w1000") and a spread of starting values.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// The largest number of elements of gms and maxwell_slip.
inline constexpr int kMaxElements = 16;

/// A string literal as a template argument.
template <std::size_t N>
struct Stem {
  char text[N];
  constexpr Stem(const char (&literal)[N]) {
    for (std::size_t i = 0; i < N; ++i) text[i] = literal[i];
  }
};

/// Texts "k1", "k2", .. up to kCount of them; they live as long as the program.
template <Stem stem, int kCount>
struct Numbered {
  static_assert(kCount < 10000);
  struct Text {
    char text[sizeof(stem.text) + 3];
    std::size_t size;
  };

  static constexpr std::array<Text, kCount> kTexts = [] {
    std::array<Text, kCount> texts{};
    for (int i = 0; i < kCount; ++i) {
      auto& [text, size] = texts[static_cast<std::size_t>(i)];
      for (; stem.text[size] != '\0'; ++size) text[size] = stem.text[size];
      int place = 1;
      while (place * 10 <= i + 1) place *= 10;
      for (; place > 0; place /= 10) text[size++] = static_cast<char>('0' + (i + 1) / place % 10);
    }
    return texts;
  }();
};

/// numbered<"k">(i) is "k1" for i = 0.
template <Stem stem, int kCount = 99>
constexpr std::string_view numbered(int i) {
  const auto& [text, size] = Numbered<stem, kCount>::kTexts[static_cast<std::size_t>(i)];
  return {text, size};
}

/// Default presliding length of element i of n [rad]: 0.2 to 4 mrad with growing gaps, so that no
/// two elements of a fit start equal.
constexpr double typical_length(int i, int n) {
  constexpr double kShortest = 2e-4, kLongest = 4e-3;
  const double share = n == 1 ? 0.5 : static_cast<double>(i) / (n - 1);
  return kShortest + (kLongest - kShortest) * share * share;
}

/// Parameter table of a law with networks: the common ones, then weights "w1" .. of which a law
/// takes as many as its width asks for.
template <int kWeights, std::size_t kCommon>
constexpr auto weight_table(const std::array<ParameterInfo, kCommon>& common) {
  std::array<ParameterInfo, kCommon + kWeights> table{};
  std::size_t next = 0;
  for (const ParameterInfo& info : common) table[next++] = info;
  for (int i = 0; i < kWeights; ++i)
    table[next++] = {numbered<"w", kWeights>(i), "1",  Role::kWeight, -100, 100, 0, Scale::kLinear,
                     "weight of a network",      i + 1};
  return table;
}

/// Parameter tables of a law with n = 1 .. kMaxElements elements and two parameters each: the
/// common ones, then element(i, n) for i = 0 .. n - 1. Row n is for n elements, row 0 is not used.
template <std::size_t kCommon, class Element>
constexpr auto element_tables(const std::array<ParameterInfo, kCommon>& common, Element element) {
  std::array<std::array<ParameterInfo, kCommon + 2 * kMaxElements>, kMaxElements + 1> tables{};
  for (int n = 1; n <= kMaxElements; ++n) {
    auto& table = tables[static_cast<std::size_t>(n)];
    std::size_t next = 0;
    for (const ParameterInfo& info : common) table[next++] = info;
    for (int i = 0; i < n; ++i)
      for (const ParameterInfo& info : element(i, n)) table[next++] = info;
  }
  return tables;
}

}  // namespace fricid::friction
