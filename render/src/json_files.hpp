// JSON files of a run folder, as the pictures read them.
#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"

namespace fricid::render {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// null when the file is missing. @throws UserError naming it when it is not JSON
inline nlohmann::json read_json_if_there(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return {};
  auto root = nlohmann::json::parse(read_file(file), nullptr, false);
  if (root.is_discarded()) throw UserError("{}: found no JSON", file.string());
  return root;
}

/// A number of an object; NaN when it is missing or null, as JSON writes what is not finite.
inline double number_in(const nlohmann::json& object, const std::string& key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return found != object.end() && found->is_number() ? found->get<double>() : kNaN;
}

/// A list of numbers, null as NaN; empty when it is missing.
inline std::vector<double> numbers_in(const nlohmann::json& object, const std::string& key) {
  std::vector<double> result;
  if (object.is_object() && object.contains(key) && object.at(key).is_array())
    for (const auto& value : object.at(key))
      result.push_back(value.is_number() ? value.get<double>() : kNaN);
  return result;
}

}  // namespace fricid::render
