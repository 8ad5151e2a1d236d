#include "csv.hpp"

#include <algorithm>
#include <functional>
#include <string_view>

#include "columns.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "unit_words.hpp"

namespace fricid::data {
namespace {

// A cell without spaces and quotes around it.
std::string_view strip(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = text.substr(1, text.size() - 2);
  return text;
}

// The first of ; tab , that the header contains outside of quotes, else a space.
char find_separator(std::string_view header) {
  for (const char wanted : {';', '\t', ','}) {
    bool quoted = false;
    for (const char c : header) {
      if (c == '"') quoted = !quoted;
      if (c == wanted && !quoted) return wanted;
    }
  }
  return ' ';
}

// Where the first cell of a line ends: a separator within quotes is part of it.
std::size_t end_of_cell(std::string_view line, char separator) {
  const std::size_t begin = line.find_first_not_of(separator == '\t' ? " " : " \t");
  if (begin == std::string_view::npos || line[begin] != '"') return line.find(separator);
  const std::size_t close = line.find('"', begin + 1);
  return line.find(separator, close == std::string_view::npos ? 0 : close);
}

// Cells of one line; runs of spaces separate once.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  if (separator == ' ') line = trimmed(line);
  while (true) {
    const std::size_t end = end_of_cell(line, separator);
    cells.push_back(strip(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
    if (separator == ' ')
      while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  }
}

// Whether a text begins with the mark of UTF-16, or with one of its letters.
bool is_utf16(std::string_view text) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) return true;
  return text.size() > 3 && (text[0] == '\0') != (text[1] == '\0') &&
         (text[0] == '\0') == (text[2] == '\0') && (text[1] == '\0') == (text[3] == '\0');
}

bool is_comment(std::string_view content) { return content.starts_with('#'); }

// Reads the lines of a text one by one, comments and blank ones left out.
class Lines {
 public:
  explicit Lines(std::string_view text, const std::string& file) : rest_(text), file_(file) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
    if (is_utf16(text)) throw UserError("{}: text in UTF-16; allowed: saved as UTF-8", file);
    if (rest_.find('\0') != std::string_view::npos) throw UserError("{}: not a text file", file);
    if (rest_.find('\r') != std::string_view::npos && rest_.find('\n') == std::string_view::npos)
      throw UserError("{}: lines end with CR alone; allowed: with LF or CR LF", file);
  }
  bool next(std::string_view& line) {
    comment_ = before_comment_ = {};
    while (!rest_.empty()) {
      ++number_;
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      line = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      const std::string_view content = strip(line);
      if (!content.empty() && !is_comment(content)) return true;
      before_comment_ = comment_;
      comment_ = content;
    }
    return false;
  }
  /// What the line directly above holds behind its #, or the one above that; empty: it is no
  /// comment.
  std::string_view comment_above(int lines = 1) const {
    std::string_view content = lines == 1 ? comment_ : before_comment_;
    while (is_comment(content)) content.remove_prefix(1);
    return trimmed(content);
  }
  /// Passes over lines, whatever they hold.
  void skip(int count) {
    rest_ = without_lines(rest_, count);
    number_ += count;
  }
  int number() const { return number_; }
  std::string where() const { return fmt::format("{}:{}", file_, number_); }

 private:
  std::string_view rest_, comment_, before_comment_;
  const std::string& file_;
  int number_ = 0;
};

bool is_number(std::string_view cell, bool decimal_comma) {
  double value = 0;
  return !cell.empty() && parse_number(cell, decimal_comma, value);
}

// Whether cells are those of a row of samples: the first is a number, and half of them are.
bool are_numbers(const std::vector<std::string_view>& cells, bool decimal_comma) {
  const auto numbers = std::ranges::count_if(
      cells, [&](std::string_view cell) { return is_number(cell, decimal_comma); });
  return is_number(cells[0], decimal_comma) && 2 * numbers >= std::ssize(cells);
}

std::vector<std::string> names_of_header(std::string_view line, char separator,
                                         std::string_view prefix) {
  std::vector<std::string_view> cells;
  split(line, separator, cells);
  std::vector<std::string> names;
  for (std::string_view cell : cells) {
    if (!prefix.empty() && cell.starts_with(prefix)) cell.remove_prefix(prefix.size());
    names.push_back(as_utf8(cell));
  }
  return names;
}

// The names of the columns, and whether the line that holds them is one of samples too.
struct Header {
  std::vector<std::string> names;
  char separator = '\0';
  std::string where;  ///< of its line
  int line = 0;       ///< 0: a comment above the line that was read
  bool holds_numbers = false;
  std::vector<std::string_view> units{};  ///< of a comment between the names and the numbers
};

// The first line, or, where that holds numbers, the comment directly above with as many cells: as
// numpy.savetxt writes a header. Then the rows begin with the line in `lines`.
Header read_header(Lines& lines, std::string_view& line, const LogStyle& style,
                   std::string_view prefix, const std::string& file) {
  lines.skip(style.skip_rows);
  if (!lines.next(line))
    throw UserError("{}: {}", file,
                    style.skip_rows == 0
                        ? "an empty file"
                        : fmt::format("no header after skip_rows = {} lines", style.skip_rows));
  const auto separator_of = [&](std::string_view text) {
    return style.separator == '\0' ? find_separator(text) : style.separator;
  };
  std::vector<std::string_view> cells, cells_above;
  if (const std::string_view above = lines.comment_above(); !above.empty()) {
    const char separator = separator_of(above);
    split(above, separator, cells_above);
    split(line, separator, cells);
    if (cells.size() == cells_above.size() && are_numbers(cells, style.decimal_comma) &&
        !are_numbers(cells_above, style.decimal_comma)) {
      std::vector<std::string_view> cells_before;
      if (const std::string_view before = lines.comment_above(2);
          !before.empty() && std::ranges::all_of(cells_above, is_unit)) {
        split(before, separator, cells_before);
        if (cells_before.size() == cells.size())
          return {names_of_header(before, separator, prefix),
                  separator,
                  fmt::format("{}:{}", file, lines.number() - 2),
                  0,
                  false,
                  cells_above};
      }
      return {names_of_header(above, separator, prefix), separator,
              fmt::format("{}:{}", file, lines.number() - 1)};
    }
  }
  const char separator = separator_of(line);
  split(line, separator, cells);
  return {names_of_header(line, separator, prefix), separator, lines.where(), lines.number(),
          are_numbers(cells, style.decimal_comma)};
}

// The line among the first that names all wanted columns; 0: none.
int find_header(std::string_view text, const std::string& file,
                const std::vector<std::string>& wanted, const LogStyle& style,
                std::string_view prefix) {
  constexpr int kFarthest = 200;
  Lines lines(text, file);
  std::string_view line;
  while (lines.next(line) && lines.number() <= kFarthest) {
    const char separator = style.separator == '\0' ? find_separator(line) : style.separator;
    const std::vector<std::string> names = names_of_header(line, separator, prefix);
    if (std::ranges::all_of(wanted, [&](const std::string& name) {
          return std::ranges::any_of(names, [&](const std::string& known) {
            return lower_case(known) == lower_case(name);
          });
        }))
      return lines.number();
  }
  return 0;
}

// Places of the wanted columns; where another line is the header, or there is none, the message
// says so.
std::vector<std::size_t> pick(const Header& header, const std::vector<std::string>& wanted,
                              const std::function<int()>& find) {
  std::vector<std::size_t> picked;
  try {
    for (const std::string& name : wanted) {
      picked.push_back(find_column(header.names, name, header.where));
      for (std::size_t i = 0; i + 1 < picked.size(); ++i)
        if (picked[i] == picked.back() && wanted[i] != name)
          throw UserError("{}: {} and {} of the contract are both column {}", header.where,
                          in_quotes(wanted[i]), in_quotes(name),
                          in_quotes(header.names[picked[i]]));
    }
  } catch (const UserError& error) {
    if (const int line = find(); line != 0 && line != header.line)
      throw UserError("{}; line {} has all columns: skip_rows = {} in the contract", error.what(),
                      line, line - 1);
    if (header.holds_numbers)
      throw UserError(
          "{}: no column {}; this line is taken for the header and holds numbers; allowed: a line "
          "of names above the numbers, with or without #",
          header.where, in_quotes(wanted[0]));
    throw;
  }
  return picked;
}

// Whether the cells are words, as a row of units below the header is.
bool has_no_number(const std::vector<std::string_view>& cells,
                   const std::vector<std::size_t>& picked, bool decimal_comma) {
  return std::ranges::all_of(picked, [&](std::size_t i) {
    constexpr std::string_view kBeginsANumber = "0123456789+-.,";
    double value = 0;
    return !cells[i].empty() && kBeginsANumber.find(cells[i].front()) == std::string_view::npos &&
           !parse_number(cells[i], decimal_comma, value);
  });
}

}  // namespace

std::string_view without_lines(std::string_view text, int count) {
  for (; count > 0 && !text.empty(); --count)
    text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  return text;
}

std::vector<std::string> csv_names(std::string_view text, const std::string& file,
                                   const LogStyle& style, std::string_view prefix) {
  Lines lines(text, file);
  std::string_view line;
  return read_header(lines, line, style, prefix, file).names;
}

LogTable parse_csv(std::string_view text, const std::string& file,
                   const std::vector<std::string>& wanted, const LogStyle& style,
                   std::string_view prefix) {
  Lines lines(text, file);
  std::string_view line;
  const Header header = read_header(lines, line, style, prefix, file);
  const std::vector<std::string>& names = header.names;
  const std::vector<std::size_t> picked =
      pick(header, wanted, [&] { return find_header(text, file, wanted, style, prefix); });

  LogTable table;
  table.columns.resize(picked.size());
  const auto take_units = [&](const std::vector<std::string_view>& of_columns, int number) {
    table.units.clear();
    for (const std::size_t i : picked) table.units.emplace_back(of_columns[i]);
    table.units_line = number;
  };
  if (!header.units.empty()) take_units(header.units, lines.number() - 1);
  std::vector<std::string_view> cells;
  bool has_row = header.line == 0 || lines.next(line);
  if (const std::string_view below = lines.comment_above(); header.line != 0 && !below.empty()) {
    split(below, header.separator, cells);
    if (cells.size() == names.size() && std::ranges::all_of(cells, is_unit))
      take_units(cells, lines.number() - 1);
  }
  for (; has_row; has_row = lines.next(line)) {
    split(line, header.separator, cells);
    if (cells.size() == names.size() + 1 && cells.back().empty()) cells.pop_back();
    if (cells.size() != names.size())
      throw UserError("{}: {} cells; allowed: {}, as in the header", lines.where(), cells.size(),
                      names.size());
    if (table.lines.empty() && has_no_number(cells, picked, style.decimal_comma)) {
      take_units(cells, lines.number());
      continue;
    }
    for (std::size_t i = 0; i < picked.size(); ++i) {
      double value = 0;
      if (!parse_number(cells[picked[i]], style.decimal_comma, value))
        throw UserError("{}: {} = {}; allowed: a number{}", lines.where(), wanted[i],
                        in_quotes(cells[picked[i]]),
                        parse_number(cells[picked[i]], !style.decimal_comma, value)
                            ? fmt::format(", and with decimal_comma = {} in the contract it is one",
                                          !style.decimal_comma)
                        : cells[picked[i]].find(':') != std::string_view::npos
                            ? ", as seconds since any moment; no date"
                            : "; nan, null, none or nothing where it is missing");
      table.columns[i].push_back(value);
    }
    table.lines.push_back(lines.number());
  }
  return table;
}

}  // namespace fricid::data
