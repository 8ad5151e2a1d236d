// Options of training on the torque residual of the rigid body, as in a scene.
#pragma once

#include <cstdint>

#include "fricid/base/field.hpp"

namespace fricid::estimate {

/// [model.torque]: training on the torque that the rigid body leaves.
struct TorqueOptions {
  double window_s = 0.5;
  int batch = 32;
  int iterations = 2000;
  double rate = 0.004;  ///< times 0.3 after 60 % and 0.1 after 85 % of the iterations
  bool filtered = true;
  double hold_out = 0.2;

  // Not keys of a scene.
  int wash_out_every = 100;  ///< iterations between refreshes of the friction states
  int checks = 20;           ///< how often the held-out error is looked at
  double cutoff_hz = 10;     ///< of the measured torque's filter
  std::uint64_t seed = 1;

  template <class Archive>
  void visit(Archive& archive) {
    archive(
        "window_s", window_s,
        number("s", 0, 100, "length of backpropagation through the friction state; 0: one sample"));
    archive("batch", batch, number("", 1, 1e6, "windows per step"));
    archive("iterations", iterations, number("", 0, 1e7, "steps of Adam"));
    archive("rate", rate, number("1", 1e-6, 1, "first step length of Adam"));
    archive("filtered", filtered,
            flag("pass the model's torque through the filter of the measured one; else motion and "
                 "torque are compared as filtered at cutoff_hz"));
    archive("hold_out", hold_out,
            number("1", 0.05, 0.5, "last share of every recording, held out to choose the result"));
  }
};

}  // namespace fricid::estimate
