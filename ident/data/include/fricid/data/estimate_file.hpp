// What the online filter knew along a log: the files estimates/....h5 of a run folder.
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "fricid/data/dataset.hpp"
#include "fricid/data/model_file.hpp"

namespace fricid::data {

/// Means and standard deviations at each of the T samples.
struct EstimateSignals {
  Eigen::VectorXd t;                     ///< (T) [s]
  RowMatrix q, v, tau_f;                 ///< (T, n) [rad], [rad/s], [N m]
  RowMatrix z;                           ///< (T, state_size), or empty
  RowMatrix q_sd, v_sd, tau_f_sd, z_sd;  ///< of the same shapes
  Eigen::VectorXd log_likelihood, ess;   ///< (T) [nat], effective particles
};

/// Writes HDF5, format "fricid.estimate/1": /t (s), /q, /v, /z, /tau_f and their standard
/// deviations /q_sd ..., /log_likelihood, /ess, each with attribute `unit`; root attributes format,
/// joint_names, model, log. Atomic.
void save_estimate(const EstimateSignals& estimate, const ModelFile& model, const Dataset& log,
                   const std::filesystem::path& path);
/// @param n  number of joints
/// @throws UserError naming the file when it is missing, of another format, or its tables are not
///         of n joints and T samples
EstimateSignals load_estimate(const std::filesystem::path& path, int n);

}  // namespace fricid::data
