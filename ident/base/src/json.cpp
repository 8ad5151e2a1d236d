#include "fricid/base/json.hpp"

#include <fmt/format.h>

#include <cctype>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/lines.hpp"
#include "fricid/base/names.hpp"

namespace fricid {
namespace {

/// "[json.exception.parse_error.101] parse error at ...: ... - unexpected end of input; expected
/// ']'" -> "unexpected end of input"
std::string_view reason(std::string_view what) {
  for (const std::string_view before : {std::string_view("] "), std::string_view(" - ")})
    if (const std::size_t at = what.find(before); at != std::string_view::npos)
      what.remove_prefix(at + before.size());
  return what.substr(0, what.find("; "));
}

/// The word of a text that a place is in, e.g. NaN, which JSON does not have.
std::string_view word_at(std::string_view text, std::size_t at) {
  constexpr std::size_t kMost = 20;
  const auto in_word = [&](std::size_t i) {
    return i < text.size() && std::isalpha(static_cast<unsigned char>(text[i]));
  };
  std::size_t begin = at, end = at;
  while (begin > 0 && in_word(begin - 1) && at - begin < kMost) --begin;
  while (in_word(end) && end - begin < kMost) ++end;
  return text.substr(begin, end - begin);
}

}  // namespace

template <class Json>
Json parse_json(std::string_view text, const std::string& where) {
  using Event = typename Json::parse_event_t;
  try {
    return Json::parse(text, [&](int depth, Event event, Json&) {
      if (event == Event::array_start || event == Event::object_start)
        require_within(limits::kJsonLevels, static_cast<std::uint64_t>(depth) + 1, where);
      return true;
    });
  } catch (const typename Json::parse_error& error) {
    const std::size_t at = error.byte > 0 ? error.byte - 1 : 0;
    const std::string_view what = reason(error.what());
    throw UserError("{}:{}: not JSON, or torn: {}{}", where, line_at(text, at), what,
                    what == "invalid literal" ? fmt::format(" {}", word_at(text, at)) : "");
  } catch (const typename Json::exception& error) {
    throw UserError("{}: not JSON: {}", where, reason(error.what()));
  }
}

template <class Json>
std::string shown(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "a list";
  const std::string text = printable(value.dump(-1, ' ', false, Json::error_handler_t::replace));
  return text.size() > 60 ? printable(std::string_view(text).substr(0, 57)) + "..." : text;
}

template nlohmann::json parse_json(std::string_view, const std::string&);
template nlohmann::ordered_json parse_json(std::string_view, const std::string&);
template std::string shown(const nlohmann::json&);
template std::string shown(const nlohmann::ordered_json&);

}  // namespace fricid
