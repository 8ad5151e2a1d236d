// Letters that plots can show.
#pragma once

#include <string>
#include <string_view>

namespace fricid::render {

/// UTF-8 with □ in the place of letters of which this machine has no font (fc-list). In a plot
/// Pango would draw their numbers instead, as large as the plot.
std::string with_known_letters(std::string_view text);

/// UTF-8 of at most so many letters: its beginning, an ellipsis and its end.
std::string shortened(std::string_view text, std::size_t most);

}  // namespace fricid::render
