#include "fricid/film/paint.hpp"

#include <charconv>

#include "fricid/base/error.hpp"

namespace fricid::film {

Paint paint_of(const std::string& colour, float alpha) {
  unsigned rgb = 0;
  const char* const end = colour.data() + colour.size();
  const bool written = colour.size() == 7 && colour.front() == '#';
  if (!written || std::from_chars(colour.data() + 1, end, rgb, 16).ptr != end)
    throw UserError("colour {}: allowed: #rrggbb", colour);
  const auto channel = [&](unsigned shift) {
    return static_cast<float>(rgb >> shift & 0xff) / 255.0f;
  };
  return {channel(16), channel(8), channel(0), alpha};
}

}  // namespace fricid::film
