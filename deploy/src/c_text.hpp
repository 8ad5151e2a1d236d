// Texts of files in C source.
#pragma once

#include <string>
#include <string_view>

namespace fricid::deploy {

/// A comment of one line that nothing in the text can end.
std::string c_comment(std::string_view text);

/// A string literal with every byte as it is: what is not a plain character of ASCII in octal.
std::string c_string(std::string_view text);

}  // namespace fricid::deploy
