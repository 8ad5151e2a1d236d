// Texts of files in C source.
#pragma once

#include <string>
#include <string_view>

namespace fricid::deploy {

/// A one-line comment; the text is escaped so that it cannot end it.
std::string c_comment(std::string_view text);

/// A string literal of the text's bytes, with octal escapes for all but printable ASCII.
std::string c_string(std::string_view text);

}  // namespace fricid::deploy
