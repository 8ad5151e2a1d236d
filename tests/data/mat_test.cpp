// MAT-files: what SciPy wrote, structures, classes, damage.
#include "logs/mat.hpp"

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_reader.hpp"
#include "log_samples.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string bytes_of(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
  return bytes;
}

std::string message_of_arrays(const std::string& bytes) {
  try {
    mat_arrays(bytes, "a.mat");
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

/// Columns of a structure, of one element or of several.
std::string structure(const std::string& name, std::int32_t count, const std::string& fields,
                      const std::string& arrays) {
  return mat_array(2, {1, count}, name,
                   ByteWriter().number(std::uint32_t{4 << 16 | 5}).number(std::int32_t{4}).bytes() +
                       mat_element(1, fields) + arrays);
}

// scipy.io.savemat of SciPy 1.17.1, do_compression = True, of t = [[0, .5, 1]],
// n = int16([[1, -2], [3, 4], [5, 6]]), S = {x: [1.5, 2.5, 3.5], word: "ab"}, c = [1 + 2j].
TEST(Mat, OfSciPy) {
  const std::vector<MatArray> arrays = mat_arrays(
      mat_file(bytes_of(
          "0f0000002d000000789ce3636060f000623620e680d220c00ae5330231339866642801d29c402cc1800e1ed8"
          "43e80ff600444003610f00000031000000789ce36360607000623620e600622e06086085f299819809881981"
          "300fcae701f399816afefd6701eb646000003ef303080f00000061000000789ce3636060b800c46c40cc01c4"
          "4c0c10c00ae533c231234330589c052c0712e302e20a90e2f2fca214a83e3e20f640328f0d8b79cc501a0438"
          "81588201067ed84368160708cde30032cf00c93c162ce63121992700e4252631300000372d073a0f0000002b"
          "000000789ce3636060f000623620e600d120020858a17c463866644806d29c507108f8608fca677000004ae5"
          "0278")),
      "scipy.mat");
  ASSERT_EQ(arrays.size(), 5U);
  EXPECT_EQ(arrays[0].name, "t");
  EXPECT_EQ(arrays[0].rows * arrays[0].columns, 3);
  EXPECT_THAT(arrays[0].values, ElementsAre(0, 0.5, 1));
  EXPECT_EQ(arrays[1].name, "n");
  EXPECT_EQ(arrays[1].rows, 3);
  EXPECT_EQ(arrays[1].columns, 2);
  EXPECT_THAT(arrays[1].values, ElementsAre(1, 3, 5, -2, 4, 6));
  EXPECT_EQ(arrays[2].name, "S.x");
  EXPECT_THAT(arrays[2].values, ElementsAre(1.5, 2.5, 3.5));
  EXPECT_EQ(arrays[3].name, "S.word");
  EXPECT_EQ(arrays[3].rows, 0);
  EXPECT_EQ(arrays[4].name, "c");
  EXPECT_EQ(arrays[4].rows, 0);
}

TEST(Mat, EveryClassOfNumbers) {
  const auto array = [](std::uint32_t type, const std::string& numbers) {
    return mat_arrays(mat_file(mat_array(6, {2, 1}, "x", mat_element(type, numbers))), "a.mat")[0]
        .values;
  };
  const auto two = [](auto first, auto second) {
    return ByteWriter().number(first).number(second).bytes();
  };
  EXPECT_THAT(array(1, two(std::int8_t{-1}, std::int8_t{127})), ElementsAre(-1, 127));
  EXPECT_THAT(array(2, two(std::uint8_t{1}, std::uint8_t{255})), ElementsAre(1, 255));
  EXPECT_THAT(array(3, two(std::int16_t{-300}, std::int16_t{2})), ElementsAre(-300, 2));
  EXPECT_THAT(array(4, two(std::uint16_t{1}, std::uint16_t{65535})), ElementsAre(1, 65535));
  EXPECT_THAT(array(5, two(std::int32_t{-70000}, std::int32_t{2})), ElementsAre(-70000, 2));
  EXPECT_THAT(array(6, two(std::uint32_t{1}, std::uint32_t{4000000000})),
              ElementsAre(1, 4000000000));
  EXPECT_THAT(array(7, two(0.5F, -2.0F)), ElementsAre(0.5, -2));
  EXPECT_THAT(array(9, two(0.1, -2.0)), ElementsAre(0.1, -2));
  EXPECT_THAT(array(12, two(std::int64_t{-5}, std::int64_t{2})), ElementsAre(-5, 2));
  EXPECT_THAT(array(13, two(std::uint64_t{5}, std::uint64_t{2})), ElementsAre(5, 2));
}

// Simulink's "structure with time": signals of n x 1 x T, of which the long sides count.
TEST(Mat, FieldsOfStructuresHaveNames) {
  const std::string time = mat_doubles("", Eigen::VectorXd::LinSpaced(3, 0, 1));
  ByteWriter six;
  for (int i = 0; i < 6; ++i) six.number(static_cast<double>(i));
  const std::string values = mat_array(6, {2, 1, 3}, "", mat_element(9, six.bytes()));
  const std::string signal = structure("", 2, std::string("y\0\0\0", 4), values + values);
  const std::string whole =
      structure("out", 1, std::string("t\0\0\0s\0\0\0", 8), time + signal) + mat_doubles("g", {});
  const std::vector<MatArray> arrays = mat_arrays(mat_file(whole), "a.mat");
  ASSERT_EQ(arrays.size(), 4U);
  EXPECT_EQ(arrays[0].name, "out.t");
  EXPECT_EQ(arrays[1].name, "out.s(1).y");
  EXPECT_EQ(arrays[2].name, "out.s(2).y");
  EXPECT_EQ(arrays[2].rows, 2);
  EXPECT_EQ(arrays[2].columns, 3);
  EXPECT_THAT(arrays[2].values, ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_EQ(arrays[3].rows, 0);
}

TEST(Mat, TornAndDamaged) {
  const std::string plain = mat_sample(Recording(20), false).files[0].second;
  for (std::size_t size = 20; size < plain.size(); size += 7)
    if (const std::string said = message_of_arrays(plain.substr(0, size)); said.empty())
      EXPECT_LT(mat_arrays(plain.substr(0, size), "a.mat").size(), 4U) << size;
    else
      EXPECT_THAT(said, testing::AnyOf(HasSubstr("torn"), HasSubstr("damaged"))) << size;
  // the checksum of zlib tells each changed bit of what is compressed
  const std::string whole = mat_sample(Recording(20), true).files[0].second;
  const std::size_t end =
      128 + mat_compressed(mat_doubles("t", Eigen::VectorXd::LinSpaced(20, 0, 0.004 * 19))).size();
  for (std::size_t at = 128 + 8; at < end; ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 4);
    EXPECT_THAT(message_of_arrays(changed), HasSubstr("a.mat: damaged: ")) << at;
  }
  std::string big = plain;
  std::swap(big[126], big[127]);
  EXPECT_EQ(message_of_arrays(big),
            "a.mat: a MAT-file of a big-endian machine; allowed: little-endian");
  EXPECT_EQ(message_of_arrays(mat_file(mat_array(6, {1 << 30, 1 << 30}, "x", mat_element(9, "")))),
            "a.mat: damaged: the dimensions of an array of a MAT-file");
  EXPECT_EQ(message_of_arrays(mat_file(mat_array(6, {1, 1}, "x\n", mat_element(9, "12345678")))),
            "a.mat: damaged: a name of a MAT-file");
  std::string deep = mat_doubles("", Eigen::VectorXd::Ones(1));
  for (int level = 0; level <= 33; ++level)
    deep = structure(level == 33 ? "S" : "", 1, std::string("f\0\0\0", 4), deep);
  EXPECT_EQ(message_of_arrays(mat_file(deep)),
            "a.mat: 33 levels of structures in a MAT file; allowed: up to 32");
}

class MatLog : public FolderTest {};

TEST_F(MatLog, AColumnThatIsMissingIsNamedWithThoseThatAreThere) {
  const Recording r(20);
  const std::string text = mat_array(4, {1, 2}, "word", mat_element(4, "a"));
  write("log.mat", mat_file(mat_doubles("t", Eigen::VectorXd::LinSpaced(20, 0, 1)) +
                            mat_doubles("angle", r.q) + text));
  const Contract terms = load_contract(
      write("contract.toml", std::string(kJoints) + "format = \"mat\"\n[torque]\ncolumns = "
                                                    "\"tau{}\"\n"));
  EXPECT_EQ(message_of([&] { import_log(path("log.mat"), terms); }),
            "log.mat: q1 is missing; found t, angle1, angle2, and word (a text, a cell, an object, "
            "complex, or empty); allowed: arrays of real numbers");
}

}  // namespace
}  // namespace fricid::data
