// Parsing of JSON text from files, for every reader of JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace fricid {

/// @param where  the file, for messages
/// @throws UserError "WHERE:LINE: not JSON: ..." on anything that is not one JSON value, on numbers
/// beyond what a double holds, and on lists and objects nested deeper than limits::kJsonLevels
template <class Json = nlohmann::json>
Json parse_json(std::string_view text, const std::string& where);

/// A value as messages show it, in at most 60 visible bytes: 3, "text", a list, an object.
template <class Json>
std::string shown(const Json& value);

extern template nlohmann::json parse_json(std::string_view, const std::string&);
extern template nlohmann::ordered_json parse_json(std::string_view, const std::string&);
extern template std::string shown(const nlohmann::json&);
extern template std::string shown(const nlohmann::ordered_json&);

}  // namespace fricid
