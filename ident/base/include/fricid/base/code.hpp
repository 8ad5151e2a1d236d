// Text in the syntax of another language, as a type: a string from a file can only enter it through
// that language's quoting function.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace fricid {

/// Text that is already quoted. Only quoting functions make one.
struct Vouched {
  std::string text;
};

/// A piece of gnuplot script, XML, Markdown ...
/// @tparam Language  an empty tag
template <class Language>
class Code {
 private:
  template <class Arg>
  using Part = std::conditional_t<std::is_arithmetic_v<Arg>, Arg, std::string_view>;
  template <class Arg>
  using Enters = std::disjunction<std::is_arithmetic<Arg>, std::is_same<Arg, Code>>;

 public:
  Code() = default;
  /// Called by quoting functions only.
  explicit Code(Vouched quoted) : text_(std::move(quoted.text)) {}

  /// A literal with numbers and pieces of the same language as arguments; other types do not
  /// compile.
  template <class... Args>
  requires std::conjunction_v<Enters<Args>...>
  static Code of(fmt::format_string<Part<Args>...> format, const Args&... args) {
    return Code(Vouched{fmt::format(format, Part<Args>(part_of(args))...)});
  }

  Code& operator+=(const Code& other) {
    text_ += other.text_;
    return *this;
  }
  friend Code operator+(Code left, const Code& right) { return left += right; }

  bool empty() const { return text_.empty(); }
  const std::string& text() const { return text_; }

 private:
  static std::string_view part_of(const Code& code) { return code.text_; }
  template <class Number>
  requires std::is_arithmetic_v<Number>
  static Number part_of(Number number) { return number; }

  std::string text_;
};

}  // namespace fricid
