// The online estimator over a whole log.
#pragma once

#include <filesystem>

#include "fricid/data/dataset.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/estimate/online/online.hpp"

namespace fricid::estimate {

/// What the filter knew at each of the T samples; see OnlineEstimate.
struct OnlineLog {
  Eigen::VectorXd t;               ///< (T) [s]
  data::RowMatrix q, v, z, tau_f;  ///< (T, .)
  data::RowMatrix q_sd, v_sd, z_sd, tau_f_sd;
  Eigen::VectorXd log_likelihood, ess;  ///< (T)
  int lost = 0;                         ///< samples that no particle explained
};

/// Runs the filter over a log, from rest at its first position; latent states begin unknown.
/// Missing torques are held.
/// @throws UserError when the model carries no noise, or joints or rate differ; Stopped on Ctrl-C
OnlineLog estimate_log(const data::ModelFile& model, const data::Dataset& log,
                       const OnlineOptions& options);

/// Writes HDF5, format "fricid.estimate/1": /t (s), /q, /v, /z, /tau_f and their standard
/// deviations /q_sd ..., /log_likelihood, /ess, each with attribute `unit`; root attributes format,
/// joint_names, model, log. Atomic.
void save_online_log(const OnlineLog& estimated, const data::ModelFile& model,
                     const data::Dataset& log, const std::filesystem::path& path);

}  // namespace fricid::estimate
