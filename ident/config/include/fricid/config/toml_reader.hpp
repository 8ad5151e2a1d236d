// The reading archive: fills the fields of a struct of options from a TOML table and refuses
// unknown keys.
#pragma once

#include <toml++/toml.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"

namespace fricid::config {

/// Reads one table. Errors: "file:line: section.key = found; allowed: ...".
class TomlReader {
 public:
  /// @param joint_names  of the robot: per-joint values have as many
  TomlReader(const toml::table& table, std::string section, std::string where,
             const std::vector<std::string>& joint_names)
      : table_(table),
        section_(std::move(section)),
        where_(std::move(where)),
        joint_names_(joint_names) {}

  void operator()(std::string_view key, double& value, const Field& field);
  void operator()(std::string_view key, int& value, const Field& field);
  void operator()(std::string_view key, std::uint64_t& value, const Field& field);
  void operator()(std::string_view key, bool& value, const Field& field);
  void operator()(std::string_view key, std::string& value, const Field& field);
  void operator()(std::string_view key, std::vector<double>& value, const Field& field);
  void operator()(std::string_view key, std::vector<int>& value, const Field& field);
  void operator()(std::string_view key, std::vector<std::string>& value, const Field& field);
  /// A table of numbers by name.
  void operator()(std::string_view key, std::map<std::string, double>& value, const Field& field);
  template <std::size_t N>
  void operator()(std::string_view key, std::array<double, N>& value, const Field& field) {
    read_array(key, value.data(), static_cast<int>(N), field);
  }
  template <NamedEnum E>
  void operator()(std::string_view key, E& value, Field field) {
    std::string name(fricid::name_of(value));
    field.choices = names(value);
    (*this)(key, name, field);
    value = *value_named<E>(name);
  }
  /// Leaves the value unchanged if the key is missing.
  template <NamedEnum E>
  void operator()(std::string_view key, std::optional<E>& value, const Field& field) {
    if (!table_.contains(key)) return allow(key);
    value = value.value_or(E{});
    (*this)(key, *value, field);
  }

  /// A text, or the tables that `tables_unless_text` reads; left as it is there.
  void text_unless_tables(std::string_view key, std::string& value, const Field& field);
  template <class Config>
  void tables_unless_text(std::string_view key, std::vector<Config>& configs,
                          std::string_view meaning) {
    if (has_tables(key)) sections(key, configs, meaning);
  }

  template <class Config>
  void section(std::string_view key, Config& config, std::string_view /*meaning*/) {
    const toml::table* table = find_table(key);
    if (!table) return;
    TomlReader reader(*table, name_of(key), place_of(key), joint_names_);
    config.visit(reader);
    reader.refuse_unknown();
  }

  template <class Config>
  void sections(std::string_view key, std::vector<Config>& configs, std::string_view /*meaning*/) {
    const toml::array* array = find_tables(key);
    if (!array) return;
    configs.clear();
    for (std::size_t i = 0; i < array->size(); ++i) {
      const toml::table& table = *array->get(i)->as_table();
      TomlReader reader(table, name_of(key) + "[" + std::to_string(i + 1) + "]",
                        place_of(key, table), joint_names_);
      configs.emplace_back();
      configs.back().visit(reader);
      reader.refuse_unknown();
    }
  }

  /// @throws UserError at the first unknown key, with the nearest known one
  void refuse_unknown() const;
  /// Declares a key as known without reading it.
  void allow(std::string_view key) { known_.emplace_back(key); }

 protected:
  /// The table of a section; empty if the file has none.
  const toml::table* find_table(std::string_view key);
  std::string place_of(std::string_view key) const;
  const std::vector<std::string>& joint_names() const { return joint_names_; }

 private:
  const toml::node* find(std::string_view key, const Field& field);
  const toml::array* find_tables(std::string_view key);
  bool has_tables(std::string_view key) const;
  void read_array(std::string_view key, double* value, int size, const Field& field);
  std::string name_of(std::string_view key) const;
  std::string place_of(std::string_view key, const toml::node& node) const;
  [[noreturn]] void refuse(std::string_view key, const toml::node& node, const std::string& what,
                           const std::string& allowed) const;

  const toml::table& table_;
  std::string section_, where_;
  const std::vector<std::string>& joint_names_;
  std::vector<std::string> known_;
};

/// Allowed values in words, for messages and templates: "a number from 0 to 1000 kg", "floor,
/// ceiling or wall".
std::string allowed_number(const Field& field, bool whole);
std::string allowed_text(const Field& field);

/// @throws UserError: `section.key` is not among `known`, names the nearest of them
[[noreturn]] void refuse_unknown_key(const std::string& where, const std::string& section,
                                     std::string_view key, const std::vector<std::string>& known);

}  // namespace fricid::config
