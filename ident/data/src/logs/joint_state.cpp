#include "joint_state.hpp"

#include <algorithm>
#include <limits>
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
  for (std::uint32_t i = 0; i < count; ++i) values.push_back(body.real());
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

std::vector<std::string> columns_of(const JointState& state) {
  std::vector<std::string> names{"stamp"};
  for (const auto& [kind, values] :
       {std::pair("position.", &state.position), std::pair("velocity.", &state.velocity),
        std::pair("effort.", &state.effort)})
    if (!values->empty())
      for (const std::string& joint : state.names) names.push_back(kind + joint);
  return names;
}

JointStateTable::JointStateTable(const std::vector<std::string>& names,
                                 const std::vector<std::string>& wanted, const std::string& file)
    : row_(wanted.size()) {
  for (std::size_t i = 0; i < wanted.size(); ++i)
    places_[names[find_column(names, wanted[i], file)]].push_back(i);
  table_.columns.resize(wanted.size());
}

void JointStateTable::put(const std::string& name, double value) {
  const auto found = places_.find(name);
  if (found == places_.end()) return;
  for (const std::size_t i : found->second) row_[i] = value;
}

void JointStateTable::add(const JointState& state) {
  if (first_) {
    first_sec_ = state.sec;
    first_nanosec_ = state.nanosec;
    first_ = false;
  }
  std::ranges::fill(row_, std::numeric_limits<double>::quiet_NaN());
  put("stamp", static_cast<double>(state.sec - first_sec_) +
                   1e-9 * static_cast<double>(state.nanosec - first_nanosec_));
  for (std::size_t j = 0; j < state.names.size(); ++j) {
    if (j < state.position.size()) put("position." + state.names[j], state.position[j]);
    if (j < state.velocity.size()) put("velocity." + state.names[j], state.velocity[j]);
    if (j < state.effort.size()) put("effort." + state.names[j], state.effort[j]);
  }
  for (std::size_t i = 0; i < row_.size(); ++i) table_.columns[i].push_back(row_[i]);
}

UserError no_joint_states(const std::string& file, const std::string& topic) {
  return UserError("{}: found no joint states{}{}", file, topic.empty() ? "" : " on ", topic);
}

UserError two_topics(const std::string& file, const std::string& one, const std::string& other) {
  return UserError("{}: joint states on {} and {}; allowed: one, or topic = \"...\"", file, one,
                   other);
}

}  // namespace fricid::data
