// One short recording written in every format that can be read, with its contract.
#pragma once

#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "fricid/data/dataset.hpp"

namespace fricid::data {

/// A format's files (name, content; the first is the log) and its contract.
struct LogSample {
  std::string format;
  std::vector<std::pair<std::string, std::string>> files;
  std::string contract;
};

/// T samples of two joints, "shoulder" and "elbow", 250 Hz. Numbers with few digits, so that text
/// keeps them.
struct Recording {
  RowMatrix q, v, tau;  // [rad], [rad/s], [N m]
  explicit Recording(int T) : q(T, 2), v(T, 2), tau(T, 2) {
    for (int k = 0; k < T; ++k)
      for (int j = 0; j < 2; ++j) {
        const double phase = 0.02 * k * (j + 1);
        q(k, j) = std::round(1e6 * std::sin(phase)) / 1e6;
        v(k, j) = std::round(1e6 * 5 * (j + 1) * std::cos(phase)) / 1e6;
        tau(k, j) = std::round(1e4 * (3 * std::cos(phase) + j)) / 1e4;
      }
  }
  int length() const { return static_cast<int>(q.rows()); }
};

inline constexpr char kJoints[] = "joint_names = [\"shoulder\", \"elbow\"]\n";
inline constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

/// Little-endian bytes.
class ByteWriter {
 public:
  template <class T>
  ByteWriter& number(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    text_.append(bytes, sizeof(T));
    return *this;
  }
  ByteWriter& text(const std::string& value, bool terminated = false) {
    number(static_cast<std::uint32_t>(value.size() + (terminated ? 1 : 0)));
    text_ += value;
    if (terminated) text_ += '\0';
    return *this;
  }
  ByteWriter& raw(const std::string& value) {
    text_ += value;
    return *this;
  }
  ByteWriter& align(std::size_t size) {
    while (text_.size() % size != 0) text_ += '\0';
    return *this;
  }
  const std::string& bytes() const { return text_; }

 private:
  std::string text_;
};

inline LogSample csv_sample(const Recording& r) {
  std::string text = "t,q1,q2,dq1,dq2,tau1,tau2\n";
  for (int k = 0; k < r.length(); ++k)
    text += fmt::format("{:.3f},{},{},{},{},{},{}\n", 0.004 * k, r.q(k, 0), r.q(k, 1), r.v(k, 0),
                        r.v(k, 1), r.tau(k, 0), r.tau(k, 1));
  return {"csv",
          {{"log.csv", text}},
          std::string(kJoints) +
              "[position]\ncolumns = \"q{}\"\n[velocity]\ncolumns = \"dq{}\"\n[torque]\n"
              "columns = \"tau{}\"\n"};
}

inline LogSample german_csv_sample(const Recording& r) {
  std::string text = "Zeit[ms];Winkel 1 [\xB0];Winkel 2 [\xB0];Moment 1;Moment 2\n";  // ISO 8859-1
  const auto comma = [](double value) {
    std::string number = fmt::format("{:.15g}", value);
    for (char& c : number)
      if (c == '.') c = ',';
    return number;
  };
  for (int k = 0; k < r.length(); ++k)
    text += fmt::format("{};{};{};{};{}\n", 4 * k, comma(kDegreesPerRadian * r.q(k, 0)),
                        comma(-kDegreesPerRadian * r.q(k, 1)), comma(r.tau(k, 0) / 100),
                        comma(r.tau(k, 1) / 50));
  return {"german_csv",
          {{"log.txt", text}},
          std::string(kJoints) +
              "format = \"csv\"\ndecimal_comma = true\ngear_ratio = [100, 50]\n"
              "[time]\ncolumn = \"Zeit[ms]\"\nunit = \"ms\"\n"
              "[position]\ncolumns = \"Winkel {} [°]\"\nunit = \"deg\"\nsign = [1, -1]\n"
              "[torque]\ncolumns = \"Moment {}\"\nkind = \"motor_torque\"\n"};
}

inline constexpr char kCurrentContract[] =
    "gear_ratio = [100, 50]\n[torque]\ncolumns = \"MACur.A{}\"\nkind = \"current\"\n"
    "torque_constant = [0.5, 0.25]\n";

inline LogSample rsi_xml_sample(const Recording& r) {
  std::string text;
  for (int k = 0; k < r.length(); ++k)
    text += fmt::format(
        "<Rob Type=\"KUKA\"><Dat TaskType=\"b\"><ComStatus>continuous</ComStatus>"
        "<RIst X=\"93.9\" Y=\"1\" Z=\"2\" A=\"0\" B=\"0\" C=\"0\"/><AIPos A1=\"{:.15g}\" "
        "A2=\"{:.15g}\"/>"
        "<MACur A1=\"{:.15g}\" A2=\"{:.15g}\"/><Delay D=\"0\"/><IPOC>{}</IPOC></Dat></Rob>\n"
        "<Sen Type=\"ImFree\"><IPOC>{}</IPOC></Sen>\n",
        kDegreesPerRadian * r.q(k, 0), kDegreesPerRadian * r.q(k, 1), r.tau(k, 0) / 50,
        r.tau(k, 1) / 12.5, 680309708 + 4 * k, 680309708 + 4 * k);
  return {"rsi_xml",
          {{"log.xml", text}},
          std::string(kJoints) + "format = \"rsi_xml\"\n" + kCurrentContract};
}

inline LogSample rsi_csv_sample(const Recording& r) {
  std::string text =
      "Timestamp,Receive.IPOC,Receive.AIPos.A1,Receive.AIPos.A2,Receive.MaCur.A1,Receive.MaCur."
      "A2\n";
  for (int k = 0; k < r.length(); ++k)
    text += fmt::format("2026-01-01 10:00:00.{:03d},{},{:.15g},{:.15g},{:.15g},{:.15g}\n",
                        4 * k % 1000, 680309708 + 4 * k, kDegreesPerRadian * r.q(k, 0),
                        kDegreesPerRadian * r.q(k, 1), r.tau(k, 0) / 50, r.tau(k, 1) / 12.5);
  return {"rsi_csv",
          {{"log.csv", text}},
          std::string(kJoints) + "format = \"rsi_csv\"\n" + kCurrentContract};
}

/// Two drives, each with motor angle and torque.
inline LogSample kuka_trace_sample(const Recording& r) {
  LogSample sample{"kuka_trace",
                   {},
                   std::string(kJoints) +
                       "format = \"kuka_trace\"\n"
                       "gear_ratio = [100, 50]\n[position]\ncolumns = []\nsign = [1, -1]\n"
                       "[torque]\ncolumns = \"Istmoment{}\"\nkind = \"motor_torque\"\n"};
  for (int j = 0; j < 2; ++j) {
    const std::string stem = fmt::format("PC - 4711_test_NextGenDrive#{}", j + 1);
    std::string header =
        "DIAEXTENDED  {@:ENGLISH\r\n#BEGINGLOBALHEADER\r\n102,#KR3R540 C4SR\r\n"
        "104,01.02.2026\r\n#ENDGLOBALHEADER\r\n";
    const auto channel = [&](const char* name, const char* unit, const char* kind, int column,
                             double factor) {
      header += fmt::format(
          "#BEGINCHANNELHEADER\r\n200,{}\r\n202,{}\r\n210,{}\r\n220,{}\r\n{}240,0\r\n241,{}\r\n"
          "#ENDCHANNELHEADER\r\n",
          name, unit, kind, r.length(),
          column ? fmt::format("213,BLOCK\r\n214,REAL64\r\n221,{}\r\n", column) : "", factor);
    };
    channel("Zeit", "s", "IMPLIZIT", 0, 0.004);
    channel("Istposition", "\xB0", "EXPLIZIT", 1, 1e-6);
    channel("Istmoment", "Nm", "EXPLIZIT", 2, 0.001);
    ByteWriter raw;
    const double gear = j == 0 ? 100 : -50;
    for (int k = 0; k < r.length(); ++k)
      raw.number(1e6 * kDegreesPerRadian * gear * r.q(k, j))
          .number(1e3 * r.tau(k, j) / std::abs(gear));
    sample.files.push_back({stem + ".dat", header});
    sample.files.push_back({stem + ".r64", raw.bytes()});
  }
  return sample;
}

inline LogSample ur_csv_sample(const Recording& r) {
  std::string text =
      "timestamp actual_q_0 actual_q_1 actual_qd_0 actual_qd_1 actual_current_0 actual_current_1\n";
  for (int k = 0; k < r.length(); ++k)
    text += fmt::format("{:.3f} {} {} {} {} {:.15g} {:.15g}\n", 1000 + 0.004 * k, r.q(k, 0),
                        r.q(k, 1), r.v(k, 0), r.v(k, 1), r.tau(k, 0) / 10, r.tau(k, 1) / 10);
  return {"ur_csv",
          {{"log.csv", text}},
          std::string(kJoints) +
              "format = \"ur_csv\"\ngear_ratio = 100\n[torque]\ncolumns = \"actual_current_{0}\"\n"
              "kind = \"current\"\ntorque_constant = 0.1\n"};
}

inline LogSample franka_csv_sample(const Recording& r) {
  std::string text =
      "time, success_rate, state.q[0], state.q[1],state.dq[0], state.dq[1],state.tau_J[0], "
      "state.tau_J[1]\n";
  for (int k = 0; k < r.length(); ++k)
    text += fmt::format("{},1,{},{},{},{},{},{}\n", 4 * k, r.q(k, 0), r.q(k, 1), r.v(k, 0),
                        r.v(k, 1), r.tau(k, 0), r.tau(k, 1));
  return {"franka_csv",
          {{"log.csv", text}},
          std::string(kJoints) +
              "format = \"franka_csv\"\n[torque]\ncolumns = \"state.tau_J[{0}]\"\nkind = "
              "\"link_torque\"\n"};
}

/// @param compression  written into the chunk, which is not compressed all the same
/// As "zstd" or "lz4" stores it; as it is for any other name.
inline std::string compressed(const std::string& text, const std::string& how) {
  std::string stored;
  if (how == "zstd") {
    stored.resize(ZSTD_compressBound(text.size()));
    stored.resize(ZSTD_compress(stored.data(), stored.size(), text.data(), text.size(), 3));
  } else if (how == "lz4") {
    stored.resize(LZ4F_compressFrameBound(text.size(), nullptr));
    stored.resize(
        LZ4F_compressFrame(stored.data(), stored.size(), text.data(), text.size(), nullptr));
  } else {
    stored = text;
  }
  return stored;
}

/// An element of a MAT-file.
inline std::string mat_element(std::uint32_t type, const std::string& content) {
  return ByteWriter()
      .number(type)
      .number(static_cast<std::uint32_t>(content.size()))
      .raw(content)
      .align(8)
      .bytes();
}
/// An array of a MAT-file: class, dimensions, name, and what a class has beyond that.
inline std::string mat_array(std::uint32_t of_class, const std::vector<std::int32_t>& sides,
                             const std::string& name, const std::string& rest) {
  ByteWriter dimensions;
  for (const std::int32_t side : sides) dimensions.number(side);
  return mat_element(
      14, mat_element(6, ByteWriter().number(of_class).number(std::uint32_t{0}).bytes()) +
              mat_element(5, dimensions.bytes()) + mat_element(1, name) + rest);
}
/// An array of doubles, T x columns.
inline std::string mat_doubles(const std::string& name, const Eigen::MatrixXd& values) {
  ByteWriter numbers;
  for (const double value : values.reshaped()) numbers.number(value);
  return mat_array(
      6, {static_cast<std::int32_t>(values.rows()), static_cast<std::int32_t>(values.cols())}, name,
      mat_element(9, numbers.bytes()));
}
/// An array as MATLAB's save -v7 stores it.
inline std::string mat_compressed(const std::string& array) {
  uLongf size = compressBound(array.size());
  std::string stored(size, '\0');
  compress(reinterpret_cast<Bytef*>(stored.data()), &size,
           reinterpret_cast<const Bytef*>(array.data()), array.size());
  return ByteWriter()
      .number(std::uint32_t{15})
      .number(static_cast<std::uint32_t>(size))
      .raw(stored.substr(0, size))
      .bytes();
}
inline std::string mat_file(const std::string& elements) {
  std::string header = "MATLAB 5.0 MAT-file, by hand";
  header.resize(124, ' ');
  return header + std::string("\0\1IM", 4) + elements;
}

/// @param compress  by zlib, as save -v7
inline LogSample mat_sample(const Recording& r, bool compress) {
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(r.length(), 0, 0.004 * (r.length() - 1));
  std::string elements;
  for (const std::string& array : {mat_doubles("t", t), mat_doubles("q", r.q),
                                   mat_doubles("dq", r.v), mat_doubles("tau", r.tau)})
    elements += compress ? mat_compressed(array) : array;
  return {"mat",
          {{"log.mat", mat_file(elements)}},
          std::string(kJoints) +
              "format = \"mat\"\n[velocity]\ncolumns = \"dq{}\"\n[torque]\ncolumns = "
              "\"tau{}\"\n"};
}

/// sensor_msgs/msg/JointState as CDR.
struct JointStateSample {
  long long nanosec;  ///< after the first message's second
  std::vector<std::string> names;
  std::vector<double> q, v, tau;
};
inline std::string joint_state_message(const JointStateSample& state) {
  ByteWriter cdr;
  cdr.number(static_cast<std::int32_t>(1'700'000'000 + state.nanosec / 1'000'000'000))
      .number(static_cast<std::uint32_t>(state.nanosec % 1'000'000'000))
      .text("", true)
      .align(4)
      .number(static_cast<std::uint32_t>(state.names.size()));
  for (const std::string& name : state.names) cdr.align(4).text(name, true);
  for (const std::vector<double>* x : {&state.q, &state.v, &state.tau}) {
    cdr.align(4).number(static_cast<std::uint32_t>(x->size()));
    if (!x->empty()) cdr.align(8);
    for (const double value : *x) cdr.number(value);
  }
  return std::string("\0\1\0\0", 4) + cdr.bytes();
}

inline long long nanosec_of(int k) { return 999'000'000LL + 4'000'000LL * k; }

/// Sample k. Drivers do not promise the order of joints.
inline JointStateSample joint_state(const Recording& r, int k) {
  return {nanosec_of(k),
          {"elbow", "shoulder"},
          {r.q(k, 1), r.q(k, 0)},
          {r.v(k, 1), r.v(k, 0)},
          {r.tau(k, 1), r.tau(k, 0)}};
}
inline std::string joint_state_message(const Recording& r, int k) {
  return joint_state_message(joint_state(r, k));
}

inline LogSample mcap_sample(const Recording& r, const std::string& compression = "") {
  const auto record = [](int opcode, const std::string& content) {
    return ByteWriter()
        .number(static_cast<std::uint8_t>(opcode))
        .number(static_cast<std::uint64_t>(content.size()))
        .raw(content)
        .bytes();
  };
  std::string messages;
  for (int k = 0; k < r.length(); ++k) {
    messages += record(0x05, ByteWriter()
                                 .number(std::uint16_t{7})
                                 .number(static_cast<std::uint32_t>(k))
                                 .number(std::uint64_t{0})
                                 .number(std::uint64_t{0})
                                 .raw(joint_state_message(r, k))
                                 .bytes());
  }
  const std::string schema = record(0x03, ByteWriter()
                                              .number(std::uint16_t{3})
                                              .text("sensor_msgs/msg/JointState")
                                              .text("ros2msg")
                                              .text("")
                                              .bytes());
  const std::string channel = record(0x04, ByteWriter()
                                               .number(std::uint16_t{7})
                                               .number(std::uint16_t{3})
                                               .text("/joint_states")
                                               .text("cdr")
                                               .text("")
                                               .bytes());
  const std::string records = schema + channel + messages,
                    stored = compressed(records, compression);
  const std::string chunk = record(0x06, ByteWriter()
                                             .number(std::uint64_t{0})
                                             .number(std::uint64_t{0})
                                             .number(static_cast<std::uint64_t>(records.size()))
                                             .number(std::uint32_t{0})
                                             .text(compression)
                                             .number(static_cast<std::uint64_t>(stored.size()))
                                             .raw(stored)
                                             .bytes());
  const std::string magic("\x89MCAP0\r\n", 8);
  const std::string header = record(0x01, ByteWriter().text("ros2").text("fricid").bytes());
  const std::string footer = record(0x02, std::string(20, '\0'));
  return {"mcap",
          {{"log.mcap", magic + header + chunk + footer + magic}},
          std::string(kJoints) + "format = \"mcap\"\n[torque]\ncolumns = \"effort.{name}\"\n"};
}

/// An SQLite database in memory, which can be had as the bytes of a file.
class Database {
 public:
  Database() {
    sqlite3_open(":memory:", &db_);
    run("PRAGMA page_size = 512");
  }
  ~Database() { sqlite3_close(db_); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  Database& run(const std::string& sql) {
    char* error = nullptr;
    sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, &error);
    if (error) throw std::runtime_error(sql + ": " + error);
    return *this;
  }
  std::string bytes() {
    sqlite3_int64 size = 0;
    unsigned char* copy = sqlite3_serialize(db_, "main", &size, 0);
    std::string all(reinterpret_cast<const char*>(copy), static_cast<std::size_t>(size));
    sqlite3_free(copy);
    return all;
  }

 private:
  sqlite3* db_ = nullptr;
};

/// Text of an SQL literal for bytes.
inline std::string blob_literal(const std::string& bytes) {
  std::string hex;
  for (const char c : bytes) hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return "x'" + hex + "'";
}

/// The tables of a ROS 2 bag, with camera images beside the joint states.
inline void write_bag(Database& bag, const std::vector<JointStateSample>& messages) {
  bag.run(
         "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
         " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)")
      .run(
          "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
          " timestamp INTEGER NOT NULL, data BLOB NOT NULL)")
      .run("CREATE INDEX timestamp_idx ON messages (timestamp ASC)")
      .run("INSERT INTO topics VALUES (1, '/image', 'sensor_msgs/msg/Image', 'cdr', '')")
      .run(
          "INSERT INTO topics VALUES (2, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr', "
          "'')");
  for (const JointStateSample& state : messages)
    bag.run(fmt::format(
        "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, {0}, x'00'),"
        " (2, {0}, {1})",
        1'700'000'000'000'000'000LL + state.nanosec, blob_literal(joint_state_message(state))));
}
inline void write_bag(Database& bag, const Recording& r) {
  std::vector<JointStateSample> messages;
  for (int k = 0; k < r.length(); ++k) messages.push_back(joint_state(r, k));
  write_bag(bag, messages);
}

inline LogSample db3_sample(const Recording& r) {
  Database bag;
  write_bag(bag, r);
  return {"db3",
          {{"log.db3", bag.bytes()}},
          std::string(kJoints) + "format = \"db3\"\n[torque]\ncolumns = \"effort.{name}\"\n"};
}

/// Every format that is written by hand; HDF5 has a writer of its own.
inline std::vector<LogSample> log_samples(int length) {
  const Recording r(length);
  return {csv_sample(r),          german_csv_sample(r),  rsi_xml_sample(r),    rsi_csv_sample(r),
          kuka_trace_sample(r),   ur_csv_sample(r),      franka_csv_sample(r), mcap_sample(r),
          mcap_sample(r, "zstd"), mcap_sample(r, "lz4"), db3_sample(r),        mat_sample(r, false),
          mat_sample(r, true)};
}

}  // namespace fricid::data
