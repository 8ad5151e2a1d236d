// For laws and modifiers with a run-time number of elements: names of their parameters ("k1" ..
// "k16") and a spread of starting values.
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

/// numbered<"k">(i) is "k1" for i = 0, up to "k99"; the text lives as long as the program.
template <Stem stem>
struct Numbered {
  static constexpr int kCount = 99;
  using Text = std::array<char, sizeof(stem.text) + 1>;

  static constexpr std::array<Text, kCount> kTexts = [] {
    std::array<Text, kCount> texts{};
    for (int i = 0; i < kCount; ++i) {
      std::size_t n = 0;
      for (; stem.text[n] != '\0'; ++n) texts[i][n] = stem.text[n];
      if (i + 1 >= 10) texts[i][n++] = static_cast<char>('0' + (i + 1) / 10);
      texts[i][n] = static_cast<char>('0' + (i + 1) % 10);
    }
    return texts;
  }();
  static constexpr std::string_view symbol(int i) {
    return {kTexts[i].data(), sizeof(stem.text) - 1 + (i + 1 >= 10 ? 2 : 1)};
  }
};

template <Stem stem>
constexpr std::string_view numbered(int i) {
  return Numbered<stem>::symbol(i);
}

/// Presliding length of element i of n where nothing better is known [rad]: 0.2 to 4 mrad with
/// growing gaps, so that no two elements of a fit start equal.
constexpr double typical_length(int i, int n) {
  constexpr double kShortest = 2e-4, kLongest = 4e-3;
  const double share = n == 1 ? 0.5 : static_cast<double>(i) / (n - 1);
  return kShortest + (kLongest - kShortest) * share * share;
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
