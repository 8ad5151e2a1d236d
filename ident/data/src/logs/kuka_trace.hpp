// KUKA KRC TRACE, the oscilloscope of the controller: a text header NAME.dat (DIAdem, ISO 8859-1)
// that describes the channels, and NAME.r64 with 64-bit little-endian numbers, one per channel and
// sample, sample by sample.
//
//     value = offset + raw * factor          header keys 240, 241; column in NAME.r64: key 221
//
// A channel marked IMPLIZIT is computed, offset + k * factor at sample k: the time. The drives
// record one file each, NAME#1.dat ... NAME#6.dat: together they are one log, in which the number
// of the drive follows the channel's name (Istposition1).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/log_reader.hpp"

namespace fricid::data {

/// One channel of a header.
struct TraceChannel {
  std::string name;        ///< key 200
  bool implicit = false;   ///< key 210
  int column = 0;          ///< key 221, from 0
  double offset = 0;       ///< key 240
  double factor = 1;       ///< key 241
  long long samples = -1;  ///< key 220; -1: not given
};

/// @throws UserError "file:line: ..." when it is no such header or a value is no number
std::vector<TraceChannel> parse_trace_header(std::string_view text, const std::string& file);

/// One column of numbers. A last sample that the file ends in is left out.
/// @param channels  all of the header
std::vector<double> trace_values(const TraceChannel& channel,
                                 const std::vector<TraceChannel>& channels, std::string_view raw);

std::vector<std::string> trace_names(const std::filesystem::path& path);
/// @throws UserError also when NAME.r64 is missing or the drives' files have unlike lengths
LogTable read_trace(const std::filesystem::path& path, const std::vector<std::string>& wanted);

}  // namespace fricid::data
