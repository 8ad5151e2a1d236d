// Artefacts: the JSON files that the stages of a run write. Each is one struct that names its
// fields once, in `visit(archive)`, and its format in `kFormat`. Writing, reading with checks and
// docs/run_folder.md use these.
#pragma once

#include <Eigen/Core>

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"
#include "fricid/base/files.hpp"

namespace fricid::data {

using Json = nlohmann::ordered_json;

namespace detail {
/// Place of an element: "models[2]".
std::string element(const std::string& list, std::size_t i);
}  // namespace detail

/// The writing archive. Numbers that are not finite become null, since JSON has no NaN.
/// @throws UserError where a required number is not finite
class JsonWriter {
 public:
  /// @param where   the file, for messages
  /// @param prefix  place of the object in it, "" or "models[2]."
  explicit JsonWriter(Json& object, std::string where = {}, std::string prefix = {});

  void operator()(std::string_view key, double value, const Field& field);
  void operator()(std::string_view key, int value, const Field& field);
  void operator()(std::string_view key, std::uint64_t value, const Field& field);
  void operator()(std::string_view key, bool value, const Field& field);
  void operator()(std::string_view key, const std::string& value, const Field& field);
  void operator()(std::string_view key, const std::vector<double>& value, const Field& field);
  void operator()(std::string_view key, const std::vector<int>& value, const Field& field);
  void operator()(std::string_view key, const std::vector<std::string>& value, const Field& field);
  void operator()(std::string_view key, const std::vector<std::vector<double>>& value,
                  const Field& field);
  void operator()(std::string_view key, const Eigen::VectorXd& value, const Field& field);
  void operator()(std::string_view key, const Eigen::MatrixXd& value, const Field& field);
  template <int N>
  requires(N > 0) void operator()(std::string_view key, const Eigen::Matrix<double, N, 1>& value,
                                  const Field& field) {
    (*this)(key, Eigen::VectorXd(value), field);
  }
  void operator()(std::string_view key, const Eigen::Matrix3d& value, const Field& field) {
    (*this)(key, Eigen::MatrixXd(value), field);
  }
  template <NamedEnum E>
  void operator()(std::string_view key, E value, const Field& field) {
    (*this)(key, std::string(name_of(value)), field);
  }
  /// Written only if there is one.
  template <class Value>
  void operator()(std::string_view key, const std::optional<Value>& value, const Field& field) {
    if (value) (*this)(key, *value, field);
  }
  /// Intervals {low, high} as lists of two.
  template <class Interval>
  void pairs(std::string_view key, const std::vector<Interval>& intervals, const Field& field) {
    std::vector<std::vector<double>> ends;
    for (const Interval& interval : intervals) ends.push_back({interval.low, interval.high});
    (*this)(key, ends, field);
  }
  /// A value computed from other fields: written for other programs, never read.
  template <class Value>
  void derived(std::string_view key, const Value& value, const Field& field) {
    (*this)(key, value, field);
  }

  template <class Part>
  void section(std::string_view key, Part& part, std::string_view /*meaning*/) {
    JsonWriter writer(child(key), where_, prefix_ + std::string(key) + ".");
    part.visit(writer);
  }
  /// Written only if not empty.
  template <class Part>
  void section(std::string_view key, std::optional<Part>& part, std::string_view meaning) {
    if (part) section(key, *part, meaning);
  }
  template <class Part>
  void sections(std::string_view key, std::vector<Part>& parts, std::string_view /*meaning*/) {
    write_parts(children(key), prefix_ + std::string(key), parts);
  }
  /// Written only if there is one.
  template <class Part>
  void sections(std::string_view key, std::optional<std::vector<Part>>& parts,
                std::string_view meaning) {
    if (parts) sections(key, *parts, meaning);
  }
  /// A list of lists of objects.
  template <class Part>
  void lists(std::string_view key, std::vector<std::vector<Part>>& lists,
             std::string_view /*meaning*/) {
    Json& array = children(key);
    for (std::size_t i = 0; i < lists.size(); ++i)
      write_parts(appended_list(array), detail::element(prefix_ + std::string(key), i), lists[i]);
  }
  /// An object of objects. @param names  stands for their keys in the documentation
  template <class Part>
  void named(std::string_view key, std::string_view /*names*/,
             std::vector<std::pair<std::string, Part>>& parts, std::string_view /*meaning*/) {
    Json& object = child(key);
    for (auto& [name, part] : parts) {
      JsonWriter writer(member(object, name), where_,
                        prefix_ + std::string(key) + "." + name + ".");
      part.visit(writer);
    }
  }

 private:
  template <class Part>
  void write_parts(Json& array, const std::string& place, std::vector<Part>& parts) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      JsonWriter writer(appended(array), where_, detail::element(place, i) + ".");
      parts[i].visit(writer);
    }
  }
  Json& child(std::string_view key);
  Json& children(std::string_view key);
  static Json& member(Json& object, const std::string& name);
  static Json& appended(Json& array);
  static Json& appended_list(Json& array);
  void require_finite(std::string_view key, double value, const Field& field) const;

  Json& object_;
  std::string where_, prefix_;
};

/// The reading archive. Every field must exist with its type, required numbers within their bounds;
/// unknown keys are ignored.
/// Errors: "file: models[2].label: found 3; allowed: text".
class JsonReader {
 public:
  /// @param where   the file, for messages
  /// @param prefix  place of the object in it, "" or "models[2]."
  JsonReader(const Json& object, std::string where, std::string prefix = {});

  void operator()(std::string_view key, double& value, const Field& field);
  void operator()(std::string_view key, int& value, const Field& field);
  void operator()(std::string_view key, std::uint64_t& value, const Field& field);
  void operator()(std::string_view key, bool& value, const Field& field);
  void operator()(std::string_view key, std::string& value, const Field& field);
  void operator()(std::string_view key, std::vector<double>& value, const Field& field);
  void operator()(std::string_view key, std::vector<int>& value, const Field& field);
  void operator()(std::string_view key, std::vector<std::string>& value, const Field& field);
  void operator()(std::string_view key, std::vector<std::vector<double>>& value,
                  const Field& field);
  void operator()(std::string_view key, Eigen::VectorXd& value, const Field& field);
  void operator()(std::string_view key, Eigen::MatrixXd& value, const Field& field);
  template <NamedEnum E>
  void operator()(std::string_view key, E& value, Field field) {
    std::string name;
    field.choices = names(value);
    (*this)(key, name, field);
    value = *value_named<E>(name);
  }
  template <int N>
  requires(N > 0) void operator()(std::string_view key, Eigen::Matrix<double, N, 1>& value,
                                  const Field& field) {
    Eigen::VectorXd list;
    (*this)(key, list, field);
    if (list.size() != N) refuse(key, std::to_string(N) + " numbers");
    value = list;
  }
  void operator()(std::string_view key, Eigen::Matrix3d& value, const Field& field);
  /// None where the key is missing.
  template <class Value>
  void operator()(std::string_view key, std::optional<Value>& value, const Field& field) {
    value.reset();
    if (has(key)) (*this)(key, value.emplace(), field);
  }
  template <class Interval>
  void pairs(std::string_view key, std::vector<Interval>& intervals, const Field& field) {
    std::vector<std::vector<double>> ends;
    (*this)(key, ends, field);
    intervals.clear();
    for (const std::vector<double>& pair : ends) {
      if (pair.size() != 2) refuse(key, "pairs of numbers");
      intervals.push_back({pair[0], pair[1]});
    }
  }
  template <class Value>
  void derived(std::string_view /*key*/, const Value& /*value*/, const Field& /*field*/) {}

  template <class Part>
  void section(std::string_view key, Part& part, std::string_view /*meaning*/) {
    JsonReader reader(child(key), where_, prefix_ + std::string(key) + ".");
    part.visit(reader);
  }
  template <class Part>
  void section(std::string_view key, std::optional<Part>& part, std::string_view meaning) {
    part.reset();
    if (has(key)) section(key, part.emplace(), meaning);
  }
  template <class Part>
  void sections(std::string_view key, std::vector<Part>& parts, std::string_view /*meaning*/) {
    read_parts(prefix_ + std::string(key), objects(key), parts);
  }
  template <class Part>
  void sections(std::string_view key, std::optional<std::vector<Part>>& parts,
                std::string_view meaning) {
    parts.reset();
    if (has(key)) sections(key, parts.emplace(), meaning);
  }
  template <class Part>
  void lists(std::string_view key, std::vector<std::vector<Part>>& lists,
             std::string_view /*meaning*/) {
    const std::vector<std::vector<const Json*>> found = lists_of_objects(key);
    lists.assign(found.size(), {});
    for (std::size_t i = 0; i < lists.size(); ++i)
      read_parts(detail::element(prefix_ + std::string(key), i), found[i], lists[i]);
  }
  template <class Part>
  void named(std::string_view key, std::string_view /*names*/,
             std::vector<std::pair<std::string, Part>>& parts, std::string_view /*meaning*/) {
    parts.clear();
    for (const auto& [name, object] : members(key)) {
      JsonReader reader(*object, where_, prefix_ + std::string(key) + "." + name + ".");
      parts.emplace_back(name, Part{}).second.visit(reader);
    }
  }

 private:
  template <class Part>
  void read_parts(const std::string& place, const std::vector<const Json*>& objects,
                  std::vector<Part>& parts) {
    parts.assign(objects.size(), Part{});
    for (std::size_t i = 0; i < parts.size(); ++i) {
      JsonReader reader(*objects[i], where_, detail::element(place, i) + ".");
      parts[i].visit(reader);
    }
  }
  bool has(std::string_view key) const;
  const Json& at(std::string_view key) const;
  const Json& child(std::string_view key) const;
  std::vector<const Json*> objects(std::string_view key) const;
  std::vector<std::vector<const Json*>> lists_of_objects(std::string_view key) const;
  std::vector<std::pair<std::string, const Json*>> members(std::string_view key) const;
  void require_bounds(std::string_view key, const Json& number, const Field& field) const;
  [[noreturn]] void refuse(std::string_view key, std::string_view allowed) const;

  const Json& object_;
  std::string where_, prefix_;
};

/// A struct that is a file of its own.
template <class T>
concept Artefact = requires {
  { T::kFormat } -> std::convertible_to<std::string_view>;
};

namespace detail {
std::unique_ptr<Json, void (*)(Json*)> new_object(std::string_view format);
std::string text_of(const Json& object);
/// @throws UserError naming `where` when the text is no JSON or of another format
std::unique_ptr<Json, void (*)(Json*)> read_object(std::string_view text, const std::string& where,
                                                   std::string_view format);
void write_object(const std::filesystem::path& path, const Json& object);
}  // namespace detail

/// The key "format" of a JSON file; empty if missing. @throws UserError if the file is not JSON
std::string format_of(const std::filesystem::path& path);

/// The artefact as JSON, its format first.
template <Artefact T>
std::string to_json(const T& artefact) {
  const auto object = detail::new_object(T::kFormat);
  JsonWriter writer(*object);
  const_cast<T&>(artefact).visit(writer);  // a writer only reads, but `visit` serves readers too
  return detail::text_of(*object);
}

/// Writes the artefact atomically. @throws UserError
template <Artefact T>
void save(const T& artefact, const std::filesystem::path& path) {
  const auto object = detail::new_object(T::kFormat);
  JsonWriter writer(*object, path.string());
  const_cast<T&>(artefact).visit(writer);
  detail::write_object(path, *object);
}

/// Reads an artefact from the text of its file, then calls its `check(place)`, if it has one, to
/// see that its parts agree.
/// @param where  the file, for messages
/// @throws UserError naming the file and the field when it is damaged or of another format
template <Artefact T>
T parse(std::string_view text, const std::string& where) {
  const auto object = detail::read_object(text, where, T::kFormat);
  T artefact;
  JsonReader reader(*object, where);
  artefact.visit(reader);
  if constexpr (requires { artefact.check(where); }) artefact.check(where);
  return artefact;
}

/// @throws UserError naming the file, also when it is missing
template <Artefact T>
T load(const std::filesystem::path& path) {
  return parse<T>(read_file(path), path.string());
}

}  // namespace fricid::data
