#include "fricid/config/toml_file.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/lines.hpp"
#include "fricid/config/paths.hpp"

namespace fricid::config {
namespace {

constexpr std::size_t kLongestQuote = 60;

std::string one_line(std::string_view text) {
  std::string line(text.substr(0, 200));
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return line;
}

// Moves every entry of `over` into `base`; a copy of a node would lose its place.
void merge(toml::table& base, toml::table&& over) {
  for (auto&& [key, node] : over) {
    toml::node* known = base.get(key.str());
    if (known && known->is_table() && node.is_table()) {
      merge(*known->as_table(), std::move(*node.as_table()));
      continue;
    }
    base.erase(key.str());
    node.visit([&base, &key = key](auto& value) { base.insert(key, std::move(value)); });
  }
}

/// Where the string that begins at `at` ends: its closing quote, or the end of its line or text.
std::size_t end_of_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string three(3, quote);
  const bool long_one = text.substr(at, 3) == three;
  for (std::size_t i = at + (long_one ? 3 : 1); i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"')
      ++i;
    else if (long_one ? text.substr(i, 3) == three : text[i] == quote)
      return long_one ? i + 2 : i;
    else if (!long_one && text[i] == '\n')
      return i - 1;
  }
  return text.size();
}

/// Nested tables are walked and freed recursively, so their depth is limited before parsing: the
/// dots of one key, and the brackets open at once.
void require_shallow(std::string_view text, const std::string& path) {
  std::uint64_t open = 0, dots = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      i = end_of_string(text, i);
    } else if (c == '#') {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else if (c == '.') {
      ++dots;
    } else if (c == '[' || c == '{') {
      ++open;
      dots = 0;
    } else if (c == ']' || c == '}') {
      open -= open > 0 ? 1 : 0;
      dots = 0;
    } else if (c == '\n' || c == '=' || c == ',') {
      dots = 0;
    }
    if (const std::uint64_t levels = std::max(open, dots + 1); levels > limits::kTomlLevels.most)
      require_within(limits::kTomlLevels, levels, fmt::format("{}:{}", path, line_at(text, i)));
  }
}

/// "file:line", the name alone of a text that no file holds, or `fallback` when none was recorded.
std::string place(const toml::source_region& source, const std::string& fallback) {
  if (!source.path || source.begin.line == 0) return fallback;
  if (is_text_alone(*source.path)) return *source.path;
  return fmt::format("{}:{}", *source.path, source.begin.line);
}

/// A scene merged with the files it extends: of these the last wins, and the scene overrides all.
class Chain {
 public:
  explicit Chain(std::vector<std::filesystem::path>& files) : files_(files) {}

  toml::table load(const std::filesystem::path& path) {
    toml::table table = parse_toml(read_file(path), path.string());
    files_.push_back(path);
    require_within(limits::kSceneFiles, files_.size(), files_.front().string());
    open_.push_back(std::filesystem::weakly_canonical(path));
    toml::table merged = with_bases(std::move(table), path);
    open_.pop_back();
    return merged;
  }

  /// A table merged with what it extends. @param path  of its file
  toml::table with_bases(toml::table table, const std::filesystem::path& path) {
    toml::table merged;
    if (const toml::node* extends = table.get("extends")) {
      if (const toml::array* names = extends->as_array(); names && !names->empty())
        for (const toml::node& name : *names) merge(merged, load_base(name, path));
      else
        merged = load_base(*extends, path);
      table.erase("extends");
    }
    merge(merged, std::move(table));
    return merged;
  }

 private:
  toml::table load_base(const toml::node& node, const std::filesystem::path& path) {
    const std::string where = place(node.source(), path.string());
    if (!node.is_string())
      throw UserError("{}: extends = {}; allowed: a file name or an array of them", where,
                      found(node));
    const std::string name = node.as_string()->get();
    std::filesystem::path base;
    try {
      base = std::filesystem::weakly_canonical(find_file(name, path.parent_path()));
      require_regular_file(base);
    } catch (const UserError& error) {
      throw UserError("{}: extends: {}", where, error.what());
    }
    if (std::find(open_.begin(), open_.end(), base) != open_.end())
      throw UserError("{}: extends = \"{}\" leads back to a scene that extends it", where, name);
    // Keep the user's way of naming files in messages where the base lies beside the scene.
    const std::filesystem::path beside = path.parent_path() / name;
    return load(std::filesystem::exists(beside) ? beside : base);
  }

  std::vector<std::filesystem::path>& files_;
  std::vector<std::filesystem::path> open_;  // from the scene asked for to the one being read
};

}  // namespace

toml::table parse_toml(const std::string& text, const std::string& path) {
  require_shallow(text, path);
  try {
    return toml::parse(std::string_view(text), std::string_view(path));
  } catch (const toml::parse_error& error) {
    throw UserError("{}: not TOML: {}", place(error.source(), path), one_line(error.description()));
  }
}

TomlFile load_toml(const std::filesystem::path& path) {
  TomlFile file{.path = path.string(), .table = {}, .files = {}};
  file.table = Chain(file.files).load(path);
  return file;
}

TomlFile load_toml_text(const std::string& text, const std::string& name) {
  TomlFile file{.path = name, .table = {}, .files = {}};
  file.table = Chain(file.files).with_bases(parse_toml(text, name), name);
  return file;
}

bool is_text_alone(std::string_view path) { return path.starts_with('<'); }

std::string place(const toml::node& node, const std::string& fallback) {
  return place(node.source(), fallback);
}

std::string place_of_key(const TomlFile& file, std::string_view key) {
  while (!key.empty()) {
    if (const auto node = file.table.at_path(key)) return place(*node.node(), file.path);
    const std::size_t dot = key.rfind('.');
    key = key.substr(0, dot == std::string_view::npos ? 0 : dot);
  }
  return file.path;
}

std::filesystem::path folder_of(const toml::node& node, const std::filesystem::path& fallback) {
  const toml::source_region& source = node.source();
  return source.path ? std::filesystem::path(*source.path).parent_path() : fallback;
}

std::optional<double> as_number(const toml::node& node) {
  if (node.is_integer()) return static_cast<double>(node.as_integer()->get());
  if (node.is_floating_point()) return node.as_floating_point()->get();
  return std::nullopt;
}

std::string found(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string: {
      const std::string& value = node.as_string()->get();
      const bool cut = value.size() > kLongestQuote;
      return fmt::format("\"{}{}\"", one_line(std::string_view(value).substr(0, kLongestQuote)),
                         cut ? "..." : "");
    }
    case toml::node_type::integer:
      return fmt::format("{}", node.as_integer()->get());
    case toml::node_type::floating_point:
      return fmt::format("{}", node.as_floating_point()->get());
    case toml::node_type::boolean:
      return node.as_boolean()->get() ? "true" : "false";
    case toml::node_type::array:
      return node.as_array()->empty() ? "an empty array"
                                      : fmt::format("an array of {}", node.as_array()->size());
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or time";
  }
}

std::string toml_number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string toml_text(std::string_view value) {
  std::string text = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') {
      text += '\\';
      text += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      text += fmt::format("\\u{:04X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      text += c;
    }
  }
  return text + '"';
}

}  // namespace fricid::config
