#include "csv.hpp"

#include <algorithm>
#include <functional>
#include <string_view>

#include "columns.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"

namespace fricid::data {
namespace {

// A cell without spaces and quotes around it.
std::string_view strip(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = text.substr(1, text.size() - 2);
  return text;
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
  if (separator == ' ') line = strip(line);
  while (true) {
    const std::size_t end = line.find(separator);
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

// Reads the lines of a text one by one, comments and blank ones left out.
class Lines {
 public:
  explicit Lines(std::string_view text, const std::string& file) : rest_(text), file_(file) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
    if (is_utf16(text)) throw UserError("{}: text in UTF-16; allowed: saved as UTF-8", file);
    if (rest_.find('\0') != std::string_view::npos) throw UserError("{}: not a text file", file);
  }
  bool next(std::string_view& line) {
    while (!rest_.empty()) {
      ++number_;
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      line = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      const std::string_view content = strip(line);
      if (!content.empty() && content.front() != '#') return true;
    }
    return false;
  }
  /// Passes over lines, whatever they hold.
  void skip(int count) {
    rest_ = without_lines(rest_, count);
    number_ += count;
  }
  int number() const { return number_; }
  std::string where() const { return fmt::format("{}:{}", file_, number_); }

 private:
  std::string_view rest_;
  const std::string& file_;
  int number_ = 0;
};

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

std::vector<std::string> read_header(Lines& lines, const LogStyle& style, char& separator,
                                     std::string_view prefix, const std::string& file) {
  std::string_view line;
  lines.skip(style.skip_rows);
  if (!lines.next(line))
    throw UserError("{}: {}", file,
                    style.skip_rows == 0
                        ? "an empty file"
                        : fmt::format("no header after skip_rows = {} lines", style.skip_rows));
  separator = style.separator == '\0' ? find_separator(line) : style.separator;
  return names_of_header(line, separator, prefix);
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

// Places of the wanted columns; where another line is the header the message says so.
std::vector<std::size_t> pick(const std::vector<std::string>& names,
                              const std::vector<std::string>& wanted, const std::string& where,
                              int here, const std::function<int()>& header) {
  std::vector<std::size_t> picked;
  try {
    for (const std::string& name : wanted) picked.push_back(find_column(names, name, where));
  } catch (const UserError& error) {
    const int line = header();
    if (line == 0 || line == here) throw;
    throw UserError("{}; line {} has all columns: skip_rows = {} in the contract", error.what(),
                    line, line - 1);
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
  char separator = '\0';
  return read_header(lines, style, separator, prefix, file);
}

LogTable parse_csv(std::string_view text, const std::string& file,
                   const std::vector<std::string>& wanted, const LogStyle& style,
                   std::string_view prefix) {
  Lines lines(text, file);
  char separator = '\0';
  const std::vector<std::string> names = read_header(lines, style, separator, prefix, file);
  const std::vector<std::size_t> picked = pick(names, wanted, lines.where(), lines.number(), [&] {
    return find_header(text, file, wanted, style, prefix);
  });

  LogTable table;
  table.columns.resize(picked.size());
  std::vector<std::string_view> cells;
  std::string_view line;
  while (lines.next(line)) {
    split(line, separator, cells);
    if (cells.size() == names.size() + 1 && cells.back().empty()) cells.pop_back();
    if (cells.size() != names.size())
      throw UserError("{}: {} cells; allowed: {}, as in the header", lines.where(), cells.size(),
                      names.size());
    if (table.lines.empty() && has_no_number(cells, picked, style.decimal_comma)) continue;
    for (std::size_t i = 0; i < picked.size(); ++i) {
      double value = 0;
      if (!parse_number(cells[picked[i]], style.decimal_comma, value))
        throw UserError("{}: {} = {}; allowed: a number{}", lines.where(), wanted[i],
                        in_quotes(cells[picked[i]]),
                        parse_number(cells[picked[i]], !style.decimal_comma, value)
                            ? fmt::format(", and with decimal_comma = {} in the contract it is one",
                                          !style.decimal_comma)
                            : "");
      table.columns[i].push_back(value);
    }
    table.lines.push_back(lines.number());
  }
  return table;
}

}  // namespace fricid::data
