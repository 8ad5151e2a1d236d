#include "mat.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>

#include "bytes.hpp"
#include "compression.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"

namespace fricid::data {
namespace {

constexpr std::size_t kHeader = 128, kEndianness = 126;
constexpr std::size_t kUnit = 8;  // elements take a multiple of it

// types of elements
constexpr std::uint32_t kInt8 = 1, kUint8 = 2, kInt16 = 3, kUint16 = 4, kInt32 = 5, kUint32 = 6,
                        kSingle = 7, kDouble = 9, kInt64 = 12, kUint64 = 13, kMatrix = 14,
                        kCompressed = 15;
// classes of arrays; those of numbers are consecutive
constexpr std::uint32_t kStruct = 2, kFirstOfNumbers = 6, kLastOfNumbers = 15;
constexpr std::uint32_t kComplex = 0x800;

struct Element {
  std::uint32_t type = 0;
  std::string_view content;
};

/// Walks a file and collects its arrays.
class MatWalker {
 public:
  explicit MatWalker(const std::string& file) : file_(file) {}

  std::vector<MatArray> walk(std::string_view elements) {
    Bytes rest(elements, file_);
    while (!rest.empty()) {
      const Element element = next(rest);
      if (element.type == kCompressed) {
        const std::string content = inflated(element.content, file_);
        Bytes inner(content, file_);
        take_array(expected(inner, kMatrix), "", 0);
      } else if (element.type == kMatrix) {
        take_array(element.content, "", 0);
      }
    }
    return std::move(arrays_);
  }

 private:
  [[noreturn]] void refuse(const char* what) const {
    throw UserError("{}: damaged: {} of a MAT-file", file_, what);
  }

  Element next(Bytes& rest) const {
    const auto word = rest.number<std::uint32_t>();
    if (const std::uint32_t size = word >> 16; size > 0) {
      if (size > sizeof(std::uint32_t)) refuse("the size of an element");
      return {word & 0xFFFF, rest.take(sizeof(std::uint32_t)).substr(0, size)};
    }
    const Element element{word, rest.take(rest.number<std::uint32_t>())};
    if (const std::size_t over = element.content.size() % kUnit;
        over > 0 && element.type != kCompressed)
      rest.take(std::min(kUnit - over, rest.size()));
    return element;
  }

  std::string_view expected(Bytes& rest, std::uint32_t type) const {
    const Element element = next(rest);
    if (element.type != type) refuse("the type of an element");
    return element.content;
  }

  /// @param name   empty: that in the array
  void take_array(std::string_view content, const std::string& name, std::uint64_t level) {
    require_within(limits::kMatLevels, level, file_);
    require_within(limits::kTables, arrays_.size(), file_);
    if (content.empty()) {
      arrays_.push_back({.name = name});
      return;
    }
    Bytes rest(content, file_);
    Bytes flags(expected(rest, kUint32), file_);
    const auto kind = flags.number<std::uint32_t>();
    std::vector<std::uint64_t> sides;
    for (Bytes sizes(expected(rest, kInt32), file_); !sizes.empty();)
      sides.push_back(sizes.number<std::uint32_t>());
    const std::string own(expected(rest, kInt8));
    const std::string called = name.empty() ? checked(own) : name;
    if (called.empty()) return;  // what MATLAB keeps of its objects
    const std::uint32_t of_class = kind & 0xFF;
    if (of_class == kStruct)
      take_fields(rest, product(sides, content.size()), called, level);
    else if (of_class >= kFirstOfNumbers && of_class <= kLastOfNumbers && (kind & kComplex) == 0)
      arrays_.push_back(numbers(next(rest), called, sides));
    else
      arrays_.push_back({.name = called});
  }

  void take_fields(Bytes& rest, std::uint64_t count, const std::string& name, std::uint64_t level) {
    const auto length = Bytes(expected(rest, kInt32), file_).number<std::uint32_t>();
    const std::string_view names = expected(rest, kInt8);
    if (length == 0 || names.size() % length != 0) refuse("the names of fields");
    for (std::uint64_t k = 0; k < count; ++k)
      for (std::size_t begin = 0; begin < names.size(); begin += length) {
        const std::string_view field = names.substr(begin, length);
        const std::string last = checked(std::string(field.substr(0, field.find('\0'))));
        take_array(expected(rest, kMatrix),
                   count == 1 ? fmt::format("{}.{}", name, last)
                              : fmt::format("{}({}).{}", name, k + 1, last),
                   level + 1);
      }
  }

  MatArray numbers(const Element& stored, const std::string& name,
                   const std::vector<std::uint64_t>& sides) const {
    MatArray array{.name = name};
    std::vector<std::uint64_t> long_sides;
    std::ranges::copy_if(sides, std::back_inserter(long_sides),
                         [](std::uint64_t side) { return side != 1; });
    if (long_sides.size() > 2) return array;
    long_sides.resize(2, 1);
    const std::uint64_t count = product(sides, stored.content.size());
    if (count == 0) return array;
    array.rows = static_cast<std::int64_t>(long_sides[0]);
    array.columns = static_cast<std::int64_t>(long_sides[1]);
    array.values.reserve(count);
    if (!convert(stored, count, array.values)) refuse("the numbers of an array");
    return array;
  }

  /// False unless they are `count` numbers of a known type.
  bool convert(const Element& stored, std::uint64_t count, std::vector<double>& values) const {
    const auto all = [&]<class T>(T) {
      if (stored.content.size() != count * sizeof(T)) return false;
      Bytes rest(stored.content, file_);
      while (!rest.empty()) values.push_back(static_cast<double>(rest.number<T>()));
      return true;
    };
    switch (stored.type) {
      case kInt8:
        return all(std::int8_t());
      case kUint8:
        return all(std::uint8_t());
      case kInt16:
        return all(std::int16_t());
      case kUint16:
        return all(std::uint16_t());
      case kInt32:
        return all(std::int32_t());
      case kUint32:
        return all(std::uint32_t());
      case kInt64:
        return all(std::int64_t());
      case kUint64:
        return all(std::uint64_t());
      case kSingle:
        return all(float());
      case kDouble:
        return all(double());
      default:
        return false;
    }
  }

  /// Of sides of which each unit takes a byte at least.
  std::uint64_t product(const std::vector<std::uint64_t>& sides, std::size_t bytes) const {
    if (std::ranges::count(sides, std::uint64_t{0}) > 0) return 0;
    std::uint64_t count = 1;
    for (const std::uint64_t side : sides) {
      if (side > bytes / count) refuse("the dimensions of an array");
      count *= side;
    }
    return count;
  }

  /// A name as MATLAB allows it, or none.
  std::string checked(const std::string& name) const {
    const auto allowed = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    };
    if (name.size() > limits::kNameBytes.most || !std::ranges::all_of(name, allowed))
      refuse("a name");
    return name;
  }

  const std::string& file_;
  std::vector<MatArray> arrays_;
};

}  // namespace

std::vector<MatArray> mat_arrays(std::string_view bytes, const std::string& file) {
  if (!bytes.starts_with(kMatMagic)) throw UserError("{}: no MAT-file of version 5", file);
  if (bytes.size() < kHeader) throw UserError("{}: torn: the header of a MAT-file", file);
  const std::string_view order = bytes.substr(kEndianness, 2);
  if (order == "MI")
    throw UserError("{}: a MAT-file of a big-endian machine; allowed: little-endian", file);
  if (order != "IM") throw UserError("{}: damaged: the header of a MAT-file", file);
  return MatWalker(file).walk(bytes.substr(kHeader));
}

}  // namespace fricid::data
