// MCAP files with ROS 2 joint states (https://mcap.dev/spec, `joint_state.hpp`).
//
// A file is the magic, then records: opcode (1 byte), length (8), content; those of a chunk lie
// inside it. Read are channels (id, topic), schemas (id, name) and messages (channel id, times,
// data); of messages only joint states. Chunks may be compressed (`compression.hpp`).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/log_reader.hpp"

namespace fricid::data {

/// Names in any of the messages. @throws UserError when there is none
std::vector<std::string> mcap_names(std::string_view bytes, const std::string& file,
                                    const LogStyle& style);

/// Rows as `JointStateTable` makes them of messages in the order of the file.
/// @throws UserError naming the byte: no MCAP, torn, damaged, two topics and none named
LogTable parse_mcap(std::string_view bytes, const std::string& file,
                    const std::vector<std::string>& wanted, const LogStyle& style);

}  // namespace fricid::data
