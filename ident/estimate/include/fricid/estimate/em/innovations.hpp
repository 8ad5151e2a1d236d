// The likelihood of a recording as a function of the arm's parameters, by its innovations.
#pragma once

#include <Eigen/Core>

#include "fricid/estimate/em/latent_friction_model.hpp"
#include "fricid/smc/model.hpp"

namespace fricid::estimate {

/// Log-likelihood under the extended Kalman filter with its score and information in the physical
/// parameters p = (pi, theta), sums over recordings:
///
///     log p(y) = -1/2 sum ( e_t' S_t^-1 e_t + log det 2 pi S_t ),     e_t = y_t - C m_{t|t-1}
///     score = sum E_t' S_t^-1 e_t,   information = sum E_t' S_t^-1 E_t,   E_t = C dm_{t|t-1}/dp
///
/// with gains and S_t held: their dependence on p has zero mean at the truth, because innovations
/// are independent of the past.
/// @see Ljung, System Identification, 1999, ch. 7
struct InnovationScore {
  double log_likelihood = 0;    ///< [nat]
  Eigen::VectorXd score;        ///< (n_pi + n_theta)
  Eigen::MatrixXd information;  ///< square, symmetric; the lower triangle is filled
  bool failed = false;          ///< something became infinite; the rest is then meaningless
};

/// Filters y, the means' sensitivities going along,
///
///     m_{t+1|t} = f(m_{t|t}),   D_{t+1|t} = A D_{t|t} + df/dp,   D_{t|t} = (I - K C) D_{t|t-1}.
InnovationScore innovation_score(LatentFrictionModel& model, const smc::RowMatrix& y);

/// The log-likelihood alone, channel by channel [nat]: entry i sums log p(y_i | the channels before
/// it, all samples before). The sum of all is that of `innovation_score`.
Eigen::VectorXd innovation_likelihood(LatentFrictionModel& model, const smc::RowMatrix& y);

}  // namespace fricid::estimate
