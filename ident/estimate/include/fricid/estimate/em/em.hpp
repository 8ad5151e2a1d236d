// Stage S2: expectation-maximisation with filters and smoothers, for any friction model.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fricid/estimate/checkpoint.hpp"
#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/em/e_step.hpp"
#include "fricid/estimate/em/latent_friction_model.hpp"
#include "fricid/estimate/recording.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/windows/multi_step.hpp"

namespace fricid::estimate {

/// How the M-step finds the parameters of robot and friction.
enum class MStep {
  kScore,       ///< one step of Fisher scoring up the likelihood of the innovations
  kTransitions  ///< the maximum of the transition density of the smoothed paths
};
/// "score", "transitions".
std::string_view to_string(MStep m_step);

struct EmOptions {
  EStep e_step = EStep::kEkf;
  MStep m_step = MStep::kScore;  ///< where there are thousands of parameters, kTransitions
  int iterations = 8;
  int particles = 200;
  int paths = 4;       ///< smoothed paths per recording
  int m_steps = 500;   ///< steps of Adam per iteration
  int batch = 2048;    ///< transitions per step
  double rate = 2e-3;  ///< of Adam, times 0.3 in the last third of the iterations
  double torque_noise =
      0.1;  ///< first sd of the torque that drives v, share of the friction torque
  double torque_floor = 0.01;                       ///< least such sd
  double z_noise_first = 0.1, z_noise_last = 0.01;  ///< sd per sample, share of the rms of z
  double most_nis = 2;  ///< the noise of z falls no further where NIS per channel is above it
  bool free_observation_noise = false;  ///< R in closed form once the noise of z has fallen
  double hold_out = 0.2;
  bool keep_last = false;   ///< keep the last iteration instead of the best on the held-out part
  StepOptions step{8, 4};   ///< of filter and M-step
  StepOptions judge{8, 1};  ///< of the held-out rollouts
  CoordinateOptions coordinates;
  std::uint64_t seed = 1;
};

/// What one iteration saw.
struct EmIteration {
  double log_likelihood = 0;  ///< of the training parts, estimated [nat]
  double nis = 0;             ///< mean per channel; 1 when the noise is as large as the model says
  double least_roots = 0;     ///< least share of distinct roots over the recordings; 1 for EKF
  double least_backward_ess = 0;  ///< least median over the recordings; 0 where it does not apply
  double objective = 0;  ///< mean of minus the log transition density after the M-step [nat]
  double held_out = 0;   ///< [rad^2] after the iteration
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

/// Noise to start with: R from what the logs hold above their band, Q from shares of the friction
/// torque and of the latent states.
LatentNoise initial_noise(const Arm& arm, std::span<const Recording> recordings,
                          const EmOptions& options);

/// Where a filter over a recording begins: filtered motion, washed-out friction state z, each with
/// the uncertainty that goes with it.
/// @param z_size  (n_z) rms of the states, see `latent_sizes`
smc::Gaussian initial_state(const Recording& recording, const Eigen::VectorXd& z,
                            const Eigen::VectorXd& z_size, const LatentNoise& noise);

/// Root mean square of every latent state along the recordings (n_z); 1 for one that stays 0.
Eigen::VectorXd latent_sizes(std::span<const data::RowMatrix> z);

/// EM from `start`. E-step: smoothed paths of the training part of each recording under the present
/// parameters. M-step: either the likelihood itself climbs by one step of Fisher scoring (ECME, Liu
/// & Rubin 1994: as far in one iteration as plain EM in 1 / (share of information observed)), or
/// the transition density of random transitions of these paths is maximised from the last
/// parameters on, by Levenberg-Marquardt, or by Adam where there are thousands (networks); then the
/// noise of v in closed form,
///
///     Q_v = mean (v_{t+1} - f_v(x_t))^2
///
/// above its floor, that of z on a falling schedule instead (left free it stays where it is), that
/// of q as it is, R as the logs show it, or in closed form too. No variance of Q is ever 0.
/// Returns the parameters with the smallest held-out error met, so never worse there than `start`,
/// or those of the last iteration where the options say so.
/// The result depends on the options alone, not on `jobs`, nor on how often it was killed and went
/// on from `checkpoint`, saved after every iteration.
/// @throws Stopped on Ctrl-C; the checkpoint stays
EmReport fit_em(const Arm& start, std::span<const Recording> recordings, const EmOptions& options,
                std::string_view label, int jobs, const Checkpoint& checkpoint = {});

}  // namespace fricid::estimate
