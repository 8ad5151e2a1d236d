// libFuzzer target: every reader of HDF5 files. Byte 1 chooses the reader. If byte 0 is 0, those
// that follow are a file, under a checksum that fits; else they say how the library changes a good
// file: names, types, shapes, layouts and links of any kind. A file on which the library crashes or
// turns in circles is left to the tests of `try_to_read`.
#include <fuzzer/FuzzedDataProvider.h>
#include <hdf5.h>
#include <pthread.h>
#include <sanitizer/common_interface_defs.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/processes.hpp"
#include "fricid/data/contract.hpp"
#include "good_signals.hpp"
#include "hdf5_library.hpp"
#include "hdf5_trial.hpp"
#include "target.hpp"

namespace {

using namespace fricid;
using data::hdf5::Id;
using Shape = std::vector<hsize_t>;

constexpr char kFile[] = "file.h5", kAgain[] = "again.h5";
constexpr std::size_t kHeader = 512;
constexpr std::chrono::milliseconds kPatience{20};  // of the processor, for some kB

/// Bytes after the header, and the header that belongs to them.
void write_sealed(std::string_view rest) {
  std::string file =
      fmt::format("fricid.dataset/1\nsha256 from byte {} on: {}\n", kHeader, sha256_of_text(rest));
  file.resize(kHeader, '\0');
  fuzz::write(kFile, file.append(rest));
}

/// Changes kFile through the library; what that refuses is left out.
class Changes {
 public:
  /// @param names  of the tables of the file
  Changes(FuzzedDataProvider& bytes, const std::vector<std::string>& names)
      : bytes_(bytes), names_(names), file_(H5Fopen(kFile, H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose) {}

  void make() {
    for (int count = bytes_.ConsumeIntegralInRange(1, 6); count > 0; --count) make_one();
  }

 private:
  void make_one() {
    const std::string name = any_name();
    switch (bytes_.ConsumeIntegralInRange(0, 9)) {
      case 0:
      case 1:
        attribute(file_, pick<const char*>({"format", "joint_names", "rate_hz", "source"}));
        break;
      case 2:
        friction();
        break;
      case 3:
        attribute(Id(H5Oopen(file_, name.c_str(), H5P_DEFAULT), H5Oclose), "unit");
        break;
      case 4:
        H5Ldelete(file_, name.c_str(), H5P_DEFAULT);
        break;
      case 5:
        link(name);
        break;
      default:
        H5Ldelete(file_, name.c_str(), H5P_DEFAULT);
        table(name);
    }
  }

  void link(const std::string& from) {
    const std::string name = any_name();
    H5Ldelete(file_, name.c_str(), H5P_DEFAULT);
    switch (bytes_.ConsumeIntegralInRange(0, 3)) {
      case 0:
        H5Lcreate_soft(from.c_str(), file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        break;
      case 1:
        H5Lcreate_external(pick({kFile, "none"}), from.c_str(), file_, name.c_str(), H5P_DEFAULT,
                           H5P_DEFAULT);
        break;
      case 2:
        H5Lcreate_hard(file_, from.c_str(), file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        break;
      default:
        Id(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    }
  }

  void table(const std::string& name) {
    const Shape shape = any_shape();
    const Id type = any_type(), space = simple(shape),
             properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    layout(properties, shape);
    const Id table(
        H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT),
        H5Dclose);
    if (!table.ok()) return;
    double count = 1;
    for (const hsize_t extent : shape) count *= static_cast<double>(extent);
    std::array<double, 64> values{};
    const bool is_virtual = H5Pget_layout(properties) == H5D_VIRTUAL;  // of itself: never written
    if (count <= values.size() && H5Tget_class(type) == H5T_FLOAT && !is_virtual) {
      const double step = pick({1.0, 0.01, 0.0, -1.0});
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = step * static_cast<double>(i);
      for (int odd = bytes_.ConsumeIntegralInRange(0, 3); odd > 0; --odd)
        values[bytes_.ConsumeIntegralInRange<std::size_t>(0, values.size() - 1)] =
            pick<double>({NAN, INFINITY, 1e300, -1e300, 1e-320});
      H5Dwrite(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    }
    text_attribute(table, "unit", pick({"rad", "rad/s", "N m", "s", "1", "K", "law's own", ""}));
  }

  void layout(hid_t properties, const Shape& shape) {
    switch (bytes_.ConsumeIntegralInRange(0, 5)) {
      case 0:
        H5Pset_layout(properties, H5D_COMPACT);
        break;
      case 1: {
        Shape chunk(shape.size());
        for (hsize_t& extent : chunk) extent = pick<hsize_t>({1, 2, 1024, 1 << 20, 1 << 28});
        H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
        if (bytes_.ConsumeBool()) H5Pset_deflate(properties, 1);
        if (bytes_.ConsumeBool()) H5Pset_shuffle(properties);
        break;
      }
      case 2:
        H5Pset_external(properties, pick({"/dev/zero", kFile}), 0, H5F_UNLIMITED);
        break;
      case 3: {
        const Id space = simple(shape);
        H5Pset_virtual(properties, space, pick({".", kFile, "none"}), any_name().c_str(), space);
        break;
      }
      default:
        break;
    }
  }

  Id any_type() {
    const auto copy = [](hid_t type) { return Id(H5Tcopy(type), H5Tclose); };
    const auto of_size = [&](hid_t type, std::size_t size) {
      Id sized = copy(type);
      H5Tset_size(sized, size);
      return sized;
    };
    const hsize_t extent = 3;
    switch (bytes_.ConsumeIntegralInRange(0, 9)) {
      case 0:
        return copy(H5T_NATIVE_FLOAT);
      case 1:
        return copy(H5T_STD_I8LE);
      case 2:
        return copy(H5T_STD_U64BE);
      case 3:
        return of_size(H5T_C_S1, bytes_.ConsumeBool() ? H5T_VARIABLE : 5);
      case 4: {
        Id type(H5Tcreate(H5T_COMPOUND, 16), H5Tclose);
        H5Tinsert(type, "x", 0, H5T_NATIVE_DOUBLE);
        return type;
      }
      case 5:
        return Id(H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &extent), H5Tclose);
      case 6:
        return of_size(H5T_STD_I64LE, pick<std::size_t>({3, 16, 4096}));
      case 7:
        return copy(H5T_STD_REF_OBJ);
      case 8:
        return Id(H5Tvlen_create(H5T_NATIVE_DOUBLE), H5Tclose);
      default:
        return copy(H5T_NATIVE_DOUBLE);
    }
  }

  Shape any_shape() {
    if (bytes_.ConsumeBool()) return bytes_.ConsumeBool() ? Shape{4, 2} : Shape{4};
    Shape shape(bytes_.ConsumeIntegralInRange<std::size_t>(0, 4));
    for (hsize_t& extent : shape)
      extent = pick<hsize_t>({0, 1, 2, 3, 4, 5, 100, hsize_t{1} << 40, hsize_t{1} << 62});
    return shape;
  }

  /// Takes an attribute away, or puts one of any type in its place.
  void attribute(hid_t object, const std::string& name) {
    H5Adelete(object, name.c_str());
    switch (bytes_.ConsumeIntegralInRange(0, 5)) {
      case 0:
        return text_attribute(object, name, bytes_.ConsumeRandomLengthString(40));
      case 1: {
        std::vector<std::string> texts(bytes_.ConsumeIntegralInRange<std::size_t>(0, 4));
        for (std::string& text : texts) text = bytes_.ConsumeRandomLengthString(12);
        return texts_attribute(object, name, texts);
      }
      case 2:
        return number_attribute(object, name,
                                pick({0.0, -1.0, 1e-300, 1e300, 250.0, double{NAN}, 2e9}));
      case 3:
        return;
      default: {
        const Id type = any_type(), space = bytes_.ConsumeBool() ? Id(H5Screate(H5S_NULL), H5Sclose)
                                                                 : simple(any_shape());
        Id(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
      }
    }
  }

  /// Replaces a piece of the JSON that describes a friction.
  void friction() {
    std::string text = fuzz::kFriction;
    const auto at = bytes_.ConsumeIntegralInRange<std::size_t>(0, text.size());
    const auto length = bytes_.ConsumeIntegralInRange<std::size_t>(0, 30);
    text.replace(at, length, bytes_.ConsumeRandomLengthString(30));
    H5Adelete(file_, "friction");
    text_attribute(file_, "friction", text);
  }

  static Id simple(const Shape& shape) {
    return Id(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
  }

  static void text_attribute(hid_t object, const std::string& name, const std::string& text) {
    const Id type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
    H5Tset_size(type, text.size() + 1);
    write_attribute(object, name, type, space, text.c_str());
  }

  static void texts_attribute(hid_t object, const std::string& name,
                              const std::vector<std::string>& texts) {
    std::vector<const char*> pointers;
    for (const std::string& text : texts) pointers.push_back(text.c_str());
    const Id type(H5Tcopy(H5T_C_S1), H5Tclose), space = simple({texts.size()});
    H5Tset_size(type, H5T_VARIABLE);
    write_attribute(object, name, type, space, pointers.data());
  }

  static void number_attribute(hid_t object, const std::string& name, double value) {
    write_attribute(object, name, H5T_NATIVE_DOUBLE, Id(H5Screate(H5S_SCALAR), H5Sclose), &value);
  }

  static void write_attribute(hid_t object, const std::string& name, hid_t type, hid_t space,
                              const void* values) {
    const Id attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                       H5Aclose);
    if (attribute.ok() && H5Sget_simple_extent_npoints(space) > 0)
      H5Awrite(attribute, type, values);
  }

  std::string any_name() {
    const auto i = bytes_.ConsumeIntegralInRange<std::size_t>(0, names_.size());
    return i < names_.size() ? names_[i] : bytes_.ConsumeRandomLengthString(12);
  }
  template <class T>
  T pick(std::initializer_list<T> values) {
    return values.begin()[bytes_.ConsumeIntegralInRange<std::size_t>(0, values.size() - 1)];
  }

  FuzzedDataProvider& bytes_;
  const std::vector<std::string>& names_;
  Id file_;
};

/// A reader, and a file that it takes with the names of its tables.
struct Reader {
  std::string good;
  std::function<void()> read;
  std::vector<std::string> names = {};
};

/// Reads signals; what was read is written, and read again as it was.
template <class Signals>
std::function<void()> signals(const std::function<Signals(const char*)>& load) {
  return [load] {
    const auto written = [](const Signals& read) {
      data::save_signals(read, kAgain);
      return read_file(kAgain);
    };
    const std::string once = written(load(kFile));
    fuzz::require_same("signals", once, written(load(kAgain)));
  };
}

template <class Signals>
std::function<void()> signals(int joints) {
  return signals<Signals>(
      [joints](const char* file) { return data::load_signals<Signals>(file, joints); });
}

void read_log() {
  const data::Contract contract = data::load_contract("contract.toml");
  data::read_log(kFile, contract);
}

/// What `fricid info` looks at.
void read_info() {
  data::hdf5_format(kFile);
  const data::H5Reader file(kFile, "");
  for (const std::string& name : file.names()) {
    file.shape(name);
    fuzz::reads({kFile}, [&] { file.unit(name); });
    fuzz::reads({kFile}, [&] { file.matrix(name); });
  }
}

void read_csv() {
  data::print_tables(data::H5Reader(kFile, ""), [](const std::string&) {});
}

/// In a process forked for this file, whose library is in the state of ours: earlier files leave
/// traces in it.
bool library_reads_it() {
  TrialProcess trial(data::hdf5::read_all);
  return trial(kFile, kPatience) == Trial::kEnded;
}

/// The readers, in a folder of the process's own. Those of signals are in the order of the files.
std::vector<Reader> make_readers() {
  static const fuzz::Folder folder;
  // what crashes a process of a trial is no finding
  ::pthread_atfork(nullptr, nullptr, [] { __sanitizer_set_death_callback(nullptr); });
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  // The library keeps what it takes for each open file, half a MB, rather than have it of the
  // system.
  constexpr int kKept = 1 << 23, kDefault = 1 << 18;
  H5set_free_list_limits(kKept, kKept, kDefault, kDefault, kDefault, kDefault);
  fuzz::write("contract.toml",
              "joint_names = [\"shoulder\", \"elbow\"]\n[position]\ncolumns = \"q{}\"\n"
              "[torque]\ncolumns = \"tau{}\"\n");
  const std::array<std::string, 8> good = fuzz::good_files(kFile);
  std::vector<Reader> readers{{good[0], signals<data::Dataset>(data::load_dataset)},
                              {good[1], signals<sim::Truth>(sim::load_truth)},
                              {good[2], signals<evaluate::RolloutSignals>(2)},
                              {good[3], signals<evaluate::PredictionSignals>(2)},
                              {good[4], signals<evaluate::BandSignals>(2)},
                              {good[5], signals<data::EstimateSignals>(-1)},
                              {good[6], signals<data::LoopSignals>(2)},
                              {good[7], signals<data::ContactSignals>(-1)},
                              {good[0], read_log},
                              {good[0], read_info},
                              {good[0], read_csv}};
  for (Reader& reader : readers) {
    fuzz::write(kFile, reader.good);
    reader.names = data::H5Reader(kFile, "").names();
    reader.read();
  }
  return readers;
}

const std::vector<Reader>& readers() {
  static const std::vector<Reader> all = make_readers();
  return all;
}
const Reader& reader_of(unsigned char byte) { return readers()[byte % readers().size()]; }

/// Writes the reader's file and changes it. In a process of its own, since the library crashes on
/// some objects that it refused to write.
/// @return whether it could
bool write_changed(std::string_view input) {
  static TrialProcess trial([](const std::string& text) {
    const auto* data = reinterpret_cast<const unsigned char*>(text.data());
    const Reader& reader = reader_of(data[1]);
    fuzz::write(kFile, reader.good);
    FuzzedDataProvider bytes(data + 2, text.size() - 2);
    Changes(bytes, reader.names).make();
  });
  constexpr std::size_t kMessage = 4000;  // bytes that a trial takes
  if (trial(std::string(input.substr(0, kMessage)), kPatience) != Trial::kEnded) return false;
  write_sealed(read_file(kFile).substr(kHeader));
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  readers();
  if (size < 2) return 0;
  if (data[0] == 0) {
    write_sealed(fuzz::text_of(data + 2, size - 2));
    if (!library_reads_it()) return 0;
  } else if (!write_changed(fuzz::text_of(data, size))) {
    return 0;
  }
  fuzz::reads({kFile, "file.r64"}, reader_of(data[1]).read);  // a KUKA trace names its other file
  return 0;
}
