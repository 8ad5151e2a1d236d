// Where an unfinished fit stands, as a file: the same command goes on from it after a kill.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fricid::estimate {

/// All that an iterative fit carries from one iteration to the next: coordinates, moments, noise,
/// the best met, histories, the index of the next random draw, each a list of numbers by its name.
struct FitState {
  int iteration = 0;  ///< finished ones
  std::map<std::string, std::vector<double>> numbers;
  std::vector<std::string> warnings;

  bool operator==(const FitState&) const = default;
};

/// Keeps the state of one fit in a file, or nowhere. Numbers come back to the last bit, so a fit
/// that goes on ends in the bytes of one that was never killed.
class Checkpoint {
 public:
  /// Nowhere: loads nothing, saves nothing.
  Checkpoint() = default;
  /// @param key  of everything that the fit depends on: another fit's state is not taken
  Checkpoint(std::filesystem::path path, std::string key);

  /// The state saved last; nothing without a file, or when it is of another key.
  std::optional<FitState> load() const;
  /// Written atomically. @throws UserError when it cannot be written
  void save(const FitState& state) const;
  /// To be called when the fit is done: removes the file, and its folder when that is empty.
  void remove() const;

 private:
  std::filesystem::path path_;
  std::string key_;
};

}  // namespace fricid::estimate
