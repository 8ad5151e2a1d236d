// Times of training logs in which something else than friction acts.
#pragma once

#include <string>

namespace fricid::estimate {

/// Times in which torques are off by far more than ever else.
struct Disturbances {
  std::string found;   ///< "shoulder, elbow by up to 9.7 N m, 33 times as much as ever else: ..."
  std::string remedy;  ///< the log without them
};

}  // namespace fricid::estimate
