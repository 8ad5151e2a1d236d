// Files of signals that their readers take, of two joints and four samples.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/files.hpp"
#include "fricid/data/contact_file.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/estimate_file.hpp"
#include "fricid/data/loop_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"
#include "fricid/sim/truth.hpp"

namespace fricid::fuzz {

inline constexpr char kFriction[] =
    R"({"joints":[{"laws":[]},{"laws":[{"elements":0,"law":"coulomb_viscous","modifiers":[],)"
    R"("parameters":[{"owner":"","symbol":"","unit":"","value":1.0},{"owner":"","symbol":"",)"
    R"("unit":"","value":1.0},{"owner":"","symbol":"","unit":"","value":0.01}]}]}]})";

/// The archive that gives every field a value.
class Filler {
 public:
  void joints(std::vector<std::string>& names) { names = {"shoulder", "elbow"}; }
  void attribute(std::string_view, double& value, const Field&) { value = 100; }
  void attribute(std::string_view, std::string& value, const Field&) { value = "fuzz"; }
  void attribute_or_zero(std::string_view, double& value, const Field&) { value = 0.001; }
  template <class Value>
  void stamp(std::string_view, const Value&, const Field&) {}
  template <class Write, class Read>
  void text_attribute(std::string_view, Write&&, Read&& read, const Field&) {
    read(kFriction, "friction");
  }
  void times(Eigen::VectorXd& t) { t = Eigen::VectorXd::LinSpaced(4, 0, 0.03); }
  void column(std::string_view, Eigen::VectorXd& values, const Field&) { values.setOnes(4); }
  void of_joints(std::string_view, RowMatrix& values, const Field&) { values.setOnes(4, 2); }
  void of_joints_or_none(std::string_view, RowMatrix& values, const Field&) {
    values.setOnes(4, 2);
  }
  void of_states(std::string_view, RowMatrix& values, const Field&) { values.setOnes(4, 0); }
  void of_states_or_none(std::string_view, RowMatrix& values, const Field&) {
    values.setOnes(4, 0);
  }
};

/// Content of a file of such signals.
/// @param path  where it is written
template <class Signals>
std::string good_file(const std::filesystem::path& path) {
  Signals signals;
  Filler filler;
  signals.visit(filler);
  data::save_signals(signals, path);
  return read_file(path);
}

/// One of each kind.
inline std::array<std::string, 8> good_files(const std::filesystem::path& path) {
  return {good_file<data::Dataset>(path),
          good_file<sim::Truth>(path),
          good_file<evaluate::RolloutSignals>(path),
          good_file<evaluate::PredictionSignals>(path),
          good_file<evaluate::BandSignals>(path),
          good_file<data::EstimateSignals>(path),
          good_file<data::LoopSignals>(path),
          good_file<data::ContactSignals>(path)};
}

}  // namespace fricid::fuzz
