#include "fricid/config/toml_writer.hpp"

#include <fmt/format.h>

#include "fricid/config/toml_file.hpp"
#include "fricid/config/toml_reader.hpp"

namespace fricid::config {

std::string TomlWriter::as_comment(const std::string& text) {
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    if (end > begin) result += "# ";
    result += text.substr(begin, end - begin) + "\n";
    begin = end + 1;
  }
  return result;
}

std::string TomlWriter::open(std::string_view left, std::string_view key, std::string_view right,
                             std::string_view meaning) {
  const std::string outer = section_;
  section_ = outer.empty() ? std::string(key) : fmt::format("{}.{}", outer, key);
  text_ += '\n';
  if (commented_) text_ += fmt::format("# {}\n", meaning);
  text_ += fmt::format("{}{}{}\n", left, section_, right);
  return outer;
}

void TomlWriter::write(std::string_view key, const std::string& value, const std::string& allowed,
                       const Field& field) {
  if (commented_)
    text_ += fmt::format("# {}{}{}{}\n", field.required ? "required: " : "", field.meaning,
                         allowed.empty() ? "" : "; ", allowed);
  text_ += fmt::format("{} = {}\n", key, value);
}

void TomlWriter::operator()(std::string_view key, double value, const Field& field) {
  write(key, toml_number(value), allowed_number(field, false), field);
}

void TomlWriter::operator()(std::string_view key, int value, const Field& field) {
  write(key, fmt::format("{}", value), allowed_number(field, true), field);
}

void TomlWriter::operator()(std::string_view key, std::uint64_t value, const Field& field) {
  write(key, fmt::format("{}", value), allowed_number(field, true), field);
}

void TomlWriter::operator()(std::string_view key, bool value, const Field& field) {
  write(key, value ? "true" : "false", "true or false", field);
}

void TomlWriter::operator()(std::string_view key, const std::string& value, const Field& field) {
  write(key, toml_text(value), field.choices.empty() ? "" : allowed_text(field), field);
}

void TomlWriter::operator()(std::string_view key, const std::vector<double>& value,
                            const Field& field) {
  write_array(key, value.data(), value.size(), field);
}

void TomlWriter::operator()(std::string_view key, const std::vector<int>& value,
                            const Field& field) {
  write(key, fmt::format("[{}]", fmt::join(value, ", ")),
        fmt::format("an array, each {}", allowed_number(field, true)), field);
}

void TomlWriter::operator()(std::string_view key, const std::vector<std::string>& value,
                            const Field& field) {
  std::string list;
  for (const std::string& item : value) list += (list.empty() ? "" : ", ") + toml_text(item);
  write(key, "[" + list + "]", "", field);
}

void TomlWriter::operator()(std::string_view key, const std::map<std::string, double>& value,
                            const Field& field) {
  std::string list;
  for (const auto& [name, number] : value)
    list +=
        fmt::format("{}{} = {}", list.empty() ? "" : ", ", toml_text(name), toml_number(number));
  write(key, "{" + list + "}", fmt::format("{{NAME = {}, ...}}", allowed_number(field, false)),
        field);
}

void TomlWriter::write_array(std::string_view key, const double* value, std::size_t size,
                             const Field& field) {
  std::string list;
  for (std::size_t i = 0; i < size; ++i) list += (i ? ", " : "") + toml_number(value[i]);
  write(key, "[" + list + "]",
        field.per_joint
            ? fmt::format("{}, or an array of them, one per joint", allowed_number(field, false))
            : fmt::format("an array, each {}", allowed_number(field, false)),
        field);
}

}  // namespace fricid::config
