#include "fricid/film/paint.hpp"

#include <cstdio>

#include "fricid/base/error.hpp"

namespace fricid::film {

Paint paint_of(const std::string& colour, float alpha) {
  unsigned rgb = 0;
  int used = 0;
  if (colour.size() != 7 || std::sscanf(colour.c_str(), "#%6x%n", &rgb, &used) != 1 || used != 7)
    throw UserError("colour {}: allowed: #rrggbb", colour);
  const auto channel = [&](unsigned shift) {
    return static_cast<float>(rgb >> shift & 0xff) / 255.0f;
  };
  return {channel(16), channel(8), channel(0), alpha};
}

}  // namespace fricid::film
