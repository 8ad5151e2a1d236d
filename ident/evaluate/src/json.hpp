// How evaluations write numbers: JSON knows no NaN, what does not exist is null.
#pragma once

#include <cmath>
#include <vector>

#include <nlohmann/json.hpp>

#include "fricid/evaluate/statistics.hpp"

namespace fricid::evaluate {

using Json = nlohmann::ordered_json;

inline Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

template <class Range, class Convert>
Json list(const Range& range, const Convert& convert) {
  Json array = Json::array();
  for (const auto& item : range) array.push_back(convert(item));
  return array;
}

inline Json numbers(const std::vector<double>& values) { return list(values, number); }

/// Pairs [low, high].
inline Json intervals(const std::vector<Interval>& values) {
  return list(values, [](const Interval& i) {
    return Json::array({number(i.low), number(i.high)});
  });
}

}  // namespace fricid::evaluate
