// SVG pictures of gnuplot as parts of a page.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace fricid::render {

/// Whether a file holds only what gnuplot draws: no scripts, no handlers of events, no links to
/// elsewhere. Anything may lie in a run folder; only this may become part of a page.
bool is_plain_svg(std::string_view file);

/// A file that is_plain_svg. @throws UserError naming any other
std::string read_svg(const std::filesystem::path& path);

/// The picture as an <svg> element that follows the page: black becomes the colour of the text,
/// fonts are the page's, grid lines have class "gridline". Coordinates are rounded to 0.1 px and
/// written as differences, which halves the size; symbols are left to `svg_symbols`.
/// @pre is_plain_svg(file)
/// @param label  what the picture shows, for those who do not see it (HTML-escaped here)
std::string inline_svg(const std::string& file, const std::string& label);

/// The symbols that inlined pictures share: once per page.
/// @param file  any picture that gnuplot made
std::string svg_symbols(const std::string& file);

/// `d` of a path, from absolute M and L commands to relative ones in steps of 0.1 px.
std::string relative_path(const std::string& d);

}  // namespace fricid::render
