// What may be called how: names of joints, links, robots, scenes, models and trajectories, and the
// lines of free text beside them. Names and texts come from files, so they are checked where they
// are read.
#pragma once

#include <string>
#include <string_view>

namespace fricid {

/// What bears a name, of 1 to 100 bytes. Letters are those of any script but where ASCII is said.
enum class Named {
  kJoint,  ///< letters, digits, space and _ - . ( ) / :, no space at the ends
  kLink,   ///< as a joint
  kRobot,  ///< as a joint
  kScene,  ///< of a folder: letters, digits, space and _ - . ( ), beginning with one of the first
           ///< two or _, not ending with a space or dot
  kModel,  ///< of files: letters of ASCII, digits and _ - ., not beginning with - or .; not
           ///< "oracle" or "simulator"
  kTrajectory  ///< of files: all that shows but / and \\, not beginning with - . or a space
};

/// @param place  "file" or "file:line" for the message
/// @throws UserError in one line that shows `name` escaped and says what is allowed
void require_name(Named kind, std::string_view name, std::string_view place);

/// As require_name, for what the program itself wrote: there the models "oracle" and "simulator"
/// stand for the truth.
void require_written_name(Named kind, std::string_view name, std::string_view place);

/// Free text for a reader, such as a label: valid UTF-8 of at most 1000 bytes in which every
/// character shows; empty is allowed.
/// @param key  what the text is, for the message
/// @throws UserError
void require_label(std::string_view label, std::string_view key, std::string_view place);

/// `text` as one line that shows: control characters, characters that turn the direction of writing
/// and bytes that are not UTF-8 as \n, \t, \r, \x1b or \u{202e}. What shows stays, also \ itself,
/// so applying it again changes nothing.
std::string printable(std::string_view text);

/// Name of a file without its extension, made of any text: letters, digits, _ - . stay, each other
/// byte and a leading - or . becomes ~ and two hexadecimal digits ("iiwa/joint_1":
/// "iiwa~2fjoint_1"). Different texts have different stems.
std::string file_stem(std::string_view text);

}  // namespace fricid
