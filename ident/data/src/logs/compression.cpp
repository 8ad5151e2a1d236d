#include "compression.hpp"

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "columns.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"

namespace fricid::data {
namespace {

/// Grown as bytes come, so that a wrong size in the file costs no memory.
constexpr std::size_t kPiece = std::size_t{1} << 20;

std::string from_zstd(std::string_view bytes, std::size_t size) {
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          ZSTD_freeDStream);
  std::string text;
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  while (text.size() < size) {
    const std::size_t begin = text.size();
    text.resize(std::min(size, begin + kPiece));
    ZSTD_outBuffer out{text.data() + begin, text.size() - begin, 0};
    const bool failed = ZSTD_isError(ZSTD_decompressStream(stream.get(), &out, &in)) != 0;
    text.resize(begin + out.pos);
    if (failed || out.pos == 0) break;
  }
  return text;
}

std::string from_lz4(std::string_view bytes, std::size_t size) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return {};
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(
      context, LZ4F_freeDecompressionContext);
  std::string text;
  while (text.size() < size) {
    const std::size_t begin = text.size();
    text.resize(std::min(size, begin + kPiece));
    std::size_t made = text.size() - begin, used = bytes.size();
    const bool failed = LZ4F_isError(LZ4F_decompress(context, text.data() + begin, &made,
                                                     bytes.data(), &used, nullptr)) != 0;
    text.resize(begin + (failed ? 0 : made));
    if (failed || made == 0) break;
    bytes.remove_prefix(used);
  }
  return text;
}

}  // namespace

std::string decompressed(std::string_view bytes, std::uint64_t size, const std::string& compression,
                         const std::string& file) {
  if (compression != "zstd" && compression != "lz4")
    throw UserError("{}: chunks are compressed by {}; allowed: zstd lz4", file,
                    in_quotes(compression));
  const auto wanted = static_cast<std::size_t>(size);
  std::string text = compression == "zstd" ? from_zstd(bytes, wanted) : from_lz4(bytes, wanted);
  if (text.size() != wanted)
    throw UserError("{}: damaged: a chunk gives {} of {} bytes", file, text.size(), wanted);
  return text;
}

std::string inflated(std::string_view bytes, const std::string& file) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw UserError("{}: zlib has no memory", file);
  const std::unique_ptr<z_stream, decltype(&inflateEnd)> owner(&stream, inflateEnd);
  std::string text;
  int state = Z_OK;
  while (state == Z_OK) {
    const std::size_t begin = text.size();
    require_memory(2.0 * static_cast<double>(begin + kPiece), file, "a compressed array");
    text.resize(begin + kPiece);
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + begin);
    stream.avail_out = static_cast<uInt>(kPiece);
    // sizes of zlib are of 32 bits
    if (stream.avail_in == 0) {
      const std::size_t piece = std::min(bytes.size(), kPiece);
      stream.next_in = reinterpret_cast<z_const Bytef*>(const_cast<char*>(bytes.data()));  // NOLINT
      stream.avail_in = static_cast<uInt>(piece);
      bytes.remove_prefix(piece);
    }
    state = inflate(&stream, Z_NO_FLUSH);
    text.resize(begin + kPiece - stream.avail_out);
  }
  if (state != Z_STREAM_END) throw UserError("{}: damaged: a compressed array", file);
  return text;
}

}  // namespace fricid::data
