// libFuzzer target: every reader of logs that works on bytes. The first byte chooses the reader;
// what follows is the file. A reader gives a table or a UserError, and nothing else.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "fricid/base/error.hpp"
#include "logs/csv.hpp"
#include "logs/kuka_trace.hpp"
#include "logs/mat.hpp"
#include "logs/mcap.hpp"
#include "logs/rsi.hpp"

namespace {

using namespace fricid::data;

// Reads the columns that the file itself names.
void read(std::uint8_t format, std::string_view bytes) {
  const std::string file = "fuzz";
  switch (format % 6) {
    case 0:
    case 1: {
      const LogStyle style{.separator = '\0', .decimal_comma = format % 6 == 1};
      parse_csv(bytes, file, csv_names(bytes, file, style), style);
      break;
    }
    case 2:
      parse_rsi(bytes, file, rsi_names(bytes, file));
      break;
    case 3: {
      // header and numbers in one: the numbers follow the last newline
      const std::size_t cut = bytes.rfind('\n');
      const auto header = bytes.substr(0, cut == std::string_view::npos ? bytes.size() : cut);
      const auto channels = parse_trace_header(header, file);
      for (const TraceChannel& channel : channels)
        trace_values(channel, channels, bytes.substr(header.size()));
      break;
    }
    case 4:
      mat_arrays(bytes, file);
      break;
    default:
      parse_mcap(bytes, file, mcap_names(bytes, file, {}), {});
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    read(data[0], std::string_view(reinterpret_cast<const char*>(data) + 1, size - 1));
  } catch (const fricid::UserError&) {
    return 0;
  }
  return 0;
}
