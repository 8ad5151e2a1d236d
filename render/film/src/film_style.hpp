// What the pictures of all films share: colours, places and rows.
#pragma once

#include <span>

#include "fricid/film/canvas.hpp"
#include "fricid/render/palette.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid::film {

inline constexpr double kHeader = 44, kStripsTop = 470;  // [px] below the title; of the strips
inline constexpr double kGap = 4;                        // [px] between pictures
inline constexpr double kPast = 4;                       // [s] that strips show
inline constexpr double kFrontElevation = -8;            // [deg]

inline constexpr Paint kInk{0.13f, 0.13f, 0.15f, 1}, kFaint{0.42f, 0.42f, 0.45f, 1},
    kVeil{1, 1, 1, 0.82f}, kPlainArm{0.8f, 0.81f, 0.83f, 1};
inline const Paint kTruth = paint_of(render::kTruthColour);

/// Row of a matrix, the state of all joints at one sample.
inline std::span<const double> row_of(const RowMatrix& values, Eigen::Index row) {
  return {values.data() + row * values.cols(), static_cast<std::size_t>(values.cols())};
}

}  // namespace fricid::film
