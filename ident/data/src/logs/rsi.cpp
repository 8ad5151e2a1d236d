#include "rsi.hpp"

#include <algorithm>
#include <limits>

#include "columns.hpp"
#include "fricid/base/error.hpp"

namespace fricid::data {
namespace {

// The next whole packet of the text from `at` on; empty at the end. Moves `at` behind it.
std::string_view next_packet(std::string_view text, std::size_t& at) {
  constexpr std::string_view kOpen = "<Rob", kClose = "</Rob>";
  const std::size_t begin = text.find(kOpen, at);
  if (begin == std::string_view::npos) return {};
  const std::size_t close = text.find(kClose, begin);
  if (close == std::string_view::npos) return {};
  at = close + kClose.size();
  return text.substr(begin, at - begin);
}

bool is_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '.' || c == '-';
}

std::string_view take_name(std::string_view& rest) {
  std::size_t size = 0;
  while (size < rest.size() && is_name(rest[size])) ++size;
  const std::string_view name = rest.substr(0, size);
  rest.remove_prefix(size);
  return name;
}

// Calls visit(tag, attribute, value) for every attribute and, with an empty attribute, for the text
// of every tag that has one.
template <class Visit>
void for_each_value(std::string_view packet, const Visit& visit) {
  while (true) {
    const std::size_t open = packet.find('<');
    if (open == std::string_view::npos) return;
    packet.remove_prefix(open + 1);
    if (packet.starts_with('/')) continue;
    const std::string_view tag = take_name(packet);
    while (!packet.empty() && packet.front() != '>' && packet.front() != '<') {
      const std::string_view attribute = take_name(packet);
      if (attribute.empty() || !packet.starts_with("=\"")) {
        if (attribute.empty()) packet.remove_prefix(1);
        continue;
      }
      packet.remove_prefix(2);
      const std::size_t end = packet.find('"');
      if (end == std::string_view::npos) return;
      visit(tag, attribute, packet.substr(0, end));
      packet.remove_prefix(end + 1);
    }
    if (!packet.starts_with('>')) continue;
    packet.remove_prefix(1);
    const std::string_view text =
        trimmed(packet.substr(0, std::min(packet.find('<'), packet.size())));
    if (!text.empty()) visit(tag, std::string_view(), text);
  }
}

std::string column_name(std::string_view tag, std::string_view attribute) {
  std::string name(tag);
  if (!attribute.empty()) name.append(".").append(attribute);
  return name;
}

// Where the values of a packet go. Packets of one log are alike: each value is expected where it
// was in the packet before, and looked up by name only when it is not.
class Slots {
 public:
  explicit Slots(const std::vector<std::string>& wanted) {
    for (const std::string& name : wanted) wanted_.push_back(lower_case(name));
  }
  void begin() { next_ = 0; }
  /// Index among the wanted columns, or -1.
  int find(std::string_view tag, std::string_view attribute) {
    if (next_ == slots_.size()) slots_.emplace_back();
    Slot& slot = slots_[next_++];
    if (slot.tag != tag || slot.attribute != attribute) {
      slot = {std::string(tag), std::string(attribute), -1};
      const auto found =
          std::find(wanted_.begin(), wanted_.end(), lower_case(column_name(tag, attribute)));
      if (found != wanted_.end()) slot.column = static_cast<int>(found - wanted_.begin());
    }
    return slot.column;
  }

 private:
  struct Slot {
    std::string tag, attribute;
    int column = -1;
  };
  std::vector<std::string> wanted_;
  std::vector<Slot> slots_;
  std::size_t next_ = 0;
};

}  // namespace

std::vector<std::string> rsi_names(std::string_view text, const std::string& file) {
  std::size_t at = 0;
  const std::string_view packet = next_packet(text, at);
  if (packet.empty()) throw UserError("{}: found no packet <Rob>...</Rob>", file);
  std::vector<std::string> names;
  for_each_value(packet, [&](std::string_view tag, std::string_view attribute, std::string_view) {
    names.push_back(column_name(tag, attribute));
  });
  return names;
}

LogTable parse_rsi(std::string_view text, const std::string& file,
                   const std::vector<std::string>& wanted) {
  const std::vector<std::string> names = rsi_names(text, file);
  for (const std::string& name : wanted) find_column(names, name, file);

  LogTable table;
  table.columns.resize(wanted.size());
  Slots slots(wanted);
  std::vector<double> row(wanted.size());
  std::size_t at = 0, counted = 0;
  int line = 1;
  while (true) {
    const std::string_view packet = next_packet(text, at);
    if (packet.empty()) break;
    const std::size_t begin = at - packet.size();
    line += static_cast<int>(std::count(text.begin() + static_cast<std::ptrdiff_t>(counted),
                                        text.begin() + static_cast<std::ptrdiff_t>(begin), '\n'));
    counted = begin;
    std::fill(row.begin(), row.end(), std::numeric_limits<double>::quiet_NaN());
    slots.begin();
    for_each_value(
        packet, [&](std::string_view tag, std::string_view attribute, std::string_view value) {
          const int column = slots.find(tag, attribute);
          if (column < 0) return;
          if (!parse_number(trimmed(value), false, row[static_cast<std::size_t>(column)]))
            throw UserError("{}:{}: {} = {}; allowed: a number", file, line,
                            column_name(tag, attribute), in_quotes(value));
        });
    for (std::size_t i = 0; i < row.size(); ++i) table.columns[i].push_back(row[i]);
    table.lines.push_back(line);
  }
  return table;
}

}  // namespace fricid::data
