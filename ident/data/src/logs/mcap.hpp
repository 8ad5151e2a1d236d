// MCAP files with ROS 2 joint states (https://mcap.dev/spec, sensor_msgs/msg/JointState as CDR).
//
// A file is the magic, then records: opcode (1 byte), length (8), content; those of a chunk lie
// inside it. Read are channels (id, topic), schemas (id, name) and messages (channel id, times,
// data); of messages only joint states:
//
//     stamp.sec i32, stamp.nanosec u32, frame_id, name[], position[], velocity[], effort[]
//
// Columns are stamp [s, from the first message on], position.NAME, velocity.NAME and effort.NAME
// with the joints' names. Chunks must not be compressed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/log_reader.hpp"

namespace fricid::data {

/// Names in the first message. @throws UserError when there is none
std::vector<std::string> mcap_names(std::string_view bytes, const std::string& file,
                                    const LogStyle& style);

/// Messages in the order of the file; a joint or array that a message lacks is missing there.
/// @throws UserError naming the byte: no MCAP, torn, damaged, two topics and none named
LogTable parse_mcap(std::string_view bytes, const std::string& file,
                    const std::vector<std::string>& wanted, const LogStyle& style);

}  // namespace fricid::data
