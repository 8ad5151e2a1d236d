// Units of a joint: those of one that turns, or that slides.
#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace fricid {

/// The unit of a joint that turns, for one that may slide: "N m s/rad" -> "N s/m", "rad" -> "m".
inline std::string unit_of_joint(std::string_view unit, bool slides) {
  std::string own(unit);
  if (!slides) return own;
  // torques are forces, angles lengths
  for (const auto& [turning, sliding] : {std::pair{"N m", "N"}, {"rad", "m"}})
    for (std::size_t at = own.find(turning); at != std::string::npos;
         at = own.find(turning, at + 1))
      own.replace(at, std::string_view(turning).size(), sliding);
  return own;
}

}  // namespace fricid
