#include "mcap.hpp"

#include <cstdint>
#include <functional>
#include <set>

#include "bytes.hpp"
#include "compression.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "joint_state.hpp"

namespace fricid::data {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr int kFooter = 0x02, kSchema = 0x03, kChannel = 0x04, kMessage = 0x05, kChunk = 0x06;

/// Walks a file and hands over the joint states of one topic.
class Walker {
 public:
  Walker(const std::string& file, const LogStyle& style,
         std::function<void(const JointState&)> visit)
      : file_(file), topic_(style.topic), visit_(std::move(visit)) {}

  void walk(std::string_view bytes) {
    if (!bytes.starts_with(kMagic)) throw UserError("{}: not an MCAP file", file_);
    require_chunks_within_limits(bytes.substr(kMagic.size()));
    walk_records(bytes.substr(kMagic.size()), true);
    if (!any_) throw no_joint_states(file_, topic_);
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
        if (content.text() == kJointStateType) schemas_.insert(id);
      } else if (opcode == kChannel) {
        add_channel(content);
      } else if (opcode == kMessage) {
        take_message(content);
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

  void take_message(Bytes& content) {
    if (!channels_.contains(content.number<std::uint16_t>())) return;
    if (!others_.empty() && !named_) throw two_topics(file_, topic_, *others_.begin());
    content.take(4 + 8 + 8);  // sequence, times
    const std::string_view data = content.take(content.size());
    any_ = true;
    visit_(parse_joint_state(data, file_));
  }

  const std::string& file_;
  std::string topic_;
  bool named_ = !topic_.empty(), any_ = false;
  std::function<void(const JointState&)> visit_;
  std::set<std::uint16_t> schemas_, channels_;
  std::set<std::string> others_;
};

}  // namespace

std::vector<std::string> mcap_names(std::string_view bytes, const std::string& file,
                                    const LogStyle& style) {
  JointStateNames names;
  Walker(file, style, [&](const JointState& state) { names.add(state); }).walk(bytes);
  return names.take();
}

LogTable parse_mcap(std::string_view bytes, const std::string& file,
                    const std::vector<std::string>& wanted, const LogStyle& style) {
  JointStateTable table(mcap_names(bytes, file, style), wanted, file);
  Walker(file, style, [&](const JointState& state) { table.add(state); }).walk(bytes);
  return table.take();
}

}  // namespace fricid::data
