// Units as loggers write them.
#pragma once

#include <optional>
#include <string_view>

namespace fricid::data {

/// What a contract says of a unit: `unit = "..."` (empty: the quantity has none), and the scale.
struct UnitWord {
  std::string_view unit;
  double scale = 1;
};

/// The unit that a cell names, in brackets or not and in any letter case, of a motion also per
/// second; none: no word for a unit of the quantity.
std::optional<UnitWord> time_unit(std::string_view cell);
std::optional<UnitWord> motion_unit(std::string_view cell);
std::optional<UnitWord> torque_unit(std::string_view cell);
std::optional<UnitWord> temperature_unit(std::string_view cell);

/// Whether a cell may be one of a row of units.
bool is_unit(std::string_view cell);

}  // namespace fricid::data
