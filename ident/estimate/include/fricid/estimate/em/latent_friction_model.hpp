// A robot with friction and noise as a state-space model for the filters of smc.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/signals/recording.hpp"
#include "fricid/smc/bend.hpp"
#include "fricid/smc/model.hpp"
#include "fricid/system/arm.hpp"
#include "fricid/system/noise.hpp"

namespace fricid::estimate {

/// The arm over one recording, torque held over each sample:
///
///     x = [q, v, z]   (2 n + n_z),     x_{t+1} = f(x_t; tau_t, temperature_t) + w,  w ~ N(0, Q)
///     y_t = q + e  or  [q, v] + e,                                                  e ~ N(0, R)
///
/// with f one sample of ArmStepper, z being integrated exactly for held velocity. Whether velocity
/// is observed follows from the size of R. A recording shorter than a run is read round and round,
/// so that one of a single row serves online.
class LatentFrictionModel {
 public:
  /// @param initial  of x_0
  /// @throws UserError when sizes do not agree
  LatentFrictionModel(const Arm& arm, const signals::Recording& recording, const LatentNoise& noise,
                      smc::Gaussian initial, StepOptions step);

  int state_size() const { return 2 * n_ + nz_; }
  int observation_size() const { return static_cast<int>(R_.rows()); }
  const smc::Gaussian& initial() const { return initial_; }
  const Eigen::MatrixXd& Q() const { return Q_; }
  const Eigen::MatrixXd& C() const { return C_; }
  const Eigen::MatrixXd& R() const { return R_; }
  /// Position, velocity and the first four friction states of every joint; friction has a kink
  /// where the velocity changes sign.
  const std::vector<smc::Part>& parts() const { return parts_; }

  /// x <- f(x) at sample t of the recording, one state per lane. Does not allocate.
  template <class S>
  void transition(int t, std::span<S> x);

  /// f(x) and A = df/dx at one state; the rows of A are pulled back together, one per lane.
  void linearise(int t, const Eigen::VectorXd& x, Eigen::VectorXd& f, Eigen::MatrixXd& A);

  /// Likewise, and B = df/d(pi, theta), (state_size x parameter_count).
  void linearise(int t, const Eigen::VectorXd& x, Eigen::VectorXd& f, Eigen::MatrixXd& A,
                 Eigen::MatrixXd& B);
  int parameter_count() const { return static_cast<int>(pi_bar_.size() + theta_bar_.size()); }

  /// A of every lane, row-major (state_size x state_size), for S = double, PackD or PackF.
  template <class S>
  void jacobian(int t, std::span<const S> x, std::span<S> A);

  /// Friction torque [N m] (n) in the states x, one per lane. Does not allocate.
  template <class S>
  void friction_torque(int t, std::span<const S> x, std::span<S> tau_f);

 private:
  template <class S>
  struct Lanes {
    Lanes(const Arm& arm, StepOptions step);
    ArmStepper<S> stepper;
    std::vector<S> tau, temperature;
    std::vector<S> history;  // states at every leap
    std::vector<S> bar;      // adjoint of one state
  };
  template <class S>
  Lanes<S>& lanes();
  template <class S>
  void hold(int t, Lanes<S>& lanes) const;
  template <class S>
  void roll(int t, std::span<const S> x, Lanes<S>& lanes);
  template <class S>
  void pull(Lanes<S>& lanes, std::span<S> pi_bar = {}, std::span<S> theta_bar = {});
  void linearise(int t, const Eigen::VectorXd& x, Eigen::VectorXd& f, Eigen::MatrixXd& A,
                 Eigen::MatrixXd* B);

  const signals::Recording* recording_;
  int n_, nz_;
  smc::Gaussian initial_;
  Eigen::MatrixXd Q_, C_, R_;
  std::vector<smc::Part> parts_;
  Lanes<double> one_;
  Lanes<PackD> wide_;
  Lanes<PackF> narrow_;
  std::vector<PackD> broadcast_, pi_bar_, theta_bar_;
};
static_assert(smc::StateSpaceModel<LatentFrictionModel>);

}  // namespace fricid::estimate
