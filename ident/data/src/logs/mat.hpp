// MAT-files of version 5, as MATLAB's save makes them unless told -v7.3, and Octave and SciPy
// (MathWorks, MAT-File Format, 2023, chapter 1).
//
// A file is a header of 128 bytes, then elements: type (4 bytes), size (4), content, up to a
// multiple of 8; up to four bytes of content may lie in the place of the size. An array is an
// element that holds its class, dimensions, name and numbers by columns; a structure one that holds
// an array for each field. Arrays may be compressed by zlib, whose checksum tells damage.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace fricid::data {

/// What MAT-files of version 5 begin with.
inline constexpr std::string_view kMatMagic = "MATLAB 5.0 MAT-file";

/// An array of a MAT-file. The field f of a structure S is S.f, of its second element S(2).f where
/// it has several.
struct MatArray {
  std::string name;
  /// Its sides but for those of length 1. 0: not one of real numbers with one or two of them.
  std::int64_t rows = 0, columns = 0;
  std::vector<double> values{};  ///< by columns
};

/// All arrays, in the order of the file.
/// @throws UserError: torn, damaged, of a big-endian machine, more than the memory takes
std::vector<MatArray> mat_arrays(std::string_view bytes, const std::string& file);

}  // namespace fricid::data
