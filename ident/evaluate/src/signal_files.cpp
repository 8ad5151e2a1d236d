#include "fricid/data/signal_file.hpp"

#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"

namespace fricid::evaluate {

void save_rollout(const Rollout& rollout, const Trajectory& trajectory, const std::string& model,
                  int seed, const std::filesystem::path& path) {
  const data::Dataset& dataset = trajectory.data;
  const auto [first, steps] = std::pair(rollout.start.begin, rollout.start.steps);
  data::save_signals(RolloutSignals{.joint_names = dataset.joint_names,
                                    .model = model,
                                    .trajectory = dataset.name,
                                    .seed = static_cast<double>(seed),
                                    .diverged = rollout.diverged ? 1.0 : 0.0,
                                    .t = dataset.t.segment(first, steps + 1),
                                    .q = rollout.q,
                                    .v = rollout.v,
                                    .tau_f = rollout.tau_f},
                     path);
}

RolloutSignals load_rollout(const std::filesystem::path& path, int n) {
  return data::load_signals<RolloutSignals>(path, n);
}

void save_prediction(const TorquePrediction& prediction, const data::Dataset& dataset,
                     ConstRowMatrix q, ConstRowMatrix v, const std::filesystem::path& path) {
  data::save_signals(PredictionSignals{.joint_names = dataset.joint_names,
                                       .t = dataset.t,
                                       .q = q,
                                       .v = v,
                                       .tau = dataset.tau,
                                       .tau_predicted = prediction.tau,
                                       .tau_f = prediction.tau_f},
                     path);
}

PredictionSignals load_prediction(const std::filesystem::path& path, int n) {
  return data::load_signals<PredictionSignals>(path, n);
}

void save_band(const Band& band, const data::Dataset& dataset, const std::string& model,
               const std::filesystem::path& path) {
  data::save_signals(BandSignals{.joint_names = dataset.joint_names,
                                 .model = model,
                                 .trajectory = dataset.name,
                                 .t = dataset.t.head(band.low.rows()),
                                 .band = band},
                     path);
}

BandSignals load_band(const std::filesystem::path& path, int n) {
  return data::load_signals<BandSignals>(path, n);
}

}  // namespace fricid::evaluate
