#include "svg.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "html.hpp"

namespace fricid::render {
namespace {

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  std::string result;
  std::size_t begin = 0;
  for (std::size_t at = 0; (at = text.find(from, begin)) != std::string::npos;) {
    result.append(text, begin, at - begin).append(to);
    begin = at + from.size();
  }
  result.append(text, begin);
  text = std::move(result);
}

/// Removes every part from `from` to the next `to`, both included.
void remove_all(std::string& text, const std::string& from, const std::string& to) {
  std::string result;
  std::size_t begin = 0;
  while (true) {
    const std::size_t at = text.find(from, begin);
    const std::size_t end = at == std::string::npos ? at : text.find(to, at + from.size());
    if (end == std::string::npos) break;
    result.append(text, begin, at - begin);
    begin = end + to.size();
  }
  result.append(text, begin);
  text = std::move(result);
}

std::string part_between(const std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) return {};
  const std::size_t end = text.find(to, at + from.size());
  return text.substr(at + from.size(), end - at - from.size());
}

/// Tenths of a pixel as "12", "3.4" or "-.5".
std::string tenths(long value) {
  const long whole = std::abs(value) / 10, rest = std::abs(value) % 10;
  std::string text = value < 0 ? "-" : "";
  if (whole != 0 || rest == 0) text += fmt::format("{}", whole);
  if (rest != 0) text += fmt::format(".{}", rest);
  return text;
}

void shorten_paths(std::string& text) {
  std::string result;
  std::size_t begin = 0;
  for (std::size_t at = 0; (at = text.find(" d='M", begin)) != std::string::npos;) {
    const std::size_t end = text.find('\'', at + 4);
    if (end == text.npos) break;
    result.append(text, begin, at - begin);
    result += " d='" + relative_path(text.substr(at + 4, end - at - 4)) + "'";
    begin = end + 1;
  }
  result.append(text, begin);
  text = std::move(result);
}

/// The end of a tag: the next > outside quotes.
std::size_t end_of_tag(std::string_view text, std::size_t begin) {
  char quote = 0;
  for (std::size_t i = begin; i < text.size(); ++i) {
    if (quote != 0)
      quote = text[i] == quote ? '\0' : quote;
    else if (text[i] == '"' || text[i] == '\'')
      quote = text[i];
    else if (text[i] == '>')
      return i;
  }
  return text.npos;
}

bool is_plain_tag(std::string_view tag) {
  constexpr std::array<std::string_view, 21> kElements{
      "svg",    "g",       "title", "desc",     "defs",        "circle",         "path",
      "line",   "polygon", "rect",  "polyline", "text",        "tspan",          "use",
      "filter", "feFlood", "image", "pattern",  "feComposite", "linearGradient", "stop"};
  if (tag.starts_with('/')) tag.remove_prefix(1);
  const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n/"));
  if (std::find(kElements.begin(), kElements.end(), name) == kElements.end()) return false;
  std::string lower(tag);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (std::size_t at = 0; (at = lower.find("href", at)) != lower.npos; at += 4) {
    const std::string_view rest = std::string_view(lower).substr(at + 4);
    if (!rest.starts_with("=\"#") && !rest.starts_with("='#")) return false;
  }
  // An attribute begins after blank space, a slash or the quotes of the one before.
  for (std::size_t at = 0; (at = lower.find("on", at)) != lower.npos; at += 2) {
    const char before = at > 0 ? lower[at - 1] : '\0';
    if (before == ' ' || before == '\t' || before == '\r' || before == '\n' || before == '/' ||
        before == '"' || before == '\'')
      return false;
  }
  return lower.find("javascript") == lower.npos;
}

/// The text between tags with its quotes and > escaped, which delimit attributes below.
std::string with_escaped_words(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '<') {
      const std::size_t end = std::min(end_of_tag(text, i), text.size() - 1);
      result += text.substr(i, end - i + 1);
      i = end;
      continue;
    }
    result += text[i] == '"'    ? std::string("&quot;")
              : text[i] == '\'' ? std::string("&#39;")
              : text[i] == '>'  ? std::string("&gt;")
                                : std::string(1, text[i]);
  }
  return result;
}

}  // namespace

bool is_plain_svg(std::string_view file) {
  const std::size_t begin = file.find("<svg");
  if (begin == file.npos) return false;
  for (std::size_t at = begin; (at = file.find('<', at)) != file.npos;) {
    const std::size_t end = end_of_tag(file, at);
    if (end == file.npos || !is_plain_tag(file.substr(at + 1, end - at - 1))) return false;
    at = end + 1;
  }
  return true;
}

Svg plain_svg(std::string file, const std::string& place) {
  if (!is_plain_svg(file))
    throw UserError(
        "{}: no picture that gnuplot drew; remove it, or draw it again by `fricid render`", place);
  return Svg(Vouched{std::move(file)});
}

Svg read_svg(const std::filesystem::path& path) {
  return plain_svg(read_file(path), path.string());
}

std::string relative_path(const std::string& d) {
  std::string result;
  long last_x = 0, last_y = 0;
  char command = 'M', written = 0;
  const char *at = d.data(), *end = d.data() + d.size();
  while (at < end) {
    if (*at == 'M' || *at == 'L') {
      command = *at++;
      continue;
    }
    double x = 0, y = 0;
    const auto [after_x, bad_x] = std::from_chars(at, end, x);
    if (bad_x != std::errc()) {
      if (*at == 'Z' || *at == 'z') result += 'z';
      ++at;
      continue;
    }
    const auto [after_y, bad_y] = std::from_chars(std::min(after_x + 1, end), end, y);
    if (bad_y != std::errc()) break;
    at = after_y;
    const long px = std::lround(10 * x), py = std::lround(10 * y);
    if (command == 'M') {
      result += fmt::format("M{},{}", tenths(px), tenths(py));
      written = 'M';
    } else if (px != last_x || py != last_y) {
      const std::string dx = tenths(px - last_x), dy = tenths(py - last_y);
      if (written != 'l')
        result += 'l';
      else if (dx[0] != '-')
        result += ' ';
      result += dx + (dy[0] == '-' ? "" : ",") + dy;
      written = 'l';
    }
    last_x = px;
    last_y = py;
  }
  return result;
}

Html inline_svg(const Svg& picture, std::string_view label) {
  const std::string& file = picture.text();
  const std::string width = part_between(file, "width=\"", "\""),
                    height = part_between(file, "height=\"", "\"");
  const std::size_t body = file.find('>', file.find("<svg"));
  std::string text = with_escaped_words(std::string_view(file).substr(body + 1));
  remove_all(text, "<title>", "</title>");
  remove_all(text, "<desc>", "</desc>");
  remove_all(text, "<defs>", "</defs>");
  remove_all(text, " id=\"", "\"");
  remove_all(text, " font-family=\"", "\"");
  replace_all(text, " class=\"gridline\"", "");
  for (const char* name : {"stroke", "fill", "color"})
    for (const char* black :
         {"'black'", "\"black\"", "'rgb(  0,   0,   0)'", "\"rgb(  0,   0,   0)\""})
      replace_all(text, std::string(name) + "=" + black, std::string(name) + "='currentColor'");
  replace_all(text, "stroke='rgb(221, 221, 221)'", "class='gridline'");
  replace_all(text, "color='white'", "style='color:var(--paper)'");
  shorten_paths(text);
  for (const char* space : {"\t", "\r"}) replace_all(text, space, "");
  for (std::string before; before != text;) {
    before = text;
    replace_all(text, "\n\n", "\n");
  }
  // parts of a plain picture are plain
  return Html::of(
      "<svg viewBox=\"0 0 {0} {1}\" style=\"--width:{0}px\" role=\"img\" aria-label=\"{2}\">{3}",
      html::escaped(width), html::escaped(height), html::escaped(label), Html(Vouched{text}));
}

Html svg_symbols(const Svg& picture) {
  std::string symbols = part_between(picture.text(), "<defs>", "</defs>");
  remove_all(symbols, "<filter", "</filter>");
  return Html::of(
      "<svg width=\"0\" height=\"0\" class=\"symbols\" "
      "aria-hidden=\"true\"><defs>{}</defs></svg>\n",
      Html(Vouched{symbols}));
}

}  // namespace fricid::render
