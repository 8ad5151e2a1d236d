// Options of expectation-maximisation, as in a scene.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// How smoothed paths are found.
enum class EStep {
  kEkf,       ///< extended Kalman filter and RTS smoother, paths drawn from the Gaussian posterior
  kPsi,       ///< twisted particle filter along the RTS path, paths by their genealogy
  kAdapted,   ///< fully adapted particle filter, paths by backward sampling
  kBootstrap  ///< bootstrap particle filter, paths by backward sampling
};
constexpr std::string_view names(EStep) { return "ekf|psi|adapted|bootstrap"; }

/// How the M-step finds the parameters of robot and friction.
enum class MStep {
  kScore,       ///< one step of Fisher scoring up the likelihood of the innovations
  kTransitions  ///< the maximum of the transition density of the smoothed paths
};
constexpr std::string_view names(MStep) { return "score|transitions"; }

/// Which iteration is kept.
enum class Keep {
  kHeldOut,  ///< the best on the held-out part
  kLast
};
constexpr std::string_view names(Keep) { return "held_out|last"; }

/// [model.em]: expectation-maximisation.
struct EmOptions {
  EStep e_step = EStep::kEkf;
  MStep m_step = MStep::kScore;  ///< kTransitions for thousands of parameters
  int iterations = 10;
  int particles = 200;
  int paths = 4;
  int m_steps = 500;
  int batch = 2048;
  double rate = 0.004;  ///< times 0.3 in the last third of the iterations
  double torque_noise = 0.1;
  double torque_floor = 0.01;
  double z_noise_first = 0.1;
  double z_noise_last = 0.01;
  bool free_observation_noise = false;
  bool rigid_body = true;
  int rigid_body_from = 0;
  double rigid_body_rate = 0.25;
  bool lengths = false;
  double hold_out = 0.2;
  Keep keep = Keep::kHeldOut;

  // Not keys of a scene.
  double ridge = 0;  ///< of Adam: pull to the start, nat per transition, see `fit_em`
  /// (n) transitions with a slower joint do not move the rigid body of an M-step on transitions
  /// [rad/s]; empty: 0.
  std::vector<double> rigid_body_speed;
  double most_nis = 2;      ///< the noise of z falls no further where NIS per channel is above it
  StepOptions step{8, 4};   ///< of filter and M-step
  StepOptions judge{8, 1};  ///< of the held-out rollouts
  std::vector<double> torque_scale;  ///< (n) size of the joint torques [N m]; empty: 1
  std::uint64_t seed = 1;

  template <class Archive>
  void visit(Archive& archive) {
    archive("e_step", e_step, choice("how paths are smoothed"));
    archive("m_step", m_step,
            choice("maximise the likelihood, or the transition density (always for networks)"));
    archive("iterations", iterations, number("", 0, 1e5, "E- and M-steps"));
    archive("particles", particles, number("", 1, 1e6, "number of particles"));
    archive("paths", paths, number("", 1, 1000, "smoothed paths per recording"));
    archive("m_steps", m_steps, number("", 0, 1e6, "steps of Adam per iteration"));
    archive("batch", batch, number("", 1, 1e7, "transitions per step of Adam"));
    archive("rate", rate, number("1", 1e-6, 1, "first step length of Adam"));
    archive("torque_noise", torque_noise,
            number("1", 1e-6, 10, "initial torque noise, share of the friction torque"));
    archive("torque_floor", torque_floor,
            number("1", 1e-9, 10, "smallest torque noise, share of the friction torque"));
    archive("z_noise_first", z_noise_first,
            number("1", 1e-9, 10,
                   "initial noise of the latent states per sample, share of their size"));
    archive(
        "z_noise_last", z_noise_last,
        number("1", 1e-9, 10, "final noise of the latent states per sample, share of their size"));
    archive("free_observation_noise", free_observation_noise,
            flag("estimate the encoder noise too, once the noise of the latent states is final"));
    archive("rigid_body", rigid_body, flag("fit the rigid body together with the friction"));
    archive("rigid_body_from", rigid_body_from,
            number("", 0, 1e5, "iterations of Adam before the rigid body moves"));
    archive("rigid_body_rate", rigid_body_rate,
            number("1", 1e-4, 10, "step of a rigid-body coordinate over one of friction, of Adam"));
    archive("lengths", lengths,
            flag("after every M-step, maximise the likelihood along each length of latent states"));
    archive("hold_out", hold_out,
            number("1", 0.05, 0.5, "last share of every recording, held out to choose the result"));
    archive("keep", keep, choice("iteration to keep: the best on held-out rollouts, or the last"));
  }
};

}  // namespace fricid::estimate
