#include "fricid/config/toml_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"
#include "fricid/base/text.hpp"
#include "fricid/config/toml_file.hpp"

namespace fricid::config {
namespace {

std::string quantity(const Field& field) {
  const std::string unit =
      field.unit.empty() || field.unit == "1" ? "" : fmt::format(" {}", field.unit);
  const bool low = std::isfinite(field.lower), high = std::isfinite(field.upper);
  if (low && high) return fmt::format(" from {:g} to {:g}{}", field.lower, field.upper, unit);
  if (low) return fmt::format(" of at least {:g}{}", field.lower, unit);
  if (high) return fmt::format(" of at most {:g}{}", field.upper, unit);
  return unit.empty() ? "" : " in" + unit;
}

std::optional<double> in_range(const toml::node& node, const Field& field) {
  const std::optional<double> value = as_number(node);
  if (value && *value >= field.lower && *value <= field.upper) return value;
  return std::nullopt;
}

std::optional<std::int64_t> whole_in_range(const toml::node& node, const Field& field) {
  if (!node.is_integer() || !in_range(node, field)) return std::nullopt;
  return node.as_integer()->get();
}

/// {file = "log.csv", from = 10, to = 20} as "log.csv[10:20]"; either end may be left out. Nothing
/// where the table is another one.
std::optional<std::string> part_of_file(const toml::table& table) {
  std::string file, from, to;
  for (auto&& [key, item] : table) {
    const std::optional<double> seconds = as_number(item);
    if (key == "file" && item.is_string())
      file = item.as_string()->get();
    else if (key == "from" && seconds)
      from = fmt::format("{}", *seconds);
    else if (key == "to" && seconds)
      to = fmt::format("{}", *seconds);
    else
      return std::nullopt;
  }
  if (file.empty()) return std::nullopt;
  return from.empty() && to.empty() ? file : fmt::format("{}[{}:{}]", file, from, to);
}

/// One of a list of texts.
std::optional<std::string> text_of(const toml::node& node, const Field& field) {
  if (node.is_string()) return node.as_string()->get();
  if (field.parts && node.is_table()) return part_of_file(*node.as_table());
  return std::nullopt;
}

std::string joint_count(std::size_t n) { return fmt::format("{} joint{}", n, n == 1 ? "" : "s"); }

}  // namespace

std::string allowed_number(const Field& field, bool whole) {
  return (whole ? "a whole number" : "a number") + quantity(field);
}

std::string allowed_text(const Field& field) {
  const std::vector<std::string> choices = parts_of(field.choices);
  if (choices.empty()) return "a text";
  std::string list = choices[0];
  for (std::size_t i = 1; i < choices.size(); ++i)
    list += (i + 1 == choices.size() ? " or " : ", ") + choices[i];
  return list;
}

std::string TomlReader::name_of(std::string_view key) const {
  return section_.empty() ? std::string(key) : fmt::format("{}.{}", section_, key);
}

std::string TomlReader::place_of(std::string_view key) const {
  const toml::node* node = table_.get(key);
  return node ? place(*node, where_) : where_;
}

std::string TomlReader::place_of(std::string_view key, const toml::node& node) const {
  return place(node, place_of(key));
}

void TomlReader::refuse(std::string_view key, const toml::node& node, const std::string& what,
                        const std::string& allowed) const {
  throw UserError("{}: {} = {}; allowed: {}", place_of(key, node), name_of(key), what, allowed);
}

bool TomlReader::has_tables(std::string_view key) const {
  const toml::node* node = table_.get(key);
  return node && node->is_array() && node->as_array()->is_homogeneous(toml::node_type::table);
}

void TomlReader::text_unless_tables(std::string_view key, std::string& value, const Field& field) {
  if (has_tables(key)) return allow(key);
  (*this)(key, value, field);
}

const toml::node* TomlReader::find(std::string_view key, const Field& field) {
  allow(key);
  const toml::node* node = table_.get(key);
  if (!node && field.required)
    throw UserError("{}: {} is missing: {}", where_, name_of(key), field.meaning);
  return node;
}

const toml::table* TomlReader::find_table(std::string_view key) {
  allow(key);
  const toml::node* node = table_.get(key);
  if (node && !node->is_table()) refuse(key, *node, found(*node), "a table");
  return node ? node->as_table() : nullptr;
}

const toml::array* TomlReader::find_tables(std::string_view key) {
  allow(key);
  const toml::node* node = table_.get(key);
  if (!node) return nullptr;
  const toml::array* array = node->as_array();
  if (!array || !std::all_of(array->begin(), array->end(),
                             [](const toml::node& item) { return item.is_table(); }))
    refuse(key, *node, found(*node), fmt::format("tables [[{}]]", name_of(key)));
  return array;
}

void TomlReader::operator()(std::string_view key, double& value, const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  const std::optional<double> read = in_range(*node, field);
  if (!read) refuse(key, *node, found(*node), allowed_number(field, false));
  value = *read;
}

void TomlReader::operator()(std::string_view key, int& value, const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  const std::optional<std::int64_t> read = whole_in_range(*node, field);
  if (!read) refuse(key, *node, found(*node), allowed_number(field, true));
  value = static_cast<int>(*read);
}

void TomlReader::operator()(std::string_view key, std::uint64_t& value, const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  const std::optional<std::int64_t> read = whole_in_range(*node, field);
  if (!read) refuse(key, *node, found(*node), allowed_number(field, true));
  value = static_cast<std::uint64_t>(*read);
}

void TomlReader::operator()(std::string_view key, bool& value, const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  if (!node->is_boolean()) refuse(key, *node, found(*node), "true or false");
  value = node->as_boolean()->get();
}

void TomlReader::operator()(std::string_view key, std::string& value, const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  const std::vector<std::string> choices = parts_of(field.choices);
  if (!node->is_string() ||
      (!choices.empty() &&
       std::find(choices.begin(), choices.end(), node->as_string()->get()) == choices.end()) ||
      (field.required && node->as_string()->get().empty()))
    refuse(key, *node, found(*node), allowed_text(field));
  value = node->as_string()->get();
}

void TomlReader::operator()(std::string_view key, std::vector<double>& value, const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  const std::size_t n = joint_names_.size();
  const std::string allowed = field.per_joint
                                  ? fmt::format("{}, or an array of them for the {}",
                                                allowed_number(field, false), joint_count(n))
                                  : fmt::format("an array, each {}", allowed_number(field, false));
  if (field.per_joint && as_number(*node)) {
    const std::optional<double> read = in_range(*node, field);
    if (!read) refuse(key, *node, found(*node), allowed);
    value.assign(n, *read);
    return;
  }
  const toml::array* array = node->as_array();
  if (!array || (field.per_joint && !array->empty() && array->size() != n))
    refuse(key, *node, found(*node), allowed);
  value.clear();
  for (const toml::node& item : *array) {
    const std::optional<double> read = in_range(item, field);
    if (!read) refuse(fmt::format("{}[{}]", key, value.size() + 1), item, found(item), allowed);
    value.push_back(*read);
  }
}

void TomlReader::operator()(std::string_view key, std::vector<int>& value, const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  const std::string allowed = fmt::format("an array, each {}", allowed_number(field, true));
  const toml::array* array = node->as_array();
  if (!array || array->empty()) refuse(key, *node, found(*node), allowed);
  value.clear();
  for (const toml::node& item : *array) {
    const std::optional<std::int64_t> read = whole_in_range(item, field);
    if (!read) refuse(fmt::format("{}[{}]", key, value.size() + 1), item, found(item), allowed);
    value.push_back(static_cast<int>(*read));
  }
}

void TomlReader::operator()(std::string_view key, std::vector<std::string>& value,
                            const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  value.clear();
  if (const std::optional<std::string> one = text_of(*node, field)) {
    value.push_back(*one);
    return;
  }
  const toml::array* array = node->as_array();
  std::string allowed = "a text or an array of texts";
  if (field.parts)
    allowed += ", each \"FILE\", \"FILE[FROM:TO]\" or {file = \"FILE\", from = FROM, to = TO} [s]";
  if (!array || (field.required && array->empty())) refuse(key, *node, found(*node), allowed);
  for (const toml::node& item : *array) {
    const std::optional<std::string> text = text_of(item, field);
    if (!text) refuse(fmt::format("{}[{}]", key, value.size() + 1), item, found(item), allowed);
    value.push_back(*text);
  }
}

void TomlReader::operator()(std::string_view key, std::map<std::string, double>& value,
                            const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  const std::string allowed = fmt::format("{{NAME = {}, ...}}", allowed_number(field, false));
  const toml::table* table = node->as_table();
  if (!table) refuse(key, *node, found(*node), allowed);
  value.clear();
  for (auto&& [name, item] : *table) {
    const std::optional<double> read = in_range(item, field);
    if (!read) refuse(fmt::format("{}.{}", key, name.str()), item, found(item), allowed);
    value[std::string(name.str())] = *read;
  }
}

void TomlReader::read_array(std::string_view key, double* value, int size, const Field& field) {
  const toml::node* node = find(key, field);
  if (!node) return;
  const std::string allowed =
      fmt::format("an array of {}, each {}", size, allowed_number(field, false));
  const toml::array* array = node->as_array();
  if (!array || array->size() != static_cast<std::size_t>(size))
    refuse(key, *node, found(*node), allowed);
  for (int i = 0; i < size; ++i) {
    const toml::node& item = *array->get(static_cast<std::size_t>(i));
    const std::optional<double> read = in_range(item, field);
    if (!read) refuse(fmt::format("{}[{}]", key, i + 1), item, found(item), allowed);
    value[i] = *read;
  }
}

void refuse_unknown_key(const std::string& where, const std::string& section, std::string_view key,
                        const std::vector<std::string>& known) {
  const std::vector<std::string_view> views(known.begin(), known.end());
  const std::string meant = nearest(key, views);
  throw UserError("{}: unknown key {}{}{}; {}", where, section, section.empty() ? "" : ".", key,
                  meant.empty() ? fmt::format("known keys: {}", fmt::join(known, ", "))
                                : fmt::format("nearest known key: {}", meant));
}

void TomlReader::refuse_unknown() const {
  for (auto&& [key, node] : table_) {
    if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
    refuse_unknown_key(place(node, where_), section_, key.str(), known_);
  }
}

}  // namespace fricid::config
