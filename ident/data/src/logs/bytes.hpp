// Numbers and texts in binary logs.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include "fricid/base/error.hpp"

namespace fricid::data {

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
    if constexpr (std::is_same_v<T, float>)
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    else if constexpr (std::is_same_v<T, double>)
      return std::bit_cast<double>(bits);
    else
      return static_cast<T>(bits);
  }
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

}  // namespace fricid::data
