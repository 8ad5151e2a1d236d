#include "kuka_trace.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>

#include "columns.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/recording_file.hpp"

namespace fricid::data {
namespace {

namespace fs = std::filesystem;

constexpr int kMostChannels = 4096;

double number_at(std::string_view text, const std::string& where) {
  double value = 0;
  if (!parse_number(trimmed(text), true, value) || !(std::abs(value) < 1e300))
    throw UserError("{}: {}; allowed: a number", where, in_quotes(text));
  return value;
}

void read_key(TraceChannel& channel, int key, std::string_view value, const std::string& where) {
  switch (key) {
    case 200:
      channel.name = as_utf8(trimmed(value));
      break;
    case 210:
      channel.implicit = trimmed(value).starts_with("IMPL");
      break;
    case 220:
      channel.samples = static_cast<long long>(std::clamp(number_at(value, where), 0.0, 1e12));
      break;
    case 221:
      channel.column = static_cast<int>(std::clamp(number_at(value, where), 0.0, 1e6)) - 1;
      break;
    case 240:
      channel.offset = number_at(value, where);
      break;
    case 241:
      channel.factor = number_at(value, where);
      break;
    default:
      break;  // comments, units, dates
  }
}

/// A header with its numbers.
struct Part {
  std::vector<TraceChannel> channels;
  std::string suffix;  // number of the drive
  fs::path data;
};

fs::path data_of(fs::path header) {
  for (const char* extension : {".r64", ".R64"}) {
    header.replace_extension(extension);
    if (fs::exists(header)) return header;
  }
  throw UserError("{}: missing; it holds the numbers of the header",
                  header.replace_extension(".r64").string());
}

// The file, or the files of all drives that belong to it.
std::vector<Part> parts_of(const fs::path& path) {
  std::vector<Part> parts;
  const auto add = [&](const fs::path& file, const std::string& suffix) {
    parts.push_back({parse_trace_header(read_file(file), file.string()), suffix, data_of(file)});
  };
  const std::string stem = path.stem().string();
  const std::size_t mark = stem.rfind('#');
  const bool drives = mark != std::string::npos && mark + 2 == stem.size() && stem.back() >= '1' &&
                      stem.back() <= '9';
  if (!drives) {
    add(path, "");
    return parts;
  }
  for (char drive = '1'; drive <= '9'; ++drive) {
    fs::path file = path;
    file.replace_filename(stem.substr(0, mark + 1) + drive + path.extension().string());
    if (fs::exists(file)) add(file, std::string(1, drive));
  }
  return parts;
}

// Names of a part's channels as columns of the log. The time belongs to all drives.
std::string column_name(const Part& part, const TraceChannel& channel) {
  return channel.implicit ? channel.name : channel.name + part.suffix;
}

std::vector<std::string> names_of(const std::vector<Part>& parts) {
  std::vector<std::string> names;
  for (const Part& part : parts)
    for (const TraceChannel& channel : part.channels) {
      const std::string name = column_name(part, channel);
      if (channel.implicit && std::find(names.begin(), names.end(), name) != names.end()) continue;
      names.push_back(name);
    }
  return names;
}

}  // namespace

std::vector<TraceChannel> parse_trace_header(std::string_view text, const std::string& file) {
  std::vector<TraceChannel> channels;
  int explicit_channels = 0;
  bool inside = false, seen = false;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string where = fmt::format("{}:{}", file, number);
    seen = seen || line.starts_with("DIAEXTENDED") || line.starts_with("#BEGINGLOBALHEADER");
    if (line.starts_with("#BEGINCHANNELHEADER")) {
      if (inside) throw UserError("{}: a channel within a channel: torn", where);
      if (channels.size() == kMostChannels)
        throw UserError("{}: more than {} channels", where, kMostChannels);
      inside = true;
      channels.emplace_back();
      channels.back().column = -1;
    } else if (line.starts_with("#ENDCHANNELHEADER") && inside) {
      inside = false;
      TraceChannel& channel = channels.back();
      if (!channel.implicit && channel.column < 0) channel.column = explicit_channels;
      if (!channel.implicit) ++explicit_channels;
    } else if (inside && line.size() > 4) {
      int key = 0;
      const auto [rest, error] = std::from_chars(line.data(), line.data() + 3, key);
      if (error == std::errc() && rest == line.data() + 3)
        read_key(channels.back(), key, line.substr(4), where);
    }
  }
  if (!seen || channels.empty() || inside || explicit_channels == 0)
    throw UserError("{}: not the header of a KUKA trace, or torn", file);
  for (const TraceChannel& channel : channels)
    if (!channel.implicit && channel.column >= explicit_channels)
      throw UserError("{}: channel {} is column {} of {}", file, in_quotes(channel.name),
                      channel.column + 1, explicit_channels);
  return channels;
}

std::vector<double> trace_values(const TraceChannel& channel,
                                 const std::vector<TraceChannel>& channels, std::string_view raw) {
  const auto width = static_cast<std::size_t>(
      std::count_if(channels.begin(), channels.end(), [](const auto& c) { return !c.implicit; }));
  std::size_t rows = raw.size() / (8 * width);
  for (const TraceChannel& c : channels)
    if (c.samples >= 0) rows = std::min(rows, static_cast<std::size_t>(c.samples));
  std::vector<double> values(rows);
  for (std::size_t k = 0; k < rows; ++k) {
    if (channel.implicit) {
      values[k] = channel.offset + static_cast<double>(k) * channel.factor;
      continue;
    }
    const char* bytes = raw.data() + 8 * (k * width + static_cast<std::size_t>(channel.column));
    std::uint64_t bits = 0;
    for (int b = 7; b >= 0; --b) bits = bits << 8 | static_cast<unsigned char>(bytes[b]);
    values[k] = channel.offset + std::bit_cast<double>(bits) * channel.factor;
  }
  return values;
}

std::vector<std::string> trace_names(const fs::path& path) { return names_of(parts_of(path)); }

LogTable read_trace(const fs::path& path, const std::vector<std::string>& wanted) {
  const std::vector<Part> parts = parts_of(path);
  const std::vector<std::string> names = names_of(parts);
  LogTable table;
  table.columns.resize(wanted.size());
  std::optional<std::size_t> rows;
  for (const Part& part : parts) {
    const std::string raw = read_recording(part.data);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const std::string& name = names[find_column(names, wanted[i], path.string())];
      for (const TraceChannel& channel : part.channels) {
        if (column_name(part, channel) != name || !table.columns[i].empty()) continue;
        table.columns[i] = trace_values(channel, part.channels, raw);
        if (!rows) rows = table.columns[i].size();
        if (*rows != table.columns[i].size())
          throw UserError("{}: {} has {} samples; allowed: {}, as the others", part.data.string(),
                          name, table.columns[i].size(), *rows);
      }
    }
  }
  return table;
}

}  // namespace fricid::data
