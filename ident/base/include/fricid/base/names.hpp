// Rules for names of joints, links, robots, scenes, models and trajectories, and for free text.
// They come from files, so the readers check them.
#pragma once

#include <string>
#include <string_view>

namespace fricid {

/// Kinds of names, with the characters that each may contain. A name has 1 to 100 bytes. Letters of
/// any script are allowed unless ASCII is stated.
enum class Named {
  kJoint,  ///< letters, digits, space and _ - . ( ) / :, no space at the ends
  kLink,   ///< as a joint
  kRobot,  ///< as a joint
  kScene,  ///< names a folder: letters, digits, space and _ - . ( ), beginning with a letter, digit
           ///< or _, not ending with a space or dot
  kModel,  ///< names files: ASCII letters, digits and _ - ., not beginning with - or .; not
           ///< "oracle" or "simulator"
  kTrajectory  ///< names files: visible characters but / and \\, not beginning with - . or a space
};

/// @param place  "file" or "file:line" for the message
/// @throws UserError in one line that shows `name` escaped and says what is allowed
void require_name(Named kind, std::string_view name, std::string_view place);

/// As require_name, for files written by the program itself: they may name the models "oracle" and
/// "simulator", which stand for the truth.
void require_written_name(Named kind, std::string_view name, std::string_view place);

/// Checks free text, such as a label: valid UTF-8 of at most 1000 bytes, visible characters only;
/// may be empty.
/// @param key  what the text is, for the message
/// @throws UserError
void require_label(std::string_view label, std::string_view key, std::string_view place);

/// `text` as one line of visible characters: control characters, characters that change the writing
/// direction and bytes that are not UTF-8 are written as \n, \t, \r, \x1b or \u{202e}. Visible
/// characters stay, also \ itself, so applying the function twice equals applying it once.
std::string printable(std::string_view text);

/// File name without extension for any text: letters, digits, _ - . stay; any other byte, and a
/// leading - or ., becomes ~ and two hexadecimal digits ("iiwa/joint_1" -> "iiwa~2fjoint_1").
/// Different texts give different names.
std::string file_stem(std::string_view text);

}  // namespace fricid
