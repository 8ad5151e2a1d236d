#include "fricid/base/names.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"

namespace fricid {
namespace {

constexpr std::size_t kLongestQuote = 60;

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/// One character of UTF-8.
struct Character {
  char32_t code;
  std::size_t size;  ///< [bytes]
};

/// The character at the front; nothing when the bytes are not UTF-8 (RFC 3629: no overlong forms,
/// no surrogates, nothing above U+10FFFF).
std::optional<Character> first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return Character{lead, 1};
  const std::size_t size = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : lead >= 0xc0 ? 2 : 0;
  if (size == 0 || lead > 0xf4 || text.size() < size) return {};
  char32_t code = lead & (0x7fu >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0u) != 0x80u) return {};
    code = (code << 6) | (byte(i) & 0x3fu);
  }
  constexpr std::array<char32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  if (code < kLeast[size] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return {};
  return Character{code, size};
}

/// Whether a character has a glyph and leaves the order of the others alone.
bool shows(char32_t c) {
  const auto within = [c](char32_t low, char32_t high) { return c >= low && c <= high; };
  return !(c < 0x20 || within(0x7f, 0x9f) || c == 0xad || c == 0x061c || within(0x200b, 0x200f) ||
           within(0x2028, 0x202e) || within(0x2060, 0x206f) || c == 0xfeff ||
           within(0xfff0, 0xfffb) || within(0xe000, 0xf8ff) || (c & 0xfffe) == 0xfffe ||
           within(0xfdd0, 0xfdef) || within(0xe0000, 0x10ffff));
}

/// Calls use(bytes, code) for each character; code is nothing for a byte that is not UTF-8.
template <class Use>
void for_each_character(std::string_view text, Use use) {
  while (!text.empty()) {
    const std::optional<Character> c = first_character(text);
    const std::size_t size = c ? c->size : 1;
    use(text.substr(0, size), c ? std::optional(c->code) : std::nullopt);
    text.remove_prefix(size);
  }
}

bool all_show(std::string_view text) {
  bool all = true;
  for_each_character(text, [&](std::string_view, std::optional<char32_t> code) {
    all = all && code && shows(*code);
  });
  return all;
}

/// Letters beyond ASCII are whatever shows and is no space.
bool is_made_of(std::string_view name, std::string_view signs, bool foreign_letters) {
  bool all = true;
  for_each_character(name, [&](std::string_view bytes, std::optional<char32_t> code) {
    const char c = bytes[0];
    const bool wide_space =
        code && (*code == 0xa0 || *code == 0x1680 || *code == 0x3000 ||
                 (*code >= 0x2000 && *code <= 0x200a) || *code == 0x202f || *code == 0x205f);
    const bool fits = code && (*code < 0x80 ? is_plain(c) || signs.find(c) != signs.npos
                                            : foreign_letters && shows(*code) && !wide_space);
    all = all && fits;
  });
  return all;
}

std::string_view word_of(Named kind) {
  switch (kind) {
    case Named::kJoint:
      return "joint";
    case Named::kLink:
      return "link";
    case Named::kRobot:
      return "robot";
    case Named::kScene:
      return "scene";
    case Named::kModel:
      return "model";
    case Named::kTrajectory:
      return "trajectory";
  }
  return "";
}

std::string shortened(std::string_view text) {
  std::string shown = printable(text.substr(0, kLongestQuote));
  return text.size() > kLongestQuote ? shown + "..." : shown;
}

bool is_sized(std::string_view name) {
  return !name.empty() && name.size() <= limits::kNameBytes.most;
}

/// Not hidden, not an option of a program.
bool begins_a_file(std::string_view name) {
  return name.front() != '-' && name.front() != '.' && name.front() != ' ';
}

[[noreturn]] void refuse(Named kind, std::string_view name, std::string_view place,
                         std::string_view allowed) {
  throw UserError("{}: name of a {} = \"{}\"; allowed: 1 to {} {}", place, word_of(kind),
                  shortened(name), limits::kNameBytes.most, allowed);
}

}  // namespace

void require_written_name(Named kind, std::string_view name, std::string_view place) {
  switch (kind) {
    case Named::kJoint:
    case Named::kLink:
    case Named::kRobot:
      if (!is_sized(name) || name.front() == ' ' || name.back() == ' ' ||
          !is_made_of(name, " _-.()/:", true))
        refuse(kind, name, place, "letters, digits, space and _ - . ( ) / :, no space at the ends");
      return;
    case Named::kScene:
      if (!is_sized(name) || !begins_a_file(name) || name.front() == '(' || name.back() == ' ' ||
          name.back() == '.' || !is_made_of(name, " _-.()", true))
        refuse(kind, name, place,
               "letters, digits, space and _ - . ( ), beginning with a letter, digit or _, not "
               "ending with a space or dot");
      return;
    case Named::kModel:
      if (!is_sized(name) || !begins_a_file(name) || !is_made_of(name, "_-.", false))
        refuse(kind, name, place, "letters, digits, _ - and ., not beginning with - or .");
      return;
    case Named::kTrajectory:
      if (!is_sized(name) || !begins_a_file(name) || !all_show(name) ||
          name.find_first_of("/\\") != name.npos)
        refuse(kind, name, place,
               "letters and signs that show, without / and \\, not beginning with - . or a space");
      return;
  }
}

void require_name(Named kind, std::string_view name, std::string_view place) {
  require_written_name(kind, name, place);
  if (kind == Named::kModel && (name == "oracle" || name == "simulator"))
    throw UserError("{}: name of a {} = \"{}\"; allowed: any other; this one stands for the truth",
                    place, word_of(kind), name);
}

void require_label(std::string_view label, std::string_view key, std::string_view place) {
  if (label.size() > limits::kLabelBytes.most || !all_show(label))
    throw UserError("{}: {} = \"{}\"; allowed: up to {} bytes of UTF-8 without control characters",
                    place, key, shortened(label), limits::kLabelBytes.most);
}

std::string printable(std::string_view text) {
  std::string result;
  for_each_character(text, [&](std::string_view bytes, std::optional<char32_t> code) {
    if (code && shows(*code))
      result += bytes;
    else if (bytes == "\n")
      result += "\\n";
    else if (bytes == "\t")
      result += "\\t";
    else if (bytes == "\r")
      result += "\\r";
    else if (bytes.size() == 1)
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(bytes[0]));
    else
      result += fmt::format("\\u{{{:04x}}}", static_cast<std::uint32_t>(*code));
  });
  return result;
}

std::string file_stem(std::string_view text) {
  std::string stem;
  for (const char c : text) {
    const bool stays = is_plain(c) || c == '_' || (!stem.empty() && (c == '-' || c == '.'));
    stem += stays ? std::string(1, c) : fmt::format("~{:02x}", static_cast<unsigned char>(c));
  }
  return stem;
}

}  // namespace fricid
