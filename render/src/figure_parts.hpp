// The figures of a run by what they show. Each is empty of panels where its files are absent.
#pragma once

#include <vector>

#include "run.hpp"

namespace fricid::render {

// figures_motion.cpp: open loops
Figure tracking(const Run& run);
Figure error_time(const Run& run);
Figure error_horizon(const Run& run);
Figure error_joint(const Run& run);

// figures_friction.cpp
Figure friction_loop(const Run& run, int joint);
Figure torque(const Run& run, const RunModel& model);

}  // namespace fricid::render
