#include "csv.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <string_view>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/text.hpp"

namespace fricid::data {
namespace {

constexpr std::size_t kLongestQuote = 40;

std::string_view trim(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = text.substr(1, text.size() - 2);
  return text;
}

std::string in_quotes(std::string_view text) {
  std::string shown(text.substr(0, kLongestQuote));
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return "\"" + shown + (text.size() > kLongestQuote ? "..." : "") + "\"";
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

// The first of ; tab , that the header contains, else a space.
char find_separator(std::string_view header) {
  for (const char c : {';', '\t', ','})
    if (header.find(c) != std::string_view::npos) return c;
  return ' ';
}

// Cells of one line; runs of spaces separate once.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  if (separator == ' ') line = trim(line);
  while (true) {
    const std::size_t end = line.find(separator);
    cells.push_back(trim(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
    if (separator == ' ')
      while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  }
}

// False when the cell is no number.
bool parse_number(std::string_view cell, bool decimal_comma, double& value) {
  if (cell.empty()) {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  if (cell.front() == '+') cell.remove_prefix(1);
  std::string with_point;
  if (decimal_comma) {
    with_point = cell;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    cell = with_point;
  }
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && end == cell.data() + cell.size();
}

std::size_t find_column(const std::vector<std::string>& header, const std::string& name,
                        const std::string& where) {
  const auto exact = std::find(header.begin(), header.end(), name);
  if (std::count(exact, header.end(), name) > 1)
    throw UserError("{}: column {} appears twice", where, in_quotes(name));
  if (exact != header.end()) return static_cast<std::size_t>(exact - header.begin());
  std::vector<std::size_t> alike;
  for (std::size_t i = 0; i < header.size(); ++i)
    if (lower(header[i]) == lower(name)) alike.push_back(i);
  if (alike.size() == 1) return alike[0];
  const std::vector<std::string_view> known(header.begin(), header.end());
  const std::string meant = nearest(name, known);
  throw UserError("{}: no column {}; {}", where, in_quotes(name),
                  meant.empty() ? fmt::format("found: {}", fmt::join(header, ", "))
                                : fmt::format("nearest: {}", in_quotes(meant)));
}

}  // namespace

CsvTable read_csv(const std::filesystem::path& path, const std::vector<std::string>& wanted,
                  char separator, bool decimal_comma) {
  const std::string file = path.string();
  const std::string text = read_file(path);
  CsvTable table;
  std::vector<std::string_view> cells;
  std::vector<std::size_t> picked;
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  if (rest.find('\0') != std::string_view::npos) throw UserError("{}: not a text file", file);

  for (int line_number = 1; !rest.empty(); ++line_number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (trim(line).empty() || trim(line).front() == '#') continue;
    const std::string where = fmt::format("{}:{}", file, line_number);

    if (table.header.empty()) {
      if (separator == '\0') separator = find_separator(line);
      split(line, separator, cells);
      table.header.assign(cells.begin(), cells.end());
      table.header_line = line_number;
      for (const std::string& name : wanted)
        picked.push_back(find_column(table.header, name, where));
      table.columns.resize(picked.size());
      continue;
    }
    split(line, separator, cells);
    if (cells.size() == table.header.size() + 1 && cells.back().empty()) cells.pop_back();
    if (cells.size() != table.header.size())
      throw UserError("{}: {} cells; allowed: {}, as in the header", where, cells.size(),
                      table.header.size());
    for (std::size_t i = 0; i < picked.size(); ++i) {
      double value = 0;
      if (!parse_number(cells[picked[i]], decimal_comma, value))
        throw UserError("{}: {} = {}; allowed: a number", where, wanted[i],
                        in_quotes(cells[picked[i]]));
      table.columns[i].push_back(value);
    }
    table.lines.push_back(line_number);
  }
  if (table.header.empty()) throw UserError("{}: an empty file", file);
  return table;
}

}  // namespace fricid::data
