#include "fricid/data/artefact.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "file_format.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/json.hpp"
#include "fricid/base/names.hpp"

namespace fricid::data {
namespace {

constexpr std::string_view kNumber = "a number or null", kWhole = "a whole number",
                           kNumbers = "a list of numbers or nulls", kWholes = "whole numbers",
                           kTexts = "a list of texts", kMatrix = "lists of numbers or nulls";

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

template <class Range>
Json numbers(const Range& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(number_or_null(value));
  return array;
}

bool is_number(const Json& value) { return value.is_number() || value.is_null(); }

bool are_numbers(const Json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), is_number);
}

double number_of(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

std::vector<double> numbers_of(const Json& array) {
  std::vector<double> values;
  values.reserve(array.size());
  for (const Json& value : array) values.push_back(number_of(value));
  return values;
}

bool is_int(const Json& value) {
  return value.is_number_integer() &&
         (value.is_number_unsigned()
              ? value.get<std::uint64_t>() <= std::numeric_limits<int>::max()
              : value.get<std::int64_t>() >= std::numeric_limits<int>::min());
}

}  // namespace

std::string detail::element(const std::string& list, std::size_t i) {
  return fmt::format("{}[{}]", list, i);
}

JsonWriter::JsonWriter(Json& object, std::string where, std::string prefix)
    : object_(object), where_(std::move(where)), prefix_(std::move(prefix)) {}

void JsonWriter::require_finite(std::string_view key, double value, const Field& field) const {
  if (field.required && !std::isfinite(value))
    throw UserError("{}: {}{}: found {}; allowed: finite", where_, prefix_, key, value);
}

void JsonWriter::operator()(std::string_view key, double value, const Field& field) {
  require_finite(key, value, field);
  object_[std::string(key)] = number_or_null(value);
}
void JsonWriter::operator()(std::string_view key, int value, const Field& /*field*/) {
  object_[std::string(key)] = value;
}
void JsonWriter::operator()(std::string_view key, std::uint64_t value, const Field& /*field*/) {
  object_[std::string(key)] = value;
}
void JsonWriter::operator()(std::string_view key, bool value, const Field& /*field*/) {
  object_[std::string(key)] = value;
}
void JsonWriter::operator()(std::string_view key, const std::string& value,
                            const Field& /*field*/) {
  object_[std::string(key)] = value;
}
void JsonWriter::operator()(std::string_view key, const std::vector<double>& value,
                            const Field& field) {
  for (const double item : value) require_finite(key, item, field);
  object_[std::string(key)] = numbers(value);
}
void JsonWriter::operator()(std::string_view key, const std::vector<int>& value,
                            const Field& /*field*/) {
  object_[std::string(key)] = value;
}
void JsonWriter::operator()(std::string_view key, const std::vector<std::string>& value,
                            const Field& /*field*/) {
  object_[std::string(key)] = value;
}
void JsonWriter::operator()(std::string_view key, const std::vector<std::vector<double>>& value,
                            const Field& field) {
  Json& rows = children(key);
  for (const std::vector<double>& row : value) {
    for (const double item : row) require_finite(key, item, field);
    rows.push_back(numbers(row));
  }
}
void JsonWriter::operator()(std::string_view key, const Eigen::VectorXd& value,
                            const Field& field) {
  (*this)(key, std::vector<double>(value.begin(), value.end()), field);
}
void JsonWriter::operator()(std::string_view key, const Eigen::MatrixXd& value,
                            const Field& field) {
  std::vector<std::vector<double>> rows;
  for (const auto& row : value.rowwise()) rows.emplace_back(row.begin(), row.end());
  (*this)(key, rows, field);
}

Json& JsonWriter::child(std::string_view key) { return object_[std::string(key)] = Json::object(); }
Json& JsonWriter::children(std::string_view key) {
  return object_[std::string(key)] = Json::array();
}
Json& JsonWriter::member(Json& object, const std::string& name) {
  return object[name] = Json::object();
}
Json& JsonWriter::appended(Json& array) {
  array.push_back(Json::object());
  return array.back();
}
Json& JsonWriter::appended_list(Json& array) {
  array.push_back(Json::array());
  return array.back();
}

JsonReader::JsonReader(const Json& object, std::string where, std::string prefix)
    : object_(object), where_(std::move(where)), prefix_(std::move(prefix)) {}

bool JsonReader::has(std::string_view key) const { return object_.contains(std::string(key)); }

const Json& JsonReader::at(std::string_view key) const {
  const auto found = object_.find(std::string(key));
  if (found == object_.end()) throw UserError("{}: found no {}{}", where_, prefix_, key);
  return *found;
}

void JsonReader::refuse(std::string_view key, std::string_view allowed) const {
  throw UserError("{}: {}{}: found {}; allowed: {}", where_, prefix_, key, shown(at(key)), allowed);
}

const Json& JsonReader::child(std::string_view key) const {
  const Json& value = at(key);
  if (!value.is_object()) refuse(key, "an object");
  return value;
}

namespace {

/// The elements of a list of objects; nothing of anything else.
std::optional<std::vector<const Json*>> objects_of(const Json& list) {
  if (!list.is_array()) return std::nullopt;
  std::vector<const Json*> objects;
  for (const Json& item : list) {
    if (!item.is_object()) return std::nullopt;
    objects.push_back(&item);
  }
  return objects;
}

}  // namespace

std::vector<const Json*> JsonReader::objects(std::string_view key) const {
  auto found = objects_of(at(key));
  if (!found) refuse(key, "a list of objects");
  return *std::move(found);
}

std::vector<std::vector<const Json*>> JsonReader::lists_of_objects(std::string_view key) const {
  const Json& value = at(key);
  if (!value.is_array()) refuse(key, "lists of objects");
  std::vector<std::vector<const Json*>> lists;
  for (const Json& item : value) {
    auto found = objects_of(item);
    if (!found) refuse(key, "lists of objects");
    lists.push_back(*std::move(found));
  }
  return lists;
}

std::vector<std::pair<std::string, const Json*>> JsonReader::members(std::string_view key) const {
  std::vector<std::pair<std::string, const Json*>> found;
  for (const auto& [name, value] : child(key).items()) {
    if (!value.is_object()) refuse(key, "an object of objects");
    found.emplace_back(name, &value);
  }
  return found;
}

void JsonReader::require_bounds(std::string_view key, const Json& value, const Field& field) const {
  if (!field.required) return;
  if (!value.is_number()) refuse(key, "a number");
  const double x = value.get<double>();
  if (x >= field.lower && x <= field.upper) return;
  const bool open = field.upper >= kUnbounded;
  throw UserError("{}: {}{}: found {}; allowed: {:g} {}", where_, prefix_, key, shown(value),
                  field.lower, open ? "or more" : fmt::format("to {:g}", field.upper));
}

void JsonReader::operator()(std::string_view key, double& value, const Field& field) {
  const Json& json = at(key);
  if (!is_number(json)) refuse(key, field.required ? "a number" : kNumber);
  require_bounds(key, json, field);
  value = number_of(json);
}

void JsonReader::operator()(std::string_view key, int& value, const Field& field) {
  const Json& json = at(key);
  if (!is_int(json)) refuse(key, kWhole);
  require_bounds(key, json, field);
  value = json.get<int>();
}

void JsonReader::operator()(std::string_view key, std::uint64_t& value, const Field& /*field*/) {
  const Json& json = at(key);
  if (!json.is_number_unsigned()) refuse(key, kWhole);
  value = json.get<std::uint64_t>();
}

void JsonReader::operator()(std::string_view key, bool& value, const Field& /*field*/) {
  const Json& json = at(key);
  if (!json.is_boolean()) refuse(key, "true or false");
  value = json.get<bool>();
}

void JsonReader::operator()(std::string_view key, std::string& value, const Field& field) {
  const Json& json = at(key);
  if (!json.is_string()) refuse(key, "text");
  value = json.get<std::string>();
  if (field.choices.empty()) return;
  const std::vector<std::string> allowed = parts_of(field.choices);
  if (std::ranges::find(allowed, value) == allowed.end())
    refuse(key, fmt::format("{}", fmt::join(allowed, ", ")));
}

void JsonReader::operator()(std::string_view key, std::vector<double>& value, const Field& field) {
  const Json& json = at(key);
  if (!are_numbers(json)) refuse(key, kNumbers);
  for (const Json& item : json) require_bounds(key, item, field);
  value = numbers_of(json);
}

void JsonReader::operator()(std::string_view key, std::vector<int>& value, const Field& /*field*/) {
  const Json& json = at(key);
  if (!json.is_array() || !std::all_of(json.begin(), json.end(), is_int)) refuse(key, kWholes);
  value = json.get<std::vector<int>>();
}

void JsonReader::operator()(std::string_view key, std::vector<std::string>& value,
                            const Field& /*field*/) {
  const Json& json = at(key);
  const auto is_text = [](const Json& item) { return item.is_string(); };
  if (!json.is_array() || !std::all_of(json.begin(), json.end(), is_text)) refuse(key, kTexts);
  value = json.get<std::vector<std::string>>();
}

void JsonReader::operator()(std::string_view key, std::vector<std::vector<double>>& value,
                            const Field& field) {
  const Json& json = at(key);
  if (!json.is_array() || !std::all_of(json.begin(), json.end(), are_numbers)) refuse(key, kMatrix);
  value.clear();
  for (const Json& row : json) {
    for (const Json& item : row) require_bounds(key, item, field);
    value.push_back(numbers_of(row));
  }
}

void JsonReader::operator()(std::string_view key, Eigen::VectorXd& value, const Field& field) {
  std::vector<double> list;
  (*this)(key, list, field);
  value = Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<Eigen::Index>(list.size()));
}

void JsonReader::operator()(std::string_view key, Eigen::MatrixXd& value, const Field& field) {
  std::vector<std::vector<double>> rows;
  (*this)(key, rows, field);
  const std::size_t columns = rows.empty() ? 0 : rows.front().size();
  value.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].size() != columns) refuse(key, "rows of one length");
    for (std::size_t k = 0; k < columns; ++k)
      value(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = rows[i][k];
  }
}

void JsonReader::operator()(std::string_view key, Eigen::Matrix3d& value, const Field& field) {
  Eigen::MatrixXd rows;
  (*this)(key, rows, field);
  if (rows.rows() != 3 || rows.cols() != 3) refuse(key, "3 rows of 3 numbers");
  value = rows;
}

namespace {

Json parsed(std::string_view text, const std::string& where) {
  if (text.empty()) throw UserError("{}: an empty file", where);
  return parse_json<Json>(text, where);
}

}  // namespace

std::string format_of(const std::filesystem::path& path) {
  const Json json = parsed(read_file(path), path.string());
  const auto found = json.find("format");
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

namespace detail {
namespace {

using JsonPointer = std::unique_ptr<Json, void (*)(Json*)>;

JsonPointer owned(Json json) {
  return {new Json(std::move(json)), [](Json* object) { delete object; }};
}

}  // namespace

JsonPointer new_object(std::string_view format) { return owned({{"format", format}}); }

std::string text_of(const Json& object) {
  // names and texts were checked where they entered; what is no UTF-8 all the same must not throw
  return object.dump(1, ' ', false, nlohmann::detail::error_handler_t::replace) + "\n";
}

JsonPointer read_object(std::string_view text, const std::string& where, std::string_view format) {
  JsonPointer object = owned(parsed(text, where));
  const auto found = object->find("format");
  if (found != object->end() && found->is_string())
    refuse_newer(where, found->get_ref<const std::string&>(), format);
  if (found == object->end() || *found != format)
    throw UserError("{}: found {}; allowed: \"format\": \"{}\"", where,
                    found == object->end() ? "no format" : shown(*found), format);
  return object;
}

void write_object(const std::filesystem::path& path, const Json& object) {
  write_file_atomically(path, text_of(object));
}

}  // namespace detail
}  // namespace fricid::data
