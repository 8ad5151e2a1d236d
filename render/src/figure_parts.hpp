// The figures of a run by subject. A figure without its files has no panels.
#pragma once

#include <vector>

#include "run.hpp"

namespace fricid::render {

// figures_motion.cpp: open loops
Figure tracking(const Run& run);
Figure error_time(const Run& run);
Figure error_horizon(const Run& run);
Figure error_joint(const Run& run);
Figure bands(const Run& run);

// figures_friction.cpp: friction torque and states
Figure friction_loop(const Run& run, int joint);
Figure presliding(const Run& run);
Figure reversal(const Run& run);
Figure friction_time(const Run& run);
Figure friction_error(const Run& run);
Figure latent(const Run& run);
Figure torque(const Run& run, const RunModel& model);
Figure torque_drift(const Run& run);

// figures_fit.cpp: quality of the fits
Figure parameters(const Run& run);
Figure training(const Run& run);
Figure em(const Run& run);
Figure filter_health(const Run& run);
Figure residual_spectrum(const Run& run);
Figure excitation(const Run& run);
Figure margins(const Run& run);
Figure correlation(const Run& run, const RunModel& model);

// figures_loops.cpp: closed loops
Figure compensation(const Run& run);
Figure compensation_time(const Run& run);
Figure contact(const Run& run);
Figure contact_threshold(const Run& run);

}  // namespace fricid::render
