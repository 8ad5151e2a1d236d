#include "rigid_body/frictionless.hpp"

#include <algorithm>
#include <cmath>

namespace fricid::estimate {

bool is_frictionless(std::span<const signals::Recording> recordings, const RigidBodyFit& fit) {
  constexpr double kNothing = 0.01, kErrors = 4, kKnown = 0.1;
  if (fit.outcome != Outcome::kConverged || fit.Fc.size() == 0 || fit.Fc_se.size() == 0)
    return false;
  for (Eigen::Index j = 0; j < fit.Fc.size(); ++j) {
    double squares = 0, speed = 0, count = 0;
    for (const signals::Recording& r : recordings) {
      squares += r.filtered_tau.col(j).squaredNorm();
      speed += r.narrow.v.col(j).cwiseAbs().sum();
      count += static_cast<double>(r.length());
    }
    const double friction = std::abs(fit.Fc[j] + fit.Fv[j] * speed / count),
                 error = std::hypot(fit.Fc_se[j], fit.Fv_se[j] * speed / count);
    const double torque = std::sqrt(squares / count);
    if (friction > std::max(kNothing * torque, kErrors * error)) return false;
    if (friction + 2 * error > kKnown * torque) return false;
  }
  return true;
}

}  // namespace fricid::estimate
