#include "letters.hpp"

#include <fmt/format.h>

#include <map>
#include <vector>

#include "program.hpp"

namespace fricid::render {
namespace {

/// Bytes of the character that begins with this one.
std::size_t length_of(unsigned char first) {
  return first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
}

char32_t code_of(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first;
  char32_t code = first & (0xffu >> (character.size() + 1));
  for (const char byte : character.substr(1))
    code = (code << 6) | (static_cast<unsigned char>(byte) & 0x3fu);
  return code;
}

/// Latin, Greek and Cyrillic letters and the signs of formulas, which DejaVu Sans has.
bool is_of_the_usual_font(char32_t code) {
  return code < 0x530 || (code >= 0x1e00 && code < 0x2c00);
}

/// The letters of a text.
std::vector<std::string_view> letters_of(std::string_view text) {
  std::vector<std::string_view> letters;
  for (std::size_t at = 0; at < text.size(); at += letters.back().size())
    letters.push_back(text.substr(at, length_of(static_cast<unsigned char>(text[at]))));
  return letters;
}

}  // namespace

std::string shortened(std::string_view text, std::size_t most) {
  const std::vector<std::string_view> letters = letters_of(text);
  if (letters.size() <= most) return std::string(text);
  const std::size_t begin = most / 2, end = most - 1 - begin;
  std::string out;
  for (std::size_t i = 0; i < begin; ++i) out += letters[i];
  out += "\u2026";
  for (std::size_t i = letters.size() - end; i < letters.size(); ++i) out += letters[i];
  return out;
}

std::string with_known_letters(std::string_view text) {
  std::map<char32_t, bool> known;
  std::string out;
  for (const std::string_view character : letters_of(text)) {
    const char32_t code = code_of(character);
    if (!is_of_the_usual_font(code)) {
      const auto [entry, is_new] = known.try_emplace(code, false);
      if (is_new)
        entry->second = run_program({"fc-list", "-q",
                                     fmt::format(":charset={:x}", static_cast<unsigned>(code))})
                            .succeeded();
      if (!entry->second) {
        out += "\u25a1";
        continue;
      }
    }
    out += character;
  }
  return out;
}

}  // namespace fricid::render
