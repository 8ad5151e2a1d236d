// Options of training on open-loop windows, as in a scene.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"
#include "fricid/estimate/options/limit.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// How the loss is minimised.
enum class Optimiser {
  kAuto,        ///< Gauss-Newton up to 8000 parameters, else Adam
  kAdam,        ///< first order
  kGaussNewton  ///< stochastic Gauss-Newton steps, for up to some thousand parameters
};
constexpr std::string_view names(Optimiser) { return "auto|adam|gauss_newton"; }

/// Errors below these sizes count squared, above them linearly.
struct ErrorScales {
  double q = 3e-3;  ///< [rad]
  double v = 0.03;  ///< [rad/s]
};

/// [model.train]: training on open-loop windows.
struct MultiStepOptions {
  Optimiser optimiser = Optimiser::kAuto;
  double window_s = 0.25;
  int batch = 32;
  int iterations = 0;
  double rate = 0;  ///< times 0.3 after 60 % and 0.1 after 85 % of the iterations
  bool rigid_body = true;
  double hold_out = 0.2;

  // Not keys of a scene.
  double from_rest = 0.125;  ///< share of the windows that begin with a recording
  int wash_out_every = 20;   ///< iterations between refreshes of the friction states
  int checks = 10;           ///< how often the held-out error is looked at
  StepOptions step{8, 4};    ///< of training; leaps are shortened until they hold
  StepOptions judge{8, 1};   ///< of the held-out rollouts
  ErrorScales scales;
  std::vector<double> torque_scale;  ///< (n) size of the joint torques [N m]; empty: 1
  std::vector<Limit> limits;         ///< narrower bounds of parameters of friction
  std::uint64_t seed = 1;

  template <class Archive>
  void visit(Archive& archive) {
    archive("optimiser", optimiser,
            choice("auto: Gauss-Newton steps with sampled curvature for up to 8000 parameters, "
                   "else Adam"));
    archive("window_s", window_s, number("s", 0.01, 100, "length of a window"));
    archive("batch", batch, number("", 1, 1e6, "windows per step"));
    archive("iterations", iterations,
            number("", 0, 1e7, "steps; 0: 2400 of adam, 1000 of gauss_newton"));
    archive("rate", rate,
            number("1", 0, 1, "first step length; 0: 0.008 of adam, 1 of gauss_newton"));
    archive("rigid_body", rigid_body, flag("train the rigid body together with the friction"));
    archive("hold_out", hold_out,
            number("1", 0.05, 0.5, "last share of every recording, held out to choose the result"));
  }
};

}  // namespace fricid::estimate
