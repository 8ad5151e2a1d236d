// The writing archive: every field of a configuration struct as TOML, with or without comments.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fricid/data/field.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::data {

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
  template <std::size_t N>
  void operator()(std::string_view key, const std::array<double, N>& value, const Field& field) {
    write_array(key, value.data(), N, field);
  }

  template <class Config>
  void section(std::string_view key, Config& config, std::string_view meaning) {
    const std::string outer = open("[", key, "]", meaning);
    config.visit(*this);
    section_ = outer;
  }
  void section(std::string_view key, std::optional<friction::Friction>& friction,
               std::string_view meaning);

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

 private:
  // A table that is optional: shown, but as a comment.
  template <class Config>
  void write_example(std::string_view key, Config config, std::string_view meaning) {
    TomlWriter writer(true, joint_names_);
    writer.section_ = section_;
    writer.open("[[", key, "]]", meaning);
    config.visit(writer);
    text_ += as_comment(writer.text());
  }
  static std::string as_comment(const std::string& text);
  std::string open(std::string_view left, std::string_view key, std::string_view right,
                   std::string_view meaning);
  void write(std::string_view key, const std::string& value, const std::string& allowed,
             const Field& field);
  void write_array(std::string_view key, const double* value, std::size_t size, const Field& field);

  bool commented_;
  std::vector<std::string> joint_names_;
  std::string section_, text_;
};

}  // namespace fricid::data
