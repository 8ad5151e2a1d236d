// The error of a linearisation of f_t in log psi_t, as a quadratic with or without a kink.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace fricid::smc {

/// c + g' d - d' H d / 2 of a deviation d (n).
struct Quadratic {
  Eigen::MatrixXd H;  ///< (n x n)
  Eigen::VectorXd g;  ///< (n)
  double c = 0;

  static Quadratic zero(Eigen::Index n) {
    return {Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0};
  }
};

/// |x_state| (c + g' d) + rest(d): what a kink of f_t at x_state = 0 adds to log psi_t.
struct Kink {
  int state = -1;     ///< none if negative; the rest is then meaningless
  Eigen::VectorXd g;  ///< (n)
  double c = 0;
  Quadratic rest;

  /// Adds the quadratic that it is where x_state > 0 (side 1) or < 0 (side -1), x = s + d.
  void add_side(int side, const Eigen::VectorXd& s, Eigen::MatrixXd& H, Eigen::VectorXd& slope,
                double& constant) const;
};

/// States in which f_t is curved together, as position, velocity and bristle of one joint.
struct Part {
  std::vector<int> states;
  int kink = -1;  ///< the one of them at whose zero f_t has a kink, or none
};

/// Draws d of x_t - s and the log weight r that each would gain: a sample of what to fit.
struct BendSample {
  Eigen::MatrixXd d;     ///< (draws x n)
  Eigen::VectorXd r;     ///< (draws) [nat]
  Eigen::VectorXd core;  ///< (draws) 1 where d was drawn from N(0, P), 0 where from further out
};

/// Whether r varies by more than 5e-5 nat^2; for linear models it does not.
bool worth_bending(const BendSample& sample);

/// Least squares of r on the quadratics in one part's states, for the part that explains most;
/// then, if `may_kink`, on those and |x_k| times the linear functions, kept where it explains more.
/// The kink also heeds the draws from further out, slightly: they keep the weights bounded there.
/// What is found is scaled down until psi stays integrable.
/// @param P  covariance of the core (n x n)
/// @param s  (n)
void fit_bend(const BendSample& sample, std::span<const Part> parts, const Eigen::MatrixXd& P,
              const Eigen::VectorXd& s, bool may_kink, Quadratic& bend, Kink& kink);

}  // namespace fricid::smc
