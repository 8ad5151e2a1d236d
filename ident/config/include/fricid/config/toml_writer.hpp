// The writing archive: every field of a struct of options as TOML, with or without comments.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"

namespace fricid::config {

class TomlWriter {
 public:
  /// @param commented  precede every key by its meaning, unit and range
  TomlWriter(bool commented, std::vector<std::string> joint_names)
      : commented_(commented), joint_names_(std::move(joint_names)) {}

  void operator()(std::string_view key, double value, const Field& field);
  void operator()(std::string_view key, int value, const Field& field);
  void operator()(std::string_view key, std::uint64_t value, const Field& field);
  void operator()(std::string_view key, bool value, const Field& field);
  void operator()(std::string_view key, const std::string& value, const Field& field);
  void operator()(std::string_view key, const std::vector<double>& value, const Field& field);
  void operator()(std::string_view key, const std::vector<int>& value, const Field& field);
  void operator()(std::string_view key, const std::vector<std::string>& value, const Field& field);
  void operator()(std::string_view key, const std::map<std::string, double>& value,
                  const Field& field);
  template <std::size_t N>
  void operator()(std::string_view key, const std::array<double, N>& value, const Field& field) {
    write_array(key, value.data(), N, field);
  }
  template <NamedEnum E>
  void operator()(std::string_view key, E value, Field field) {
    field.choices = names(value);
    (*this)(key, std::string(name_of(value)), field);
  }
  /// Writes nothing if there is no value.
  template <NamedEnum E>
  void operator()(std::string_view key, const std::optional<E>& value, const Field& field) {
    if (value) (*this)(key, *value, field);
  }

  /// A text, or the tables that `tables_unless_text` writes; left out where it is empty.
  void text_unless_tables(std::string_view key, const std::string& value, const Field& field) {
    if (commented_ || !value.empty()) (*this)(key, value, field);
  }
  template <class Config>
  void tables_unless_text(std::string_view key, std::vector<Config>& configs,
                          std::string_view meaning) {
    for (Config& config : configs) {
      const std::string outer = open("[[", key, "]]", meaning);
      config.visit(*this);
      section_ = outer;
    }
  }

  template <class Config>
  void section(std::string_view key, Config& config, std::string_view meaning) {
    const std::string outer = open("[", key, "]", meaning);
    config.visit(*this);
    section_ = outer;
  }

  template <class Config>
  void sections(std::string_view key, std::vector<Config>& configs, std::string_view meaning) {
    if constexpr (requires { Config::example(); })
      if (commented_ && configs.empty()) write_example(key, Config::example(), meaning);
    for (Config& config : configs) {
      const std::string outer = open("[[", key, "]]", meaning);
      config.visit(*this);
      section_ = outer;
    }
  }

  const std::string& text() const { return text_; }

 protected:
  /// Opens a table with its meaning as a comment. @return the enclosing section, for `close`
  std::string open(std::string_view left, std::string_view key, std::string_view right,
                   std::string_view meaning);
  void close(const std::string& around) { section_ = around; }
  void append(std::string_view text) { text_ += text; }
  bool commented() const { return commented_; }
  const std::vector<std::string>& joint_names() const { return joint_names_; }

 private:
  // an optional table, shown as a comment
  template <class Config>
  void write_example(std::string_view key, Config config, std::string_view meaning) {
    TomlWriter writer(true, joint_names_);
    writer.section_ = section_;
    writer.open("[[", key, "]]", meaning);
    config.visit(writer);
    text_ += as_comment(writer.text());
  }
  static std::string as_comment(const std::string& text);
  void write(std::string_view key, const std::string& value, const std::string& allowed,
             const Field& field);
  void write_array(std::string_view key, const double* value, std::size_t size, const Field& field);

  bool commented_;
  std::vector<std::string> joint_names_;
  std::string section_, text_;
};

}  // namespace fricid::config
