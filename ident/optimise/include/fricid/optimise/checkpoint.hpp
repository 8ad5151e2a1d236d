// State of an unfinished search as a file, from which the same command continues.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fricid::optimise {

/// Named lists of numbers and of texts.
struct Record {
  std::map<std::string, std::vector<double>> numbers;
  std::map<std::string, std::vector<std::string>> texts;

  bool operator==(const Record&) const = default;
};

/// Writes the fields that `visit(archive)` of a state names into a record: numbers, vectors, texts,
/// and lists of structs with a `visit` of their own, a column "list.field" for each field.
class RecordWriter {
 public:
  explicit RecordWriter(Record& record) : record_(record) {}

  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void operator()(std::string_view name, const T& value) {
    record_.numbers[prefix_ + std::string(name)].push_back(static_cast<double>(value));
  }
  void operator()(std::string_view name, const Eigen::VectorXd& values) {
    record_.numbers[prefix_ + std::string(name)] = {values.begin(), values.end()};
  }
  void operator()(std::string_view name, const std::vector<std::string>& texts) {
    record_.texts[prefix_ + std::string(name)] = texts;
  }
  template <class T>
  requires requires(T& row, RecordWriter& archive) { row.visit(archive); }
  void operator()(std::string_view name, std::vector<T>& rows) {
    const std::string outer = prefix_;
    operator()(std::string(name) + ".rows", rows.size());
    prefix_ += std::string(name) + ".";
    for (T& row : rows) row.visit(*this);
    prefix_ = outer;
  }

 private:
  Record& record_;
  std::string prefix_;
};

/// Reads a record back into a state.
/// @throws std::out_of_range when a visited name is missing, a whole number does not fit its type,
///         or a vector differs in size from that of the state
class RecordReader {
 public:
  explicit RecordReader(const Record& record) : record_(record) {}

  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void operator()(std::string_view name, T& value) {
    const double number = record_.numbers.at(prefix_ + std::string(name)).at(row_);
    if constexpr (std::integral<T>)
      if (!(number >= static_cast<double>(std::numeric_limits<T>::min()) &&
            number < std::ldexp(1.0, std::numeric_limits<T>::digits)))
        throw std::out_of_range(std::string(name));
    value = static_cast<T>(number);
  }
  void operator()(std::string_view name, Eigen::VectorXd& values) {
    const std::vector<double>& list = record_.numbers.at(prefix_ + std::string(name));
    if (std::ssize(list) != values.size()) throw std::out_of_range(std::string(name));
    values = Eigen::VectorXd::Map(list.data(), std::ssize(list));
  }
  void operator()(std::string_view name, std::vector<std::string>& texts) {
    texts = record_.texts.at(prefix_ + std::string(name));
  }
  template <class T>
  requires requires(T& row, RecordReader& archive) { row.visit(archive); }
  void operator()(std::string_view name, std::vector<T>& rows) {
    const std::string outer = prefix_;
    std::size_t count = 0;
    operator()(std::string(name) + ".rows", count);
    rows.clear();
    prefix_ += std::string(name) + ".";
    for (row_ = 0; row_ < count; ++row_) rows.emplace_back().visit(*this);
    row_ = 0;
    prefix_ = outer;
  }

 private:
  const Record& record_;
  std::string prefix_;
  std::size_t row_ = 0;
};

/// Saves the state of one search in a file, if it has one. Numbers are restored to the last bit, so
/// a continued search gives the same bytes as an uninterrupted one.
class Checkpoint {
 public:
  /// Without a file: loads and saves nothing.
  Checkpoint() = default;
  /// @param key  hash of everything that the search depends on; a state with another key is ignored
  Checkpoint(std::filesystem::path path, std::string key);

  /// Restores the fields that `state.visit(archive)` names. The state is unchanged if there is no
  /// file, if its key or names differ, or if the restored state has `agrees()` and it is false.
  /// @return whether the state was restored
  template <class State>
  bool load(State& state) const {
    const std::optional<Record> record = read();
    if (!record) return false;
    State taken = state;
    RecordReader archive(*record);
    try {
      taken.visit(archive);
    } catch (const std::out_of_range&) {
      return false;
    }
    if constexpr (requires { taken.agrees(); })
      if (!taken.agrees()) return false;
    state = std::move(taken);
    return true;
  }

  /// Written atomically. @throws UserError when it cannot be written
  template <class State>
  void save(State state) const {
    if (path_.empty()) return;
    Record record;
    RecordWriter archive(record);
    state.visit(archive);
    write(record);
  }

  /// Removes the file, and its folder if that is empty. To be called when the search is done.
  void remove() const;

 private:
  std::optional<Record> read() const;
  void write(const Record& record) const;

  std::filesystem::path path_;
  std::string key_;
};

}  // namespace fricid::optimise
