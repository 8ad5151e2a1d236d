// Names of enum values in files and messages. An enum states them once, beside it:
//
//     enum class Layout { kGhosts, kSideBySide };
//     constexpr std::string_view names(Layout) { return "ghosts|side_by_side"; }
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace fricid {

/// An enum whose `names`, separated by |, stand in the order of its values 0, 1, 2, ...
template <class E>
concept NamedEnum = std::is_enum_v<E> && requires(E value) {
  { names(value) } -> std::same_as<std::string_view>;
};

/// Calls use(part) for every part of a list separated by | until it returns true.
template <class Use>
constexpr void for_parts(std::string_view list, Use&& use) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find('|'), list.size());
    if (use(list.substr(0, end))) return;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
}

/// The name of a value; empty for a value without one.
template <NamedEnum E>
constexpr std::string_view name_of(E value) {
  int left = static_cast<int>(value);
  std::string_view found;
  for_parts(names(value), [&](std::string_view name) {
    if (left-- == 0) found = name;
    return !found.empty();
  });
  return found;
}

/// The parts of a list separated by |.
inline std::vector<std::string> parts_of(std::string_view list) {
  std::vector<std::string> parts;
  for_parts(list, [&](std::string_view part) {
    parts.emplace_back(part);
    return false;
  });
  return parts;
}

/// Every name, in the order of the values.
template <NamedEnum E>
std::vector<std::string> all_names() {
  return parts_of(names(E{}));
}

/// The value of a name; none for any other text.
template <NamedEnum E>
constexpr std::optional<E> value_named(std::string_view text) {
  int value = 0;
  std::optional<E> found;
  for_parts(names(E{}), [&](std::string_view name) {
    if (name == text) found = static_cast<E>(value);
    ++value;
    return found.has_value();
  });
  return found;
}

}  // namespace fricid
