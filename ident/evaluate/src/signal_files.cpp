#include "fricid/data/hdf5.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"

namespace fricid::evaluate {

void save_rollout(const Rollout& rollout, const Trajectory& trajectory, const std::string& model,
                  int seed, const std::filesystem::path& path) {
  data::write_hdf5(path, "fricid.rollout/1", [&](data::H5Writer& file) {
    file.attribute("joint_names", trajectory.data.joint_names);
    file.attribute("model", model);
    file.attribute("seed", static_cast<double>(seed));
    file.attribute("trajectory", trajectory.data.name);
    file.attribute("diverged", rollout.diverged ? 1.0 : 0.0);
    file.vector("t", trajectory.data.t.segment(rollout.start.begin, rollout.start.steps + 1), "s");
    file.matrix("q", rollout.q, "rad");
    file.matrix("v", rollout.v, "rad/s");
    if (rollout.tau_f.size() > 0) file.matrix("tau_f", rollout.tau_f, "N m");
  });
}

void save_prediction(const TorquePrediction& prediction, const data::Dataset& dataset,
                     ConstRowMatrix q, ConstRowMatrix v, const std::filesystem::path& path) {
  data::write_hdf5(path, "fricid.prediction/1", [&](data::H5Writer& file) {
    file.attribute("joint_names", dataset.joint_names);
    file.vector("t", dataset.t, "s");
    file.matrix("q", q, "rad");
    file.matrix("v", v, "rad/s");
    file.matrix("tau", dataset.tau, "N m");
    file.matrix("tau_predicted", prediction.tau, "N m");
    file.matrix("tau_f", prediction.tau_f, "N m");
  });
}

void save_band(const Band& band, const data::Dataset& dataset, const std::string& model,
               const std::filesystem::path& path) {
  data::write_hdf5(path, "fricid.band/1", [&](data::H5Writer& file) {
    file.attribute("joint_names", dataset.joint_names);
    file.attribute("model", model);
    file.attribute("trajectory", dataset.name);
    file.vector("t", dataset.t.head(band.low.rows()), "s");
    file.matrix("q_low", band.low, "rad");
    file.matrix("q_high", band.high, "rad");
  });
}

}  // namespace fricid::evaluate
