// What a key of a scene or contract may hold. Every struct of options names its fields once, in
// `visit(archive)`: reading, writing, the templates and the unknown-key check are archives.
#pragma once

#include <limits>
#include <string_view>

namespace fricid {

/// Meaning and allowed values of one key. Bounds are closed and in `unit`.
struct Field {
  std::string_view meaning;  ///< one phrase
  std::string_view unit{};   ///< SI; empty for texts and flags
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  std::string_view choices{};  ///< allowed texts, separated by |; empty: any
  bool per_joint = false;      ///< one value per joint; a single number stands for all
  /// A key that a scene must have; a number of an artefact that is never null and keeps its bounds.
  bool required = false;
  bool parts = false;  ///< files of which a part can be meant: "FILE[FROM:TO]", seconds
};

constexpr Field number(std::string_view unit, double lower, double upper,
                       std::string_view meaning) {
  return {.meaning = meaning, .unit = unit, .lower = lower, .upper = upper};
}
/// A bound that is none: far from the overflow of a few sums and products.
inline constexpr double kUnbounded = 1e300;
constexpr Field any_number(std::string_view unit, std::string_view meaning) {
  return number(unit, -kUnbounded, kUnbounded, meaning);
}
constexpr Field not_negative(std::string_view unit, std::string_view meaning) {
  return number(unit, 0, kUnbounded, meaning);
}
constexpr Field at_most_one(std::string_view unit, std::string_view meaning) {
  return number(unit, -kUnbounded, 1, meaning);
}
constexpr Field per_joint(std::string_view unit, double lower, double upper,
                          std::string_view meaning) {
  return {.meaning = meaning, .unit = unit, .lower = lower, .upper = upper, .per_joint = true};
}
constexpr Field choice(std::string_view choices, std::string_view meaning) {
  return {.meaning = meaning, .choices = choices};
}
/// For an enum: the allowed texts are its names, see enum_names.hpp.
constexpr Field choice(std::string_view meaning) { return {.meaning = meaning}; }
/// A table of what was sampled: any number, NaN where it is missing.
constexpr Field signal(std::string_view unit, std::string_view meaning) {
  return {.meaning = meaning, .unit = unit};
}
constexpr Field text(std::string_view meaning) { return {.meaning = meaning}; }
constexpr Field files_or_parts(std::string_view meaning) {
  return {.meaning = meaning, .parts = true};
}
constexpr Field flag(std::string_view meaning) { return {.meaning = meaning}; }
constexpr Field required(Field field) {
  field.required = true;
  return field;
}

}  // namespace fricid
