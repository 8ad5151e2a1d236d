#include "mcap.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include "columns.hpp"
#include "compression.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"

namespace fricid::data {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr int kFooter = 0x02, kSchema = 0x03, kChannel = 0x04, kMessage = 0x05, kChunk = 0x06;

/// Little-endian values from a stretch of bytes; the end of the file is the user's trouble.
class Bytes {
 public:
  Bytes(std::string_view bytes, const std::string& file) : rest_(bytes), file_(file) {}

  bool empty() const { return rest_.empty(); }
  std::size_t size() const { return rest_.size(); }
  std::string_view take(std::uint64_t size) {
    if (size > rest_.size())
      throw UserError("{}: torn: {} bytes are missing", file_, size - rest_.size());
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(size));
    rest_.remove_prefix(static_cast<std::size_t>(size));
    used_ += taken.size();
    return taken;
  }
  template <class T>
  T number() {
    std::uint64_t bits = 0;
    const std::string_view bytes = take(sizeof(T));
    for (std::size_t i = sizeof(T); i-- > 0;)
      bits = bits << 8 | static_cast<unsigned char>(bytes[i]);
    return static_cast<T>(bits);
  }
  double real() { return std::bit_cast<double>(number<std::uint64_t>()); }
  std::string text() { return std::string(take(number<std::uint32_t>())); }
  /// CDR: values lie at multiples of their size, counted from behind the four bytes of its header.
  void align(std::size_t size) {
    if (const std::size_t over = used_ % size; over != 0) take(size - over);
  }

 private:
  std::string_view rest_;
  const std::string& file_;
  std::size_t used_ = 0;
};

/// sensor_msgs/msg/JointState
struct JointState {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::vector<std::string> names;
  std::vector<double> position, velocity, effort;
};

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

/// Walks a file and hands over the joint states of one topic. `visit` returns false to stop.
class Walker {
 public:
  Walker(const std::string& file, const LogStyle& style,
         std::function<bool(const JointState&)> visit)
      : file_(file), topic_(style.topic), visit_(std::move(visit)) {}

  void walk(std::string_view bytes) {
    if (!bytes.starts_with(kMagic)) throw UserError("{}: not an MCAP file", file_);
    require_chunks_within_limits(bytes.substr(kMagic.size()));
    walk_records(bytes.substr(kMagic.size()), true);
    if (!any_)
      throw UserError("{}: found no joint states{}{}", file_, topic_.empty() ? "" : " on ", topic_);
  }

 private:
  // What the chunks say they hold, before any is expanded.
  void require_chunks_within_limits(std::string_view records) const {
    Bytes rest(records, file_);
    std::uint64_t all = 0;
    while (!rest.empty()) {
      const auto opcode = rest.number<std::uint8_t>();
      Bytes content(rest.take(rest.number<std::uint64_t>()), file_);
      if (opcode == kFooter) return;
      if (opcode != kChunk) continue;
      content.take(8 + 8);  // times
      const auto size = content.number<std::uint64_t>();
      require_within(limits::kChunkBytes, size, file_);
      require_within(limits::kMcapBytes, all += size, file_);
    }
  }

  // False to stop. Chunks hold records, but no chunks.
  bool walk_records(std::string_view records, bool may_hold_chunks) {
    Bytes rest(records, file_);
    while (!rest.empty()) {
      const auto opcode = rest.number<std::uint8_t>();
      Bytes content(rest.take(rest.number<std::uint64_t>()), file_);
      if (opcode == kFooter) return false;
      if (opcode == kSchema) {
        const auto id = content.number<std::uint16_t>();
        if (content.text() == "sensor_msgs/msg/JointState") schemas_.insert(id);
      } else if (opcode == kChannel) {
        add_channel(content);
      } else if (opcode == kMessage) {
        if (!take_message(content)) return false;
      } else if (opcode == kChunk && may_hold_chunks) {
        if (!walk_chunk(content)) return false;
      }
    }
    return true;
  }

  bool walk_chunk(Bytes& content) {
    content.take(8 + 8);  // times
    const auto size = content.number<std::uint64_t>();
    content.take(4);  // checksum
    const std::string compression = content.text();
    const std::string_view stored = content.take(content.number<std::uint64_t>());
    if (compression.empty()) return walk_records(stored, false);
    return walk_records(decompressed(stored, size, compression, file_), false);
  }

  void add_channel(Bytes& content) {
    const auto id = content.number<std::uint16_t>();
    const auto schema = content.number<std::uint16_t>();
    const std::string topic = content.text();
    if (!schemas_.contains(schema)) return;
    if (topic_.empty()) topic_ = topic;
    if (topic == topic_) {
      channels_.insert(id);
    } else if (!named_) {
      others_.insert(topic);
    }
  }

  bool take_message(Bytes& content) {
    if (!channels_.contains(content.number<std::uint16_t>())) return true;
    if (!others_.empty() && !named_)
      throw UserError("{}: joint states on {} and {}; allowed: one, or topic = \"...\"", file_,
                      topic_, *others_.begin());
    content.take(4 + 8 + 8);  // sequence, times
    const std::string_view data = content.take(content.size());
    any_ = true;
    return visit_(parse_joint_state(data, file_));
  }

  const std::string& file_;
  std::string topic_;
  bool named_ = !topic_.empty(), any_ = false;
  std::function<bool(const JointState&)> visit_;
  std::set<std::uint16_t> schemas_, channels_;
  std::set<std::string> others_;
};

}  // namespace

std::vector<std::string> mcap_names(std::string_view bytes, const std::string& file,
                                    const LogStyle& style) {
  std::vector<std::string> names{"stamp"};
  Walker(file, style, [&](const JointState& state) {
    for (const auto& [kind, values] :
         {std::pair("position.", &state.position), std::pair("velocity.", &state.velocity),
          std::pair("effort.", &state.effort)})
      if (!values->empty())
        for (const std::string& joint : state.names) names.push_back(kind + joint);
    return false;
  }).walk(bytes);
  return names;
}

LogTable parse_mcap(std::string_view bytes, const std::string& file,
                    const std::vector<std::string>& wanted, const LogStyle& style) {
  const std::vector<std::string> names = mcap_names(bytes, file, style);
  std::map<std::string, std::vector<std::size_t>> places;  // wanted columns of a name
  for (std::size_t i = 0; i < wanted.size(); ++i)
    places[names[find_column(names, wanted[i], file)]].push_back(i);

  LogTable table;
  table.columns.resize(wanted.size());
  std::int64_t first_sec = 0, first_nanosec = 0;
  std::vector<double> row(wanted.size());
  bool first = true;
  Walker(file, style, [&](const JointState& state) {
    if (first) {
      first_sec = state.sec;
      first_nanosec = state.nanosec;
      first = false;
    }
    std::fill(row.begin(), row.end(), std::numeric_limits<double>::quiet_NaN());
    const auto put = [&](const std::string& name, double value) {
      const auto found = places.find(name);
      if (found == places.end()) return;
      for (const std::size_t i : found->second) row[i] = value;
    };
    put("stamp", static_cast<double>(state.sec - first_sec) +
                     1e-9 * static_cast<double>(state.nanosec - first_nanosec));
    for (std::size_t j = 0; j < state.names.size(); ++j) {
      if (j < state.position.size()) put("position." + state.names[j], state.position[j]);
      if (j < state.velocity.size()) put("velocity." + state.names[j], state.velocity[j]);
      if (j < state.effort.size()) put("effort." + state.names[j], state.effort[j]);
    }
    for (std::size_t i = 0; i < row.size(); ++i) table.columns[i].push_back(row[i]);
    return true;
  }).walk(bytes);
  return table;
}

}  // namespace fricid::data
