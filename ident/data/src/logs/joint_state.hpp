// ROS 2 joint states (sensor_msgs/msg/JointState), as bags hold them: CDR, little-endian.
//
//     stamp.sec i32, stamp.nanosec u32, frame_id, name[], position[], velocity[], effort[]
//
// Columns are stamp [s, from the first message on], position.NAME, velocity.NAME and effort.NAME
// with the joints' names. Several publishers may share a topic, the arm and its gripper, or two
// halves of an arm.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
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

/// The columns that any of the messages has, in the order in which they appear.
class JointStateNames {
 public:
  void add(const JointState& state);
  std::vector<std::string> take() { return std::move(names_); }

 private:
  std::vector<std::string> names_, last_joints_;
  std::array<bool, 3> last_arrays_{};  // which of them the last message had
  std::set<std::string> known_;
};

/// The wanted columns of message after message; a joint or array that a message lacks is missing
/// there. Messages without any of the wanted joints are passed over; those of one stamp with
/// different joints are one row.
class JointStateTable {
 public:
  /// @param names  columns of the messages
  /// @throws UserError for a column that is not among them
  JointStateTable(const std::vector<std::string>& names, const std::vector<std::string>& wanted,
                  const std::string& file);
  void add(const JointState& state);
  /// @throws UserError when the joints never come together
  LogTable take();

 private:
  void put(const std::string& name, double value);
  bool joins(std::size_t row) const;
  void require_joints_together() const;

  std::string file_;
  std::map<std::string, std::vector<std::size_t>> places_;  // wanted columns of a name
  std::map<std::string, std::vector<std::size_t>> joints_;  // wanted columns of a joint
  LogTable table_;
  std::vector<double> row_;
  std::vector<std::int64_t> stamps_;  // [ns] of each row, from the first on
  std::int64_t first_sec_ = 0, first_nanosec_ = 0;
};

/// What a bag says that has no joint states, or has them on two topics and none is named.
UserError no_joint_states(const std::string& file, const std::string& topic);
UserError two_topics(const std::string& file, const std::string& one, const std::string& other);

}  // namespace fricid::data
