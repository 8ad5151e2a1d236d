// What OnlineEstimator saves.
#pragma once

#include "fricid/estimate/online/online.hpp"
#include "fricid/smc/history.hpp"
#include "fricid/smc/particle_filter.hpp"

namespace fricid::estimate {

struct OnlineEstimator::State {
  smc::FilterState<PackD> particles;
  OnlineEstimate estimate;
  Eigen::VectorXd last_y;
  int t = 0;
};

}  // namespace fricid::estimate
