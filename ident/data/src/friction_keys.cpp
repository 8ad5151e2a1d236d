#include "fricid/data/friction_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fricid::data {
namespace {

using friction::LawInfo;
using friction::ParameterInfo;

// Keys of `now`, where `other` are the parameters with another number of elements: a family is what
// that number changes.
std::vector<FrictionKey> make_keys(const std::vector<ParameterInfo>& now,
                                   const std::vector<ParameterInfo>& other) {
  std::vector<FrictionKey> keys;
  for (std::size_t p = 0; p < now.size(); ++p) {
    const friction::Role role = now[p].role;
    const bool family =
        now[p].element > 0 && std::ranges::count(now, role, &ParameterInfo::role) !=
                                  std::ranges::count(other, role, &ParameterInfo::role);
    const std::string name(family ? now[p].stem() : now[p].symbol);
    const auto known = std::ranges::find(keys, name, &FrictionKey::key);
    if (known != keys.end()) {
      known->members.push_back(static_cast<int>(p));
    } else {
      keys.push_back({.key = name, .members = {static_cast<int>(p)}, .family = family});
    }
  }
  return keys;
}

int other_count(const LawInfo& row, int elements) {
  return !row.has_elements ? elements : elements > 1 ? elements - 1 : elements + 1;
}

}  // namespace

FrictionOwner law_owner(const LawInfo& row, int elements) {
  FrictionOwner owner{.name = std::string(row.name),
                      .parameters = friction::parameters_of_law(row.name, elements),
                      .keys = {}};
  const int other = other_count(row, elements);
  owner.keys = make_keys(owner.parameters, friction::parameters_of_law(row.name, other));
  return owner;
}

FrictionOwner modifier_owner(const LawInfo& row, int elements) {
  FrictionOwner owner{.name = std::string(row.name),
                      .parameters = friction::parameters_of_modifier(row.name, elements),
                      .keys = {}};
  const int other = other_count(row, elements);
  owner.keys = make_keys(owner.parameters, friction::parameters_of_modifier(row.name, other));
  return owner;
}

const LawInfo* find_row(std::span<const LawInfo> rows, std::string_view name) {
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const LawInfo& info) { return info.name == name; });
  return row == rows.end() ? nullptr : &*row;
}

std::string list_names(std::span<const LawInfo> rows) {
  std::string names;
  for (const LawInfo& row : rows) names += (names.empty() ? "" : ", ") + std::string(row.name);
  return names;
}

std::string unit_suffix(const ParameterInfo& info) {
  return info.has_unit() ? fmt::format(" {}", info.unit) : "";
}

std::string list_bounds(const ParameterInfo& info) {
  return fmt::format("{:g} to {:g}{}", info.lower, info.upper, unit_suffix(info));
}

}  // namespace fricid::data
