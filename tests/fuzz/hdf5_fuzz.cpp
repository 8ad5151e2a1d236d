// libFuzzer target: every reader of HDF5 files. The last byte chooses the reader. The bytes are a
// file under a checksum that fits, if the first is 0; else the library writes one as they say:
// names, types, shapes, layouts and links of any kind.
#include <fuzzer/FuzzedDataProvider.h>
#include <hdf5.h>

#include <array>
#include <functional>

#include "fricid/base/files.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/estimate_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"
#include "fricid/sim/truth.hpp"
#include "target.hpp"

namespace {

using namespace fricid;

constexpr char kFile[] = "file.h5";
constexpr std::size_t kHeader = 512;

/// Bytes after the header, and the header that belongs to them.
void write_sealed(std::string_view rest) {
  std::string file =
      fmt::format("fricid.dataset/1\nsha256 from byte {} on: {}\n", kHeader, sha256_of_text(rest));
  file.resize(kHeader, '\0');
  fuzz::write(kFile, file.append(rest));
}

/// A file that the library writes; what it refuses to write is left out.
class Builder {
 public:
  explicit Builder(FuzzedDataProvider& bytes)
      : bytes_(bytes), file_(H5Fcreate(kFile, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {}
  ~Builder() { H5Fclose(file_); }
  Builder(const Builder&) = delete;
  Builder& operator=(const Builder&) = delete;

  void fill() {
    good_file();
    for (int changes = bytes_.ConsumeIntegralInRange(0, 6); changes > 0; --changes) change();
  }

 private:
  /// Signals of two joints that every reader would take.
  void good_file() {
    text_attribute(
        file_, "format",
        pick<const char*>({"fricid.dataset/1", "fricid.truth/1", "fricid.rollout/1",
                           "fricid.prediction/1", "fricid.band/1", "fricid.estimate/1"}));
    texts_attribute(file_, "joint_names", {"shoulder", "elbow"});
    number_attribute(file_, "rate_hz", 100);
    text_attribute(file_, "source", "fuzz");
    text_attribute(
        file_, "friction",
        R"({"joints":[{"laws":[]},{"laws":[{"elements":0,"law":"coulomb_viscous","modifiers":[],)"
        R"("parameters":[{"owner":"","symbol":"","unit":"","value":1.0},{"owner":"","symbol":"",)"
        R"("unit":"","value":1.0},{"owner":"","symbol":"","unit":"","value":0.01}]}]}]})");
    for (const auto& [name, unit] : kTables) {
      const bool column =
          std::string_view(name) == "t" || *name == 'l' || std::string_view(name) == "ess";
      const std::vector<hsize_t> shape =
          column ? std::vector<hsize_t>{4} : std::vector<hsize_t>{4, *name == 'z' ? 0u : 2u};
      table(name, unit, H5T_NATIVE_DOUBLE, shape, [](hid_t) {});
    }
  }

  void change() {
    const std::string name = any_name();
    if (bytes_.ConsumeBool()) H5Ldelete(file_, name.c_str(), H5P_DEFAULT);
    switch (bytes_.ConsumeIntegralInRange(0, 7)) {
      case 0:
        H5Adelete(file_, any_attribute().c_str());
        attribute(file_, any_attribute());
        break;
      case 1: {
        const hid_t object = H5Oopen(file_, name.c_str(), H5P_DEFAULT);
        H5Adelete(object, "unit");
        attribute(object, "unit");
        H5Oclose(object);
        break;
      }
      case 2:
        H5Lcreate_soft(any_name().c_str(), file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        break;
      case 3:
        H5Lcreate_external(bytes_.ConsumeBool() ? kFile : "none", any_name().c_str(), file_,
                           name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        break;
      case 4:
        H5Gclose(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        break;
      default: {
        const std::vector<hsize_t> shape = any_shape();
        table(name, "rad", any_type(), shape, [&](hid_t properties) { layout(properties, shape); });
      }
    }
  }

  template <class Set>
  void table(const std::string& name, const char* unit, hid_t type,
             const std::vector<hsize_t>& shape, Set set) {
    const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    set(properties);
    const hid_t table =
        H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    double count = 1;
    for (const hsize_t extent : shape) count *= static_cast<double>(extent);
    if (table >= 0 && count <= 64 && H5Tget_class(type) == H5T_FLOAT) {
      std::array<double, 64> values{};
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = name == "t" ? 0.01 * static_cast<double>(i)
                    : bytes_.ConsumeProbability<double>() < 0.9
                        ? 0.1 * static_cast<double>(i)
                        : pick<double>({NAN, INFINITY, 1e300, -1e300, 1e-320});
      H5Dwrite(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    }
    if (table >= 0) text_attribute(table, "unit", unit);
    H5Dclose(table);
    H5Pclose(properties);
    H5Sclose(space);
  }

  void layout(hid_t properties, const std::vector<hsize_t>& shape) {
    switch (bytes_.ConsumeIntegralInRange(0, 5)) {
      case 0:
        H5Pset_layout(properties, H5D_COMPACT);
        break;
      case 1: {
        std::vector<hsize_t> chunk(shape.size());
        for (hsize_t& extent : chunk) extent = pick<hsize_t>({1, 2, 1024, 1 << 20, 1 << 28});
        H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
        if (bytes_.ConsumeBool()) H5Pset_deflate(properties, 1);
        if (bytes_.ConsumeBool()) H5Pset_shuffle(properties);
        break;
      }
      case 2:
        H5Pset_external(properties, bytes_.ConsumeBool() ? "/dev/zero" : kFile, 0, H5F_UNLIMITED);
        break;
      case 3: {
        const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
        H5Pset_virtual(properties, space, pick({".", kFile, "none"}), any_name().c_str(), space);
        H5Sclose(space);
        break;
      }
      default:
        break;
    }
  }

  hid_t any_type() {
    switch (bytes_.ConsumeIntegralInRange(0, 9)) {
      case 0:
        return H5T_NATIVE_FLOAT;
      case 1:
        return H5T_STD_I8LE;
      case 2:
        return H5T_STD_U64BE;
      case 3: {
        const hid_t type = H5Tcopy(H5T_C_S1);
        H5Tset_size(type, bytes_.ConsumeBool() ? H5T_VARIABLE : 5);
        return type;
      }
      case 4: {
        const hid_t type = H5Tcreate(H5T_COMPOUND, 16);
        H5Tinsert(type, "x", 0, H5T_NATIVE_DOUBLE);
        return type;
      }
      case 5: {
        const hsize_t extent = 3;
        return H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &extent);
      }
      case 6: {
        const hid_t type = H5Tcopy(H5T_STD_I64LE);
        H5Tset_size(type, pick<std::size_t>({3, 16, 4096}));
        return type;
      }
      case 7:
        return H5T_STD_REF_OBJ;
      case 8:
        return H5Tvlen_create(H5T_NATIVE_DOUBLE);
      default:
        return H5T_NATIVE_DOUBLE;
    }
  }

  std::vector<hsize_t> any_shape() {
    std::vector<hsize_t> shape(bytes_.ConsumeIntegralInRange<std::size_t>(0, 4));
    for (hsize_t& extent : shape)
      extent = pick<hsize_t>({0, 1, 2, 3, 4, 4, 4, 1 << 20, hsize_t{1} << 40, hsize_t{1} << 62});
    return shape;
  }

  /// An attribute of any type.
  void attribute(hid_t object, const std::string& name) {
    switch (bytes_.ConsumeIntegralInRange(0, 4)) {
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
      default: {
        const std::vector<hsize_t> shape = any_shape();
        const hid_t space = bytes_.ConsumeBool() ? H5Screate(H5S_NULL)
                                                 : H5Screate_simple(static_cast<int>(shape.size()),
                                                                    shape.data(), nullptr);
        H5Aclose(H5Acreate2(object, name.c_str(), any_type(), space, H5P_DEFAULT, H5P_DEFAULT));
        H5Sclose(space);
      }
    }
  }

  static void text_attribute(hid_t object, const std::string& name, const std::string& text) {
    const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    H5Tset_size(type, text.size() + 1);
    const hid_t attribute = H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, text.c_str());
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
  }

  static void texts_attribute(hid_t object, const std::string& name,
                              const std::vector<std::string>& texts) {
    std::vector<const char*> pointers;
    for (const std::string& text : texts) pointers.push_back(text.c_str());
    const hsize_t count = texts.size();
    const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate_simple(1, &count, nullptr);
    H5Tset_size(type, H5T_VARIABLE);
    const hid_t attribute = H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (count > 0) H5Awrite(attribute, type, pointers.data());
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
  }

  static void number_attribute(hid_t object, const std::string& name, double value) {
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute =
        H5Acreate2(object, name.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value);
    H5Aclose(attribute);
    H5Sclose(space);
  }

  std::string any_name() {
    const std::size_t i = bytes_.ConsumeIntegralInRange<std::size_t>(0, kTables.size());
    return i < kTables.size() ? kTables[i].first : bytes_.ConsumeRandomLengthString(12);
  }
  std::string any_attribute() {
    return pick<const char*>({"format", "joint_names", "rate_hz", "source", "friction"});
  }
  template <class T>
  T pick(std::initializer_list<T> values) {
    return values.begin()[bytes_.ConsumeIntegralInRange<std::size_t>(0, values.size() - 1)];
  }

  static constexpr std::array<std::pair<const char*, const char*>, 17> kTables{
      {{"t", "s"},
       {"q", "rad"},
       {"v", "rad/s"},
       {"a", "rad/s^2"},
       {"tau", "N m"},
       {"tau_f", "N m"},
       {"tau_predicted", "N m"},
       {"temperature", "K"},
       {"z", "law's own"},
       {"q_low", "rad"},
       {"q_high", "rad"},
       {"q_sd", "rad"},
       {"v_sd", "rad/s"},
       {"tau_f_sd", "N m"},
       {"z_sd", "1"},
       {"log_likelihood", "1"},
       {"ess", "1"}}};

  FuzzedDataProvider& bytes_;
  hid_t file_;
};

/// What `fricid info` looks at, and one kind of signals: opening is what takes the time.
void read_as(int kind) {
  const auto read = [](auto reader) { return fuzz::reads({kFile}, reader); };
  const bool opens = read([] {
    const data::H5Reader file(kFile, "");
    for (const std::string& name : file.names()) {
      file.shape(name);
      fuzz::reads({kFile}, [&] { file.unit(name); });
      fuzz::reads({kFile}, [&] { file.matrix(name); });
    }
  });
  if (!opens) return;
  const std::array<std::function<void()>, 8> readers{
      [] { data::hdf5_format(kFile); },
      [] { data::load_dataset(kFile); },
      [] { sim::load_truth(kFile); },
      [] { data::load_signals<evaluate::RolloutSignals>(kFile, 2); },
      [] { evaluate::load_prediction(kFile, 2); },
      [] { evaluate::load_band(kFile, 2); },
      [] { data::load_signals<data::EstimateSignals>(kFile); },
      [] {
        data::Contract contract = data::load_contract("contract.toml");
        data::read_log(kFile, contract);
      }};
  read(readers[static_cast<std::size_t>(kind) % readers.size()]);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const fuzz::Folder folder;
  static const bool beside = [] {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    fuzz::write("contract.toml",
                "joint_names = [\"shoulder\", \"elbow\"]\n[position]\ncolumns = \"q{}\"\n"
                "[torque]\ncolumns = \"tau{}\"\n");
    return true;
  }();
  (void)beside;
  if (size == 0) return 0;
  if (data[0] == 0) {
    write_sealed(fuzz::text_of(data + 1, size - 1));
  } else {
    FuzzedDataProvider bytes(data + 1, size - 1);
    Builder(bytes).fill();
  }
  read_as(data[size - 1]);
  return 0;
}
