#include "html.hpp"

#include <cmath>

#include <fmt/format.h>

namespace fricid::render::html {

std::string escaped(std::string_view text) {
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
  return result;
}

std::string number(double value, int digits) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  if (value == 0) return "0";
  const double magnitude = std::abs(value);
  const std::string sign = value < 0 ? "−" : "";
  if (magnitude >= 0.001 && magnitude < 1e5) {
    // The digits that count, and no more than the integer part needs.
    const int before = static_cast<int>(std::floor(std::log10(magnitude))) + 1;
    return sign + fmt::format("{:.{}f}", magnitude, std::max(0, digits - before));
  }
  const std::string text = fmt::format("{:.{}e}", magnitude, digits - 1);
  const std::size_t e = text.find('e');
  const int exponent = std::stoi(text.substr(e + 1));
  return fmt::format("{}{}&#8239;×&#8239;10<sup>{}{}</sup>", sign, text.substr(0, e),
                     exponent < 0 ? "−" : "", std::abs(exponent));
}

std::string percent(double share, int digits) {
  return std::isnan(share) ? "–" : number(100 * share, digits) + "&#8239;%";
}

std::string table(const std::vector<std::string>& head, const std::vector<Row>& rows,
                  const std::string& caption) {
  const auto style = [](const std::string& name) {
    return name.empty() ? std::string() : fmt::format(" class=\"{}\"", name);
  };
  std::string text;
  if (!caption.empty()) text += fmt::format("<p class=\"caption\">{}</p>\n", caption);
  text += "<div class=\"scroll\" tabindex=\"0\"><table>\n";
  if (!head.empty()) {
    text += "<thead><tr>";
    for (const std::string& cell : head) text += fmt::format("<th scope=\"col\">{}</th>", cell);
    text += "</tr></thead>\n";
  }
  text += "<tbody>\n";
  for (const Row& row : rows) {
    text += fmt::format("<tr{}>", style(row.style));
    for (std::size_t c = 0; c < row.cells.size(); ++c)
      text += c == 0 ? fmt::format("<th scope=\"row\"{}>{}</th>", style(row.cells[c].style),
                                   row.cells[c].text)
                     : fmt::format("<td{}>{}</td>", style(row.cells[c].style), row.cells[c].text);
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

}  // namespace fricid::render::html
