// ROS 2 bags of the storage "sqlite3" (NAME.db3): an SQLite database with the tables
//
//     topics    id, name, type, serialization_format, ...
//     messages  id, topic_id, timestamp, data
//
// of which only joint states are read (`joint_state.hpp`). The file may come from anyone: it is
// opened for reading alone, and nothing but two plain tables of it is looked at.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fricid/data/log_reader.hpp"

namespace fricid::data {

/// Names in any of the messages. @throws UserError when there is none
std::vector<std::string> bag_names(const std::filesystem::path& path, const LogStyle& style);

/// Rows as `JointStateTable` makes them of messages in the order in which they were recorded.
/// @throws UserError for a database that is no bag, torn or damaged, for two topics and none named,
///         and for messages that still lie in a journal beside the file
LogTable read_bag(const std::filesystem::path& path, const std::vector<std::string>& wanted,
                  const LogStyle& style);

}  // namespace fricid::data
