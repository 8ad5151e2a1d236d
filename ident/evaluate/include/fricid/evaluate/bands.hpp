// Open-loop prediction bands of a model, and their coverage.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/options.hpp"
#include "fricid/evaluate/torque_error.hpp"

namespace fricid::evaluate {

/// 90 % band of q over one recording, from its first sample to the longest horizon.
struct Band {
  RowMatrix low, high;  ///< (steps + 1, n) [rad]
};

/// Between the 5 % and the 95 % quantile of the draws, sample by sample and joint by joint. With N
/// draws the p quantile is their number p (N + 1) in order, between two of them by a straight line:
/// a further draw from the same distribution lies inside with probability 0.9, for N = 19, 39,
/// 59 .. whatever the distribution.
/// @param draws  (T, n) each [rad], at least 19
Band band_of(std::span<const RowMatrix> draws);

/// The band mirrored at `centre` (T, n), sample by sample. Draws are to the rollout what the
/// rollout is to the truth: what a torque error moves on the mean, as a torque that trembles lets a
/// bristle slip, has moved the rollout too, and the truth lies on its other side (basic bootstrap,
/// Davison and Hinkley 1997, 5.2). It contains `centre`: where a torque error frees a joint that
/// sticks, all draws lie on one side of the rollout.
Band reflected(const Band& band, const RowMatrix& centre);

/// A band over the samples from the first one to a horizon. NaN beyond its length.
struct BandScore {
  /// Share of samples and joints inside; a measured position may lie beyond by its noise, added in
  /// quadrature
  double coverage = 0;
  double half_width = 0;  ///< root mean square over samples and joints [rad]
};
BandScore score(const Band& band, const Trajectory& trajectory, int steps);

/// A model with its torque error.
struct Member {
  const data::ModelFile* model;
  FittedTorqueError fitted;
  std::span<const Arm> draws = {};  ///< arms that its data might as well have given; empty: its own

  const Arm& arm(std::size_t draw) const {
    return draws.empty() ? model->arm : draws[draw % draws.size()];
  }
};

/// Bands of the seeds of a model together, `reflected` at the mean of their rollouts:
/// `options.draws` rollouts of every member from the first sample of every recording, each by
/// another arm of its draws, under the measured torque and a torque error of its own, stepped by
/// the leap of the member.
/// @return one per trajectory; the same for any `jobs`
std::vector<Band> open_loop_bands(std::span<const Member> members,
                                  std::span<const Trajectory> trajectories,
                                  const EvaluateOptions& options, int jobs);

/// A band as a file.
struct BandSignals {
  static constexpr std::string_view kFormat = "fricid.band/1";

  std::vector<std::string> joint_names;  ///< (n)
  std::string model, trajectory;         ///< names
  Eigen::VectorXd t;                     ///< (T) [s]
  Band band;                             ///< (T, n)

  template <class Archive>
  void visit(Archive& archive) {
    archive.joints(joint_names);
    archive.stamp("model", model, text("name of the model, all seeds together"));
    archive.stamp("trajectory", trajectory, text("recording whose torque drove it"));
    archive.times(t);
    archive.of_joints("q_low", band.low, signal("rad", "lower end of the 90 % band of q"));
    archive.of_joints("q_high", band.high, signal("rad", "upper end of the 90 % band of q"));
  }
};
void save_band(const Band& band, const data::Dataset& dataset, const std::string& model,
               const std::filesystem::path& path);
/// @param n  number of joints
/// @throws as data::load_signals
BandSignals load_band(const std::filesystem::path& path, int n);

}  // namespace fricid::evaluate
