#include "fricid/base/error.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"

namespace fricid::evaluate {
namespace {

constexpr const char *kRollout = "fricid.rollout/1", *kPrediction = "fricid.prediction/1",
                     *kBand = "fricid.band/1";

/// A file of signals of n joints, all sampled at /t.
class SignalFile {
 public:
  SignalFile(const std::filesystem::path& path, const char* format, int n)
      : path_(path), file_(path, format), n_(n), t_(file_.vector("t")) {}

  const Eigen::VectorXd& t() const { return t_; }
  RowMatrix table(const char* name) const {
    RowMatrix values = file_.matrix(name, n_);
    if (values.rows() != t_.size())
      throw UserError("{}: table {} has {} rows; allowed: {}, as t", path_.string(), name,
                      values.rows(), t_.size());
    return values;
  }
  RowMatrix table_or_none(const char* name) const {
    return file_.has(name) ? table(name) : RowMatrix();
  }

 private:
  std::filesystem::path path_;
  data::H5Reader file_;
  int n_;
  Eigen::VectorXd t_;
};

}  // namespace

void save_rollout(const Rollout& rollout, const Trajectory& trajectory, const std::string& model,
                  int seed, const std::filesystem::path& path) {
  data::write_hdf5(path, kRollout, [&](data::H5Writer& file) {
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

RolloutSignals load_rollout(const std::filesystem::path& path, int n) {
  const SignalFile file(path, kRollout, n);
  return {file.t(), file.table("q"), file.table("v"), file.table_or_none("tau_f")};
}

void save_prediction(const TorquePrediction& prediction, const data::Dataset& dataset,
                     ConstRowMatrix q, ConstRowMatrix v, const std::filesystem::path& path) {
  data::write_hdf5(path, kPrediction, [&](data::H5Writer& file) {
    file.attribute("joint_names", dataset.joint_names);
    file.vector("t", dataset.t, "s");
    file.matrix("q", q, "rad");
    file.matrix("v", v, "rad/s");
    file.matrix("tau", dataset.tau, "N m");
    file.matrix("tau_predicted", prediction.tau, "N m");
    file.matrix("tau_f", prediction.tau_f, "N m");
  });
}

PredictionSignals load_prediction(const std::filesystem::path& path, int n) {
  const SignalFile file(path, kPrediction, n);
  return {file.t(),
          file.table("q"),
          file.table("v"),
          file.table("tau"),
          file.table("tau_predicted"),
          file.table("tau_f")};
}

void save_band(const Band& band, const data::Dataset& dataset, const std::string& model,
               const std::filesystem::path& path) {
  data::write_hdf5(path, kBand, [&](data::H5Writer& file) {
    file.attribute("joint_names", dataset.joint_names);
    file.attribute("model", model);
    file.attribute("trajectory", dataset.name);
    file.vector("t", dataset.t.head(band.low.rows()), "s");
    file.matrix("q_low", band.low, "rad");
    file.matrix("q_high", band.high, "rad");
  });
}

BandSignals load_band(const std::filesystem::path& path, int n) {
  const SignalFile file(path, kBand, n);
  return {file.t(), {file.table("q_low"), file.table("q_high")}};
}

}  // namespace fricid::evaluate
