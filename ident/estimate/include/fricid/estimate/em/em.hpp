// Expectation-maximisation with filters and smoothers, for any friction model.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/em/e_step.hpp"
#include "fricid/estimate/em/latent_friction_model.hpp"
#include "fricid/estimate/options/em.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/windows/multi_step.hpp"
#include "fricid/optimise/checkpoint.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Figures of one iteration.
struct EmIteration {
  double log_likelihood = 0;      ///< of the training parts, estimated [nat]
  double nis = 0;                 ///< mean per channel; 1 if the noise is as large as the model's
  double least_roots = 0;         ///< least share of distinct roots over the recordings; 1 for EKF
  double least_backward_ess = 0;  ///< least median over the recordings; 0: not used
  double objective = 0;    ///< mean of minus the log transition density after the M-step [nat]
  double velocity_sd = 0;  ///< of the noise of v after it, geometric mean over joints [rad/s]
  double held_out = 0;     ///< [rad^2] after the iteration

  template <class Archive>
  void visit(Archive& archive) {
    archive("log_likelihood", log_likelihood);
    archive("nis", nis);
    archive("least_roots", least_roots);
    archive("least_backward_ess", least_backward_ess);
    archive("objective", objective);
    archive("velocity_sd", velocity_sd);
    archive("held_out", held_out);
  }
};

struct EmReport {
  Outcome outcome = Outcome::kFailed;
  std::string message = "fit_em was not called";
  Arm arm;                    ///< best on the held-out part, the start included, or the last
  LatentNoise noise;          ///< that belongs to it
  double held_out_start = 0;  ///< [rad^2] of the start
  std::vector<EmIteration> iterations;
  int best = -1;  ///< index of the chosen iteration, -1: the start
  std::vector<std::string> warnings;
  double seconds = 0;
};

/// Noise to start with: R from the noise of the logs above the band of the motion, Q from shares of
/// the friction torque (of the torque of the training data where a law of the whole robot gives it)
/// and of the latent states.
LatentNoise initial_noise(const Arm& arm, std::span<const signals::Recording> recordings,
                          const EmOptions& options);

/// Where a filter over a recording begins: filtered motion, washed-out friction state z, each with
/// the uncertainty that goes with it.
/// @param z_size  (n_z) rms of the states, see `latent_sizes`
smc::Gaussian initial_state(const signals::Recording& recording, const Eigen::VectorXd& z,
                            const Eigen::VectorXd& z_size, const LatentNoise& noise);

/// @throws UserError on a recording shorter than a second
void require_length_for_em(std::span<const signals::Recording> recordings);

/// Root mean square of every latent state along the recordings (n_z); 1 for one that stays 0.
Eigen::VectorXd latent_sizes(std::span<const RowMatrix> z);

/// EM from `start`. E-step: smoothed paths of the training part of each recording under the present
/// parameters. M-step: either the likelihood itself climbs by one step of Fisher scoring (ECME, Liu
/// & Rubin 1994: as far in one iteration as plain EM in 1 / (share of information observed)), or
/// the transition density of random transitions of these paths is maximised from the last
/// parameters on, by Levenberg-Marquardt, or by Adam where there are thousands (networks), whose
/// moments last from one iteration to the next and whose loss holds coordinates of rate r_i with
///
///     ridge/2 sum (c_i - c_i,start)^2 / max(r_i, 0.05);
///
/// then, where `options.lengths` is set, a line search of the likelihood of the innovations along
/// each length of latent states, on which that density says next to nothing; then the noise of v in
/// closed form,
///
///     Q_v = mean (v_{t+1} - f_v(x_t))^2
///
/// not below its floor. Q_z follows a falling schedule (estimated, it would hardly move), Q_q stays
/// at its start, R stays at the noise of the logs or is estimated in closed form too. No variance
/// of Q is ever 0. Returns the parameters with the smallest held-out error of all iterations and
/// the start, or those of the last iteration (EmOptions::keep). The result does not depend on
/// `jobs`, nor on how often the run was killed and went on from `checkpoint`, which is saved after
/// every iteration.
/// @throws UserError on a recording shorter than a second
/// @throws Stopped on Ctrl-C; the checkpoint stays
EmReport fit_em(const Arm& start, std::span<const signals::Recording> recordings,
                const EmOptions& options, std::string_view label, int jobs,
                const optimise::Checkpoint& checkpoint = {});

}  // namespace fricid::estimate
