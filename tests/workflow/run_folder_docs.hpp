// docs/run_folder.md: what lies where in a run folder and what is in it, from the structs.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>

#include "fricid/data/artefact.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid {

inline constexpr const char* kRunFolderPage = "docs/run_folder.md";

/// An archive that describes the fields of an artefact, one row each.
class FieldTable {
 public:
  template <class Value>
  void operator()(std::string_view key, [[maybe_unused]] const Value& value, const Field& field) {
    std::string_view choices = field.choices;
    if constexpr (NamedEnum<Value>) choices = names(value);
    std::string type = type_of<Value>(field);
    if (!choices.empty()) type += fmt::format(": {}", fmt::join(parts_of(choices), ", "));
    row(key, type, field);
  }
  template <class Value>
  void operator()(std::string_view key, const std::optional<Value>& /*value*/, const Field& field) {
    row(key, std::string(type_of<Value>(field)) + " or absent", field);
  }
  template <class Interval>
  void pairs(std::string_view key, const std::vector<Interval>& /*value*/, const Field& field) {
    row(key, "list of pairs", field);
  }
  template <class Value>
  void derived(std::string_view key, const Value& value, const Field& field) {
    (*this)(key, value, field);
  }
  // of signals
  void joints(const std::vector<std::string>& /*names*/) {
    row("joint_names", "attribute, list of texts", {.meaning = "one per joint, n of them"});
  }
  template <class Value>
  void attribute(std::string_view key, const Value& /*value*/, const Field& field) {
    row(key, std::is_same_v<Value, std::string> ? "attribute, text" : "attribute, number", field);
  }
  void attribute_or_zero(std::string_view key, double value, const Field& field) {
    attribute(key, value, field);
  }
  template <class Value>
  void stamp(std::string_view key, const Value& value, const Field& field) {
    attribute(key, value, field);
  }
  template <class Write, class Read>
  void text_attribute(std::string_view key, Write&& /*write*/, Read&& /*read*/,
                      const Field& field) {
    row(key, "attribute, text", field);
  }
  void times(const Eigen::VectorXd& /*t*/) {
    row("/t", "table (T)", {.meaning = "time", .unit = "s"});
  }
  void column(std::string_view key, const Eigen::VectorXd& /*values*/, const Field& field) {
    row(fmt::format("/{}", key), "table (T)", field);
  }
  void of_joints(std::string_view key, const RowMatrix& /*values*/, const Field& field) {
    row(fmt::format("/{}", key), "table (T, n)", field);
  }
  void of_joints_or_none(std::string_view key, const RowMatrix& /*values*/, const Field& field) {
    row(fmt::format("/{}", key), "table (T, n) or absent", field);
  }
  void of_states(std::string_view key, const RowMatrix& /*values*/, const Field& field) {
    row(fmt::format("/{}", key), "table (T, n_z)", field);
  }
  void of_states_or_none(std::string_view key, const RowMatrix& /*values*/, const Field& field) {
    row(fmt::format("/{}", key), "table (T, n_z) or absent", field);
  }

  template <class Part>
  void section(std::string_view key, Part& /*part*/, std::string_view meaning) {
    part<Part>(key, "object", ".", meaning);
  }
  template <class Part>
  void section(std::string_view key, std::optional<Part>& /*part*/, std::string_view meaning) {
    part<Part>(key, "object or absent", ".", meaning);
  }
  template <class Part>
  void sections(std::string_view key, std::vector<Part>& /*parts*/, std::string_view meaning) {
    part<Part>(key, "list of objects", "[].", meaning);
  }
  template <class Part>
  void sections(std::string_view key, std::optional<std::vector<Part>>& /*parts*/,
                std::string_view meaning) {
    part<Part>(key, "list of objects or absent", "[].", meaning);
  }
  template <class Part>
  void lists(std::string_view key, std::vector<std::vector<Part>>& /*lists*/,
             std::string_view meaning) {
    part<Part>(key, "list of lists of objects", "[][].", meaning);
  }
  template <class Part>
  void named(std::string_view key, std::string_view names,
             std::vector<std::pair<std::string, Part>>& /*parts*/, std::string_view meaning) {
    part<Part>(key, "object of objects", fmt::format(".{}.", names), meaning);
  }

  const std::string& text() const { return text_; }

 private:
  template <class Value>
  static const char* type_of(const Field& field) {
    if constexpr (std::is_same_v<Value, bool>)
      return "true or false";
    else if constexpr (std::is_integral_v<Value>)
      return "whole number";
    else if constexpr (std::is_floating_point_v<Value>)
      return field.required ? "number" : "number or null";
    else if constexpr (std::is_same_v<Value, std::vector<std::string>>)
      return "list of texts";
    else if constexpr (std::is_same_v<Value, std::vector<int>>)
      return "list of whole numbers";
    else if constexpr (std::is_same_v<Value, std::vector<double>> ||
                       std::is_same_v<Value, Eigen::VectorXd> ||
                       std::is_same_v<Value, Eigen::Vector3d>)
      return "list of numbers";
    else if constexpr (std::is_same_v<Value, std::vector<std::vector<double>>> ||
                       std::is_same_v<Value, Eigen::MatrixXd> ||
                       std::is_same_v<Value, Eigen::Matrix3d>)
      return "list of lists of numbers";
    else
      return "text";
  }
  void row(std::string_view key, std::string_view type, const Field& field) {
    const bool has_unit = !field.unit.empty() && field.unit != "1";
    text_ += fmt::format("| `{}{}` | {}{} | {} |\n", prefix_, key, type,
                         has_unit ? fmt::format(" [{}]", field.unit) : "", field.meaning);
  }
  template <class Part>
  void part(std::string_view key, std::string_view type, std::string_view between,
            std::string_view meaning) {
    row(key, type, {.meaning = meaning});
    const std::string outer = prefix_;
    prefix_ += fmt::format("{}{}", key, between);
    Part empty{};
    empty.visit(*this);
    prefix_ = outer;
  }

  std::string prefix_, text_;
};

/// A section of the page: one kind of file.
template <data::Artefact T>
std::string section_of(std::string_view file, std::string_view what) {
  FieldTable table;
  T empty{};
  empty.visit(table);
  return fmt::format("\n## {}\n\n{}\n\n| key | type | meaning |\n|---|---|---|\n{}", file, what,
                     table.text());
}
template <data::Artefact T>
std::string artefact_section(std::string_view file, std::string_view what) {
  return section_of<T>(file, fmt::format("{} `\"format\": \"{}\"`.", what, T::kFormat));
}
template <class T>
std::string signals_section(std::string_view file, std::string_view what) {
  return section_of<T>(
      file, fmt::format("{} HDF5, attribute `format`: `{}`; every table has an attribute `unit`.",
                        what, T::kFormat));
}

std::string run_folder_page();

}  // namespace fricid
