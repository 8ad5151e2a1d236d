#include "html.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace fricid::render::html {
namespace {

Html class_of(Style style) {
  switch (style) {
    case Style::kPlain:
      return {};
    case Style::kBest:
      return Html::of(" class=\"best\"");
    case Style::kBad:
      return Html::of(" class=\"bad\"");
    case Style::kSoft:
      return Html::of(" class=\"soft\"");
    case Style::kText:
      return Html::of(" class=\"text\"");
    case Style::kRule:
      return Html::of(" class=\"rule\"");
    case Style::kSoftRule:
      return Html::of(" class=\"soft rule\"");
  }
  return {};
}

}  // namespace

Html escaped(std::string_view text) {
  std::string result;
  for (const char c : text) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  return Html(Vouched{std::move(result)});
}

Html number(double value, int digits) {
  if (std::isnan(value)) return Html::of("–");
  if (std::isinf(value)) return value > 0 ? Html::of("∞") : Html::of("−∞");
  if (value == 0) return Html::of("0");
  const double magnitude = std::abs(value);
  const Html sign = value < 0 ? Html::of("−") : Html();
  if (magnitude >= 0.001 && magnitude < 1e5) {
    // The significant digits, at least those of the integer part.
    const int before = static_cast<int>(std::floor(std::log10(magnitude))) + 1;
    return Html::of("{}{:.{}f}", sign, magnitude, std::max(0, digits - before));
  }
  const std::string text = fmt::format("{:.{}e}", magnitude, digits - 1);
  const std::size_t e = text.find('e');
  const int exponent = std::stoi(text.substr(e + 1));
  return Html::of("{}{}&#8239;×&#8239;10<sup>{}{}</sup>", sign, escaped(text.substr(0, e)),
                  exponent < 0 ? Html::of("−") : Html(), std::abs(exponent));
}

Html percent(double share, int digits) {
  return std::isnan(share) ? Html::of("–") : Html::of("{}&#8239;%", number(100 * share, digits));
}

std::vector<Html> headings(std::initializer_list<std::string_view> words) {
  std::vector<Html> head;
  for (const std::string_view word : words) head.push_back(escaped(word));
  return head;
}

Html table(const std::vector<Html>& head, const std::vector<Row>& rows, const Html& caption) {
  Html text;
  if (!caption.empty()) text += Html::of("<p class=\"caption\">{}</p>\n", caption);
  text += Html::of("<div class=\"scroll\" tabindex=\"0\"><table>\n");
  if (!head.empty()) {
    text += Html::of("<thead><tr>");
    for (const Html& cell : head) text += Html::of("<th scope=\"col\">{}</th>", cell);
    text += Html::of("</tr></thead>\n");
  }
  text += Html::of("<tbody>\n");
  for (const Row& row : rows) {
    text += Html::of("<tr{}>", class_of(row.style));
    for (std::size_t c = 0; c < row.cells.size(); ++c) {
      const Html style = class_of(row.cells[c].style);
      text += c == 0 ? Html::of("<th scope=\"row\"{}>{}</th>", style, row.cells[c].text)
                     : Html::of("<td{}>{}</td>", style, row.cells[c].text);
    }
    text += Html::of("</tr>\n");
  }
  return text + Html::of("</tbody></table></div>\n");
}

Html enumeration(const std::vector<Html>& parts) {
  Html text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) text += escaped(i + 1 == parts.size() ? " and " : ", ");
    text += parts[i];
  }
  return text;
}

Html details(std::string_view summary, const Html& part) {
  if (part.empty()) return {};
  return Html::of("<details><summary>{}</summary>{}</details>\n", escaped(summary), part);
}

Html navigation(const Html& page) {
  const std::string& body = page.text();
  Html text = Html::of("<nav aria-label=\"Contents\">");
  for (std::size_t at = 0; (at = body.find("<h2 id=\"", at)) != std::string::npos;) {
    at += 8;
    const std::size_t quote = body.find('"', at), close = body.find("</h2>", quote);
    // pieces of HTML, as the page is
    const Html id(Vouched{body.substr(at, quote - at)});
    const Html title(Vouched{body.substr(quote + 2, close - quote - 2)});
    text += Html::of("<a href=\"#{}\">{}</a> ", id, title);
  }
  return text + Html::of("</nav>\n");
}

}  // namespace fricid::render::html
