// Times of training logs in which something else than friction acts.
#pragma once

#include <string>

namespace fricid::estimate {

/// Times in which torques are off by far more than ever else.
struct Disturbances {
  /// "torques are off by up to 33 times as much as ever else, 6.9 to 7.4 s of train_0 (...)"
  std::string found;
  std::string remedy;  ///< the log without them
};

}  // namespace fricid::estimate
