// The online estimator over a whole log.
#pragma once

#include <string_view>

#include "fricid/data/dataset.hpp"
#include "fricid/data/estimate_file.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/estimate/online/log_start.hpp"
#include "fricid/estimate/online/online.hpp"

namespace fricid::estimate {

/// Estimates after each of the T samples, see OnlineEstimate.
struct OnlineLog : data::EstimateSignals {
  int lost = 0;  ///< samples that no particle explained
};

/// The filter of a model from where a log begins; velocities and latent states are not known well.
/// @param where  starts the message
/// @throws UserError when the model carries no noise, or joints or rate differ
OnlineEstimator begin_online(const data::ModelFile& model, const LogStart& start, double rate_hz,
                             const OnlineOptions& options, std::string_view where);

/// Runs the filter over a log, from `log_start`.
/// Missing torques are held.
/// @throws UserError when the model carries no noise, or joints or rate differ; Stopped on Ctrl-C
OnlineLog estimate_log(const data::ModelFile& model, const data::Dataset& log,
                       const OnlineOptions& options);

}  // namespace fricid::estimate
