#include "joint_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "bytes.hpp"
#include "columns.hpp"

namespace fricid::data {
namespace {

std::string cdr_text(Bytes& cdr) {
  cdr.align(4);
  std::string text = cdr.text();
  if (!text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

std::vector<double> cdr_numbers(Bytes& cdr) {
  cdr.align(4);
  const auto count = cdr.number<std::uint32_t>();
  std::vector<double> values;
  if (count == 0) return values;
  cdr.align(8);
  const std::string inside = "an array";
  Bytes body(cdr.take(std::uint64_t{8} * count), inside);
  for (std::uint32_t i = 0; i < count; ++i) values.push_back(body.number<double>());
  return values;
}

}  // namespace

JointState parse_joint_state(std::string_view data, const std::string& file) {
  Bytes header(data, file);
  const std::string_view encapsulation = header.take(4);
  if (encapsulation[0] != 0 || encapsulation[1] != 1)
    throw UserError("{}: message encoding {:02x}{:02x}; allowed: little-endian CDR", file,
                    static_cast<unsigned char>(encapsulation[0]),
                    static_cast<unsigned char>(encapsulation[1]));
  Bytes cdr(data.substr(4), file);
  JointState state;
  state.sec = cdr.number<std::int32_t>();
  state.nanosec = cdr.number<std::uint32_t>();
  cdr_text(cdr);  // frame_id
  cdr.align(4);
  const auto joints = cdr.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < joints; ++i) state.names.push_back(cdr_text(cdr));
  state.position = cdr_numbers(cdr);
  state.velocity = cdr_numbers(cdr);
  state.effort = cdr_numbers(cdr);
  return state;
}

void JointStateNames::add(const JointState& state) {
  const std::array<bool, 3> arrays{!state.position.empty(), !state.velocity.empty(),
                                   !state.effort.empty()};
  if (!names_.empty() && state.names == last_joints_ && arrays == last_arrays_) return;
  last_joints_ = state.names;
  last_arrays_ = arrays;
  const auto know = [&](const std::string& name) {
    if (known_.insert(name).second) names_.push_back(name);
  };
  know("stamp");
  constexpr std::array kArrays{"position.", "velocity.", "effort."};
  for (std::size_t i = 0; i < arrays.size(); ++i)
    if (arrays[i])
      for (const std::string& joint : state.names) know(kArrays[i] + joint);
}

JointStateTable::JointStateTable(const std::vector<std::string>& names,
                                 const std::vector<std::string>& wanted, const std::string& file)
    : file_(file), row_(wanted.size()) {
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const std::string& name = names[find_column(names, wanted[i], file)];
    places_[name].push_back(i);
    if (const std::size_t dot = name.find('.'); dot != std::string::npos)
      joints_[name.substr(dot + 1)].push_back(i);
  }
  table_.columns.resize(wanted.size());
}

void JointStateTable::put(const std::string& name, double value) {
  const auto found = places_.find(name);
  if (found == places_.end()) return;
  for (const std::size_t i : found->second) row_[i] = value;
}

void JointStateTable::add(const JointState& state) {
  if (std::ranges::none_of(state.names,
                           [&](const std::string& joint) { return joints_.contains(joint); }))
    return;
  if (stamps_.empty()) {
    first_sec_ = state.sec;
    first_nanosec_ = state.nanosec;
  }
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t seconds = state.sec - first_sec_, nanoseconds = state.nanosec - first_nanosec_;
  const std::int64_t stamp = kSecond * seconds + nanoseconds;
  std::ranges::fill(row_, std::numeric_limits<double>::quiet_NaN());
  put("stamp", static_cast<double>(seconds) + 1e-9 * static_cast<double>(nanoseconds));
  for (std::size_t j = 0; j < state.names.size(); ++j) {
    if (j < state.position.size()) put("position." + state.names[j], state.position[j]);
    if (j < state.velocity.size()) put("velocity." + state.names[j], state.velocity[j]);
    if (j < state.effort.size()) put("effort." + state.names[j], state.effort[j]);
  }
  constexpr std::size_t kBack = 8;  // rows: the other part of an arm comes soon
  for (std::size_t row = stamps_.size(); row > 0 && row + kBack > stamps_.size(); --row)
    if (stamps_[row - 1] == stamp && joins(row - 1)) {
      for (std::size_t i = 0; i < row_.size(); ++i)
        if (!std::isnan(row_[i])) table_.columns[i][row - 1] = row_[i];
      return;
    }
  stamps_.push_back(stamp);
  for (std::size_t i = 0; i < row_.size(); ++i) table_.columns[i].push_back(row_[i]);
}

// Whether a message of the same stamp says nothing that a row has already.
bool JointStateTable::joins(std::size_t row) const {
  return std::ranges::all_of(joints_, [&](const auto& joint) {
    return std::ranges::all_of(joint.second, [&](std::size_t i) {
      return std::isnan(row_[i]) || std::isnan(table_.columns[i][row]);
    });
  });
}

void JointStateTable::require_joints_together() const {
  const auto has = [&](const auto& joint, std::size_t row) {
    return std::ranges::any_of(joint.second,
                               [&](std::size_t i) { return !std::isnan(table_.columns[i][row]); });
  };
  std::set<std::string> seen;
  std::vector<std::string> some, others;  // of the first row
  for (std::size_t row = 0; row < stamps_.size(); ++row) {
    std::vector<std::string> present, absent;
    for (const auto& joint : joints_) (has(joint, row) ? present : absent).push_back(joint.first);
    if (absent.empty()) return;
    if (present.empty()) continue;
    if (seen.empty()) std::tie(some, others) = std::pair(present, absent);
    seen.insert(present.begin(), present.end());
  }
  if (seen.size() < joints_.size()) return;  // a joint without any value is another fault
  throw UserError(
      "{}: {} and {} come in messages of different stamps; allowed: the joints of the contract in "
      "one message, or in messages of one stamp",
      file_, fmt::join(some, " "), fmt::join(others, " "));
}

LogTable JointStateTable::take() {
  require_joints_together();
  return std::move(table_);
}

UserError no_joint_states(const std::string& file, const std::string& topic) {
  return UserError("{}: found no joint states{}{}", file, topic.empty() ? "" : " on ", topic);
}

UserError two_topics(const std::string& file, const std::string& one, const std::string& other) {
  return UserError("{}: joint states on {} and {}; allowed: one, or topic = \"...\"", file, one,
                   other);
}

}  // namespace fricid::data
