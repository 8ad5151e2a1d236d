// What files may ask for at most: refused in one line, before memory or stack run out.
#include <gmock/gmock.h>
#include <hdf5.h>
#include <sys/resource.h>

#include <array>
#include <fstream>
#include <functional>

#include "fricid/base/files.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/log_reader.hpp"
#include "fricid/scene/problem.hpp"
#include "hdf5_library.hpp"
#include "log_samples.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

std::string repeated(const std::string& text, int count) {
  std::string result;
  for (int i = 0; i < count; ++i) result += text;
  return result;
}

class SceneLimits : public FolderTest {
 protected:
  std::string error_of(const std::string& text) const {
    return message_of([&] { scene::load_problem(write("scene.toml", text)); });
  }
};

TEST_F(SceneLimits, DeepTables) {
  for (const int levels : {33, 100'000})
    for (const std::string& text :
         {repeated("a.", levels) + "a = 1", "[" + repeated("\"a\" . ", levels) + "a]",
          "a = " + repeated("[", levels) + repeated("]", levels),
          "a = " + repeated("{a = ", levels) + "1" + repeated("}", levels)})
      EXPECT_THAT(error_of("\n" + text),
                  testing::AllOf(StartsWith("scene.toml:2: 33 levels of one key or one value"),
                                 EndsWith("; allowed: up to 32")))
          << text.substr(0, 40);
}

TEST_F(SceneLimits, DotsAndBracketsInTextAreNotLevels) {
  const std::string dots = repeated(".[{", 50);
  EXPECT_EQ(error_of("description = \"" + dots + "\\\"" + dots + "\"  # " + dots + "\n" + kScene),
            "no error");
  EXPECT_EQ(error_of("description = '" + dots + "'\n" + kScene), "no error");
  EXPECT_EQ(error_of("description = \"\"\"\n" + dots + "\"" + dots + "\"\"\"\n" + kScene),
            "no error");
}

TEST_F(SceneLimits, ManyFilesToExtend) {
  write("empty.toml", "");
  const auto extending = [](int count) {
    return "extends = [" + repeated("\"empty.toml\", ", count) + "]\n" + kScene;
  };
  EXPECT_EQ(error_of(extending(63)), "no error");
  EXPECT_EQ(error_of(extending(20'000)),
            "scene.toml: 65 files read for one scene, by extends; allowed: up to 64");
}

// Every file names the next one twice: 2^25 ways to the last.
TEST_F(SceneLimits, DiamondsOfFilesToExtend) {
  for (int i = 0; i < 25; ++i)
    write("s" + std::to_string(i) + ".toml",
          fmt::format("extends = [\"s{0}.toml\", \"s{0}.toml\"]", i + 1));
  write("s25.toml", "");
  EXPECT_THAT(error_of(std::string("extends = \"s0.toml\"\n") + kScene),
              HasSubstr("65 files read for one scene"));
}

TEST_F(SceneLimits, WhatCannotBeDoneIsRefusedBeforeAnyWork) {
  EXPECT_EQ(
      error_of(std::string(kScene) + "[identify]\ncutoff_hz = 125\n"),
      "scene.toml:13: identify.cutoff_hz = 125 Hz; allowed: below 125 Hz, half the sample rate");
  EXPECT_EQ(error_of(std::string(kScene) + "[evaluate]\nhorizons_s = []\n"),
            "scene.toml:13: evaluate.horizons_s = an empty array; allowed: one horizon or more");
  EXPECT_EQ(error_of(std::string(kScene) + "[evaluate]\ndraws = 3\n"),
            "scene.toml:13: evaluate.draws = 3; allowed: 0 or at least 19");
}

TEST_F(SceneLimits, HorizonsAreInTheData) {
  const scene::Scene scene =  // data can be made all the same
      scene::load_problem(
          write("scene.toml", std::string(kScene) + "[evaluate]\nhorizons_s = [0.1, 32]\n"))
          .scene;
  EXPECT_EQ(message_of([&] { scene::require_horizons(scene); }),
            "scene.toml:13: evaluate.horizons_s = 32 s; allowed: up to 31.41 s, the length of a "
            "recording");
}

// A file of another program with a table that says it has so many rows, none of them written.
class Hdf5Limits : public FolderTest {
 protected:
  /// Adds a table q without values to a file; closes the space.
  static void add_table(hid_t file, hid_t space, const std::function<void(hid_t)>& set) {
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    set(properties);
    const hid_t table =
        H5Dcreate2(file, "q", H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    ASSERT_GE(table, 0);
    H5Dclose(table);
    H5Pclose(properties);
    H5Sclose(space);
  }
  std::filesystem::path declare(std::uint64_t rows) const {
    const std::array<hsize_t, 2> shape{rows, 2}, chunk{1024, 2};
    const hid_t file = H5Fcreate(path("b.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    add_table(file, H5Screate_simple(2, shape.data(), nullptr),
              [&](hid_t properties) { H5Pset_chunk(properties, 2, chunk.data()); });
    H5Fclose(file);
    return path("b.h5");
  }
};

TEST_F(Hdf5Limits, GiantTablesAreRefusedByTheirSize) {
  for (const std::uint64_t rows : {std::uint64_t{1} << 40, std::uint64_t{1} << 59}) {
    const H5Reader file(declare(rows), "");
    EXPECT_THAT(message_of([&] { file.matrix("q"); }),
                testing::AllOf(
                    StartsWith(fmt::format("b.h5: table /q of {} x 2 numbers would take ", rows)),
                    HasSubstr(" GB of memory; allowed: ")));
  }
}

TEST_F(Hdf5Limits, ShapesAreTakenWithoutReading) {
  const H5Reader file(declare(std::uint64_t{1} << 40), "");
  EXPECT_EQ(file.shape("q").rows, std::int64_t{1} << 40);
  EXPECT_EQ(file.shape("q").columns, 2);
  EXPECT_EQ(file.shape("none").columns, 0);
  const LogReader& reader = reader_for(path("b.h5"), "auto");
  EXPECT_EQ(reader.name, "hdf5");
  EXPECT_EQ(reader.names(path("b.h5"), {}), (std::vector<std::string>{"q1", "q2"}));
}

// One chunk of 3.2 GB for two numbers.
TEST_F(Hdf5Limits, GiantChunksAreRefusedByTheirSize) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer takes address space of its own";
#endif
  const hid_t file = H5Fcreate(path("b.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const std::array<hsize_t, 2> shape{1, 2}, most{H5S_UNLIMITED, 2}, chunk{200'000'000, 2};
  add_table(file, H5Screate_simple(2, shape.data(), most.data()), [&](hid_t properties) {
    H5Pset_chunk(properties, 2, chunk.data());
    H5Pset_deflate(properties, 9);
  });
  H5Fclose(file);
  rlimit before{};
  ::getrlimit(RLIMIT_AS, &before);
  const rlimit space{rlim_t{4} << 30, before.rlim_max};
  ::setrlimit(RLIMIT_AS, &space);
  const std::string said = message_of([&] { H5Reader(path("b.h5"), "").matrix("q"); });
  ::setrlimit(RLIMIT_AS, &before);
  EXPECT_THAT(said, StartsWith("b.h5: table /q of 1 x 2 numbers would take 3.2 GB of memory"));
}

TEST_F(Hdf5Limits, TablesOfUnlikeLengthAreNotPrintedSideBySide) {
  const auto printed = [&](std::int64_t rows) {
    write_hdf5(path("b.h5"), "fricid.dataset/1", [&](H5Writer& file) {
      file.matrix("q", RowMatrix::Constant(2, 2, 0.5), "rad");
      file.matrix("none", RowMatrix(3, 0), "rad");
      file.vector("t, \x1b", Eigen::VectorXd::Constant(rows, 1), "s");
    });
    std::string text;
    print_tables(H5Reader(path("b.h5"), ""), [&](const std::string& line) { text += line; });
    return text;
  };
  EXPECT_EQ(printed(2), "q1,q2,\"t, \\x1b\"\n0.5,0.5,1\n0.5,0.5,1\n");
  for (const std::int64_t rows : {0, 1, 3, 1000})
    EXPECT_EQ(message_of([&] { printed(rows); }),
              fmt::format("b.h5: table t, \\x1b has {} rows; allowed beside the first: 2", rows));
}

TEST_F(Hdf5Limits, ColumnsWithoutRowsTakeNoTime) {
  const auto printed = [&](hsize_t columns, int tables) {
    const hid_t file = H5Fcreate(path("b.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const std::array<hsize_t, 2> shape{0, columns};
    for (int i = 0; i < tables; ++i) {
      const hid_t space = H5Screate_simple(2, shape.data(), nullptr);
      H5Dclose(H5Dcreate2(file, std::to_string(i).c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                          H5P_DEFAULT, H5P_DEFAULT));
      H5Sclose(space);
    }
    H5Fclose(file);
    return message_of([&] { print_tables(H5Reader(path("b.h5"), ""), [](const auto&) {}); });
  };
  const auto refused = [](hsize_t columns) {
    return fmt::format(
        "b.h5: {} columns in all tables of an HDF5 or MAT file; allowed: up to 100000", columns);
  };
  EXPECT_EQ(printed(hsize_t{1} << 40, 1), refused(hsize_t{1} << 40));
  EXPECT_EQ(printed(60'000, 2), refused(120'000));
  EXPECT_EQ(printed(50'000, 2), "no error");
}

// The library loses track of objects in damaged files.
TEST_F(Hdf5Limits, AFileIsReadAgainThoughAnObjectOfItWasLost) {
  const auto bytes = [&](const char* unit) {
    write_hdf5(path("b.h5"), "fricid.dataset/1",
               [&](H5Writer& file) { file.matrix("q", RowMatrix::Zero(2, 2), unit); });
    return read_file(path("b.h5"));
  };
  const std::string second = bytes("m/s"), first = bytes("rad");
  ASSERT_EQ(first.size(), second.size());
  {
    const hdf5::Id file = hdf5::open_to_read(path("b.h5"));
    const hid_t lost = H5Oopen(file, "q", H5P_DEFAULT);
    std::vector<std::string> unit;
    EXPECT_TRUE(hdf5::read_texts(lost, "unit", "", unit));
    EXPECT_EQ(unit, std::vector<std::string>{"rad"});
  }
  std::fstream(path("b.h5"), std::ios::in | std::ios::out | std::ios::binary) << second;
  EXPECT_EQ(H5Reader(path("b.h5"), "").unit("q"), "m/s");
}

// What a file names elsewhere could be any file of the reader.
TEST_F(Hdf5Limits, TablesInOtherFilesAreRefused) {
  const auto of_file = [&](const std::function<void(hid_t)>& fill) {
    const hid_t file = H5Fcreate(path("b.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    fill(file);
    H5Fclose(file);
    const H5Reader reader(path("b.h5"), "");
    EXPECT_EQ(message_of([&] { reader.shape("q"); }), message_of([&] { reader.matrix("q"); }));
    return message_of([&] { reader.matrix("q"); });
  };
  const std::array<hsize_t, 2> shape{4, 2};
  const std::string secret = write("secret", std::string(64, 'x')).string();
  EXPECT_EQ(of_file([&](hid_t file) {
              H5Lcreate_external(secret.c_str(), "/q", file, "q", H5P_DEFAULT, H5P_DEFAULT);
            }),
            "b.h5: /q is a link; allowed: a table");
  EXPECT_EQ(
      of_file([&](hid_t file) { H5Lcreate_soft("/other", file, "q", H5P_DEFAULT, H5P_DEFAULT); }),
      "b.h5: /q is a link; allowed: a table");
  EXPECT_EQ(of_file([&](hid_t file) {
              add_table(file, H5Screate_simple(2, shape.data(), nullptr), [&](hid_t properties) {
                H5Pset_external(properties, secret.c_str(), 0, 64);
              });
            }),
            "b.h5: the numbers of /q are in another file; allowed: in this one");
  EXPECT_EQ(of_file([&](hid_t file) {
              const hid_t space = H5Screate_simple(2, shape.data(), nullptr);
              add_table(file, H5Scopy(space), [&](hid_t properties) {
                H5Pset_virtual(properties, space, secret.c_str(), "/q", space);
              });
              H5Sclose(space);
            }),
            "b.h5: the numbers of /q are in another file; allowed: in this one");
}

TEST_F(Hdf5Limits, GiantAttributesAreRefusedByTheirSize) {
  const hid_t newest = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_libver_bounds(newest, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  const hid_t file = H5Fcreate(path("b.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, newest);
  for (const auto& [name, count] :
       {std::pair("most", hsize_t{100'000}), std::pair("more", hsize_t{100'001})}) {
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    H5Aclose(H5Acreate2(file, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space);
  }
  H5Fclose(file);
  H5Pclose(newest);
  const H5Reader reader(path("b.h5"), "");
  EXPECT_EQ(reader.numbers_attribute("most").size(), 100'000u);
  EXPECT_EQ(message_of([&] { reader.numbers_attribute("more"); }),
            "b.h5: 100001 values of an attribute of an HDF5 file; allowed: up to 100000");
}

// A text of variable length lies in a heap of the file, under a size that the library of Debian 12
// believes: a giant one, or none, after which it looks at the same place for ever.
TEST_F(Hdf5Limits, AFileOnWhichTheLibraryCrashesOrNeverEndsIsRefused) {
  const hid_t file = H5Fcreate(path("b.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, H5T_VARIABLE);
  const hid_t unit = H5Acreate2(file, "unit", type, space, H5P_DEFAULT, H5P_DEFAULT);
  const char* text = "rad";
  H5Awrite(unit, type, &text);
  for (const auto close : {H5Aclose(unit), H5Sclose(space), H5Tclose(type), H5Fclose(file)})
    ASSERT_GE(close, 0);
  const auto read = [&] { return H5Reader(path("b.h5"), "").text_attribute("unit"); };
  EXPECT_EQ(read(), "rad");

  const std::string good = read_file(path("b.h5"));
  const std::size_t heap = good.find("GCOL");
  ASSERT_NE(heap, std::string::npos);
  const auto error_of = [&](std::size_t at, std::string_view bytes) {
    std::string damaged = good;
    write("b.h5", damaged.replace(heap + at, bytes.size(), bytes));
    return message_of([&] { read(); });
  };
  const std::string newer = "b.h5: attribute unit is missing or not a text";
  EXPECT_THAT(error_of(24, "\xff\xff\xff\xff\xff\xff\xff\x27"),
              testing::AnyOf("b.h5: damaged: the HDF5 library crashes on it", newer));
  EXPECT_THAT(error_of(16, std::string(16, '\0')),
              testing::AnyOf("b.h5: damaged: the HDF5 library reads it for more than 1 s", newer));
}

class McapLimits : public FolderTest {};

TEST_F(McapLimits, ChunksAreRefusedByWhatTheySay) {
  const auto error_of = [&](std::uint64_t size, int count) {
    const std::string content = ByteWriter()
                                    .number(std::uint64_t{0})
                                    .number(std::uint64_t{0})
                                    .number(size)
                                    .number(std::uint32_t{0})
                                    .text("zstd")
                                    .number(std::uint64_t{0})
                                    .bytes();
    const std::string chunk = ByteWriter()
                                  .number(std::uint8_t{6})
                                  .number(static_cast<std::uint64_t>(content.size()))
                                  .raw(content)
                                  .bytes();
    const auto contract = load_contract(write("contract.toml", mcap_sample(Recording(2)).contract));
    const auto log = write("log.mcap", "\x89MCAP0\r\n" + repeated(chunk, count));
    return message_of([&] { import_log(log, contract); });
  };
  constexpr std::uint64_t kMost = std::uint64_t{1} << 30;
  EXPECT_EQ(error_of(kMost + 1, 1),
            "log.mcap: 1073741825 bytes in one chunk of an MCAP file; allowed: up to 1073741824");
  EXPECT_EQ(
      error_of(kMost, 17),
      "log.mcap: 18253611008 bytes in all chunks of an MCAP file; allowed: up to 17179869184");
  EXPECT_EQ(error_of(1, 1), "log.mcap: damaged: a chunk gives 0 of 1 bytes");
}

}  // namespace
}  // namespace fricid::data
