#include "terminal.hpp"

#include <algorithm>

#include "fricid/base/json.hpp"
#include "fricid/base/names.hpp"

namespace fricid::cli {
namespace {

bool is_plain(char c) { return (c >= 0x20 && c < 0x7f) || c == '\n' || c == '\t'; }

}  // namespace

std::string visible_lines(std::string_view text) {
  if (std::ranges::all_of(text, is_plain)) return std::string(text);
  std::string lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\n\t", at), text.size());
    lines += printable(text.substr(at, end - at));
    if (end < text.size()) lines += text[end];
    at = end + 1;
  }
  return lines;
}

void print(std::string_view text, std::FILE* stream) {
  if (stream != stdout) std::fflush(stdout);  // where both go to one file, in their order
  const std::string lines = visible_lines(text);
  std::fwrite(lines.data(), 1, lines.size(), stream);
}

std::string visible_json(const std::string& text) {
  if (visible_lines(text) == text) return text;
  return parse_json<nlohmann::ordered_json>(text, "stdout").dump(2, ' ', true);
}

}  // namespace fricid::cli
