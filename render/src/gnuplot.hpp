// Text, comments and files in gnuplot's syntax.
#pragma once

#include <filesystem>
#include <string_view>

#include "fricid/base/code.hpp"

namespace fricid::render::gnuplot {

using Script = Code<struct GnuplotLanguage>;

/// A string that gnuplot takes literally; unprintable characters are escaped.
Script string_of(std::string_view text);

/// The same for the name of a tic, which gnuplot takes for a format of numbers.
Script tic(std::string_view text);

/// One comment line with its line break.
Script comment(std::string_view text);

/// A file for `set output` and `load`: absolute, because a name that begins with | or < starts a
/// program.
Script file(const std::filesystem::path& path);

}  // namespace fricid::render::gnuplot
