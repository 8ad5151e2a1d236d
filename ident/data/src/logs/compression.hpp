// Compressed stretches of log files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace fricid::data {

/// `size` bytes from what "zstd" or "lz4" (frames of either format) made of them.
/// @param file  for the message
/// @throws UserError for another compression, damage, or bytes that are missing
std::string decompressed(std::string_view bytes, std::uint64_t size, const std::string& compression,
                         const std::string& file);

/// All that zlib made a stretch of. @throws UserError for damage, which its checksum tells, or more
/// than the memory takes
std::string inflated(std::string_view bytes, const std::string& file);

}  // namespace fricid::data
