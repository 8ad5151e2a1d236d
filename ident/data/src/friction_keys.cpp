#include "friction_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fricid::data {
namespace {

using friction::LawInfo;
using friction::ParameterInfo;

// Keys of `now`, where `other` are the parameters with another number of elements: a family is what
// that number changes, less the number at its end.
std::vector<FrictionKey> make_keys(const std::vector<ParameterInfo>& now,
                                   const std::vector<ParameterInfo>& other) {
  std::vector<std::string> bases;
  const auto add_bases = [&](const auto& some, const auto& without) {
    for (const ParameterInfo& info : some) {
      const auto same_symbol = [&](const ParameterInfo& p) { return p.symbol == info.symbol; };
      if (std::any_of(without.begin(), without.end(), same_symbol)) continue;
      bases.emplace_back(info.symbol.substr(0, info.symbol.find_last_not_of("0123456789") + 1));
    }
  };
  add_bases(now, other);
  add_bases(other, now);

  std::vector<FrictionKey> keys;
  for (std::size_t p = 0; p < now.size(); ++p) {
    const std::string symbol(now[p].symbol);
    const std::size_t end = symbol.find_last_not_of("0123456789") + 1;
    const std::string base = symbol.substr(0, end);
    const bool family =
        end < symbol.size() && std::find(bases.begin(), bases.end(), base) != bases.end();
    const std::string name = family ? base : symbol;
    const auto known = std::find_if(keys.begin(), keys.end(),
                                    [&](const FrictionKey& key) { return key.key == name; });
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
  return info.unit == "1" ? "" : fmt::format(" {}", info.unit);
}

std::string list_bounds(const ParameterInfo& info) {
  return fmt::format("{:g} to {:g}{}", info.lower, info.upper, unit_suffix(info));
}

}  // namespace fricid::data
