// Estimates, to a factor of two, of the memory that a fit or a filter will take.
#pragma once

#include <string_view>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/model.hpp"

namespace fricid::estimate {

/// Size of the training data of a fit.
struct TrainingSize {
  double samples = 0;  ///< of all recordings
  double longest = 0;  ///< samples of the longest recording
  double rate_hz = 0;
};

/// Bytes of a particle filter with `states` numbers per particle, one step.
double memory_of_filter(int particles, int states);

/// Bytes of fitting one model beside its data: particles and paths of EM, windows of training.
double memory_of_fit(const ModelOptions& options, const dynamics::RobotModel& robot,
                     const TrainingSize& size, int jobs);

/// Refuses a fit that would take too much memory, before it begins.
/// @throws UserError naming `where` and the model when it takes too much (limits.hpp)
void require_memory_of_fit(const ModelOptions& options, const dynamics::RobotModel& robot,
                           const TrainingSize& size, int jobs, std::string_view where);

}  // namespace fricid::estimate
