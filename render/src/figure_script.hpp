#pragma once

#include "fricid/render/figure.hpp"

namespace fricid::render {

struct FigureSize {
  double width_cm, height_cm;
};

FigureSize size_of(const Figure& figure);

}  // namespace fricid::render
