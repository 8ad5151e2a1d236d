// SVG pictures of gnuplot as parts of a page.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "html.hpp"

namespace fricid::render {

/// A picture that is_plain_svg.
using Svg = Code<struct SvgLanguage>;

/// Whether a file holds only elements that gnuplot writes: no scripts, event handlers or external
/// links. Files of a run folder are not trusted; only plain pictures become part of a page.
bool is_plain_svg(std::string_view file);

/// @throws UserError naming `place` where `file` is not plain
Svg plain_svg(std::string file, const std::string& place);
Svg read_svg(const std::filesystem::path& path);

/// The picture as an <svg> element that follows the page: black becomes the colour of the text,
/// fonts are the page's, grid lines have class "gridline". Coordinates are rounded to 0.1 px and
/// written as differences, which halves the size; symbols are left to `svg_symbols`.
/// @param label  accessible description of the picture
Html inline_svg(const Svg& picture, std::string_view label);

/// The symbols that inlined pictures share: once per page.
Html svg_symbols(const Svg& picture);

/// `d` of a path, from absolute M and L commands to relative ones in steps of 0.1 px.
std::string relative_path(const std::string& d);

}  // namespace fricid::render
