// ROS 2 joint states (sensor_msgs/msg/JointState), as bags hold them: CDR, little-endian.
//
//     stamp.sec i32, stamp.nanosec u32, frame_id, name[], position[], velocity[], effort[]
//
// Columns are stamp [s, from the first message on], position.NAME, velocity.NAME and effort.NAME
// with the joints' names.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/data/log_reader.hpp"

namespace fricid::data {

inline constexpr std::string_view kJointStateType = "sensor_msgs/msg/JointState";

struct JointState {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::vector<std::string> names;
  std::vector<double> position, velocity, effort;  ///< each of the joints' number, or empty
};

/// @param data  with the four bytes that say how it is encoded
/// @throws UserError when it is torn or of another encoding
JointState parse_joint_state(std::string_view data, const std::string& file);

std::vector<std::string> columns_of(const JointState& state);

/// The wanted columns of message after message; a joint or array that a message lacks is missing
/// there.
class JointStateTable {
 public:
  /// @param names  columns of the first message
  /// @throws UserError for a column that is not among them
  JointStateTable(const std::vector<std::string>& names, const std::vector<std::string>& wanted,
                  const std::string& file);
  void add(const JointState& state);
  LogTable take() { return std::move(table_); }

 private:
  void put(const std::string& name, double value);

  std::map<std::string, std::vector<std::size_t>> places_;  // wanted columns of a name
  LogTable table_;
  std::vector<double> row_;
  bool first_ = true;
  std::int64_t first_sec_ = 0, first_nanosec_ = 0;
};

/// What a bag says that has no joint states, or has them on two topics and none is named.
UserError no_joint_states(const std::string& file, const std::string& topic);
UserError two_topics(const std::string& file, const std::string& one, const std::string& other);

}  // namespace fricid::data
