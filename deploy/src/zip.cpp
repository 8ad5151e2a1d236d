#include "zip.hpp"

#include <array>
#include <cstdint>
#include <string_view>

namespace fricid::deploy {
namespace {

/// CRC-32 of ISO 3309, as zip has it.
std::uint32_t crc32(std::string_view bytes) {
  static const auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      table[i] = i;
      for (int bit = 0; bit < 8; ++bit)
        table[i] = (table[i] & 1u) ? 0xedb88320u ^ (table[i] >> 1) : table[i] >> 1;
    }
    return table;
  }();
  std::uint32_t crc = 0xffffffffu;
  for (const char c : bytes)
    crc = kTable[(crc ^ static_cast<unsigned char>(c)) & 0xffu] ^ (crc >> 8);
  return ~crc;
}

template <int kBytes>
void append(std::string& text, std::size_t value) {
  for (int i = 0; i < kBytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xffu);
}

// What the header of a file and its entry in the directory share.
void append_entry(std::string& text, const TextFile& file) {
  constexpr std::size_t kVersion = 20, kUtf8 = 1u << 11, kDate1980 = 0x21;
  append<2>(text, kVersion);
  append<2>(text, kUtf8);
  append<2>(text, 0);  // stored
  append<2>(text, 0);  // time
  append<2>(text, kDate1980);
  append<4>(text, crc32(file.text));
  append<4>(text, file.text.size());
  append<4>(text, file.text.size());
  append<2>(text, file.name.size());
  append<2>(text, 0);  // no further fields
}

}  // namespace

std::string zip(std::span<const TextFile> files) {
  std::string archive, directory;
  for (const TextFile& file : files) {
    const std::size_t offset = archive.size();
    archive += "PK\3\4";
    append_entry(archive, file);
    archive += file.name + file.text;

    constexpr std::size_t kByUnix = 3u << 8 | 20u, kReadable = 0100755u << 16;
    directory += "PK\1\2";
    append<2>(directory, kByUnix);
    append_entry(directory, file);
    append<2>(directory, 0);  // no comment
    append<2>(directory, 0);  // first disk
    append<2>(directory, 0);  // binary
    append<4>(directory, kReadable);
    append<4>(directory, offset);
    directory += file.name;
  }
  const std::size_t begin = archive.size();
  archive += directory + "PK\5\6";
  append<4>(archive, 0);  // one disk
  append<2>(archive, files.size());
  append<2>(archive, files.size());
  append<4>(archive, directory.size());
  append<4>(archive, begin);
  append<2>(archive, 0);  // no comment
  return archive;
}

}  // namespace fricid::deploy
