// How near an identified rigid body is to the injected one.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/dynamics/workspace.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Largest torque, over the joints, that a unit of each base parameter makes along the recordings:
/// its RMS over the RMS of that joint's measured torque (b) [1 / unit of the parameter].
inline Eigen::VectorXd torque_share(const dynamics::RobotModel& robot,
                                    const dynamics::BaseParameters& base,
                                    std::span<const signals::Recording> sequences) {
  const int n = robot.n(), p = robot.parameter_count();
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd Y(n, p), square = Eigen::MatrixXd::Zero(n, p);
  Eigen::VectorXd torque = Eigen::VectorXd::Zero(n);
  for (const signals::Recording& s : sequences)
    for (int k = 0; k < s.length(); ++k) {
      const auto row = [&](const RowMatrix& x) {
        return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(n));
      };
      dynamics::regressor(robot, ws, row(s.narrow.q), row(s.narrow.v), row(s.narrow.a), Y);
      square += Y.cwiseAbs2();
      torque += s.filtered_tau.row(k).transpose().cwiseAbs2();
    }
  Eigen::VectorXd share(static_cast<Eigen::Index>(base.columns.size()));
  for (Eigen::Index i = 0; i < share.size(); ++i)
    share[i] = (square.col(base.columns[static_cast<std::size_t>(i)]).array() / torque.array())
                   .sqrt()
                   .maxCoeff();
  return share;
}

/// Expects every base parameter within `tolerance` of its own value; or, where it is so small that
/// this says nothing, that its error moves no joint's torque by more than tolerance / 10 of that
/// torque (RMS).
inline void expect_base_parameters(const dynamics::RobotModel& truth, const Eigen::VectorXd& found,
                                   std::span<const signals::Recording> sequences,
                                   double tolerance) {
  const dynamics::BaseParameters base = dynamics::base_parameters(truth);
  const Eigen::VectorXd expected = base.K * truth.pi;
  const Eigen::VectorXd share = torque_share(truth, base, sequences);
  ASSERT_EQ(found.size(), expected.size());
  for (Eigen::Index i = 0; i < expected.size(); ++i) {
    SCOPED_TRACE(base.names[static_cast<std::size_t>(i)]);
    EXPECT_NEAR(found[i], expected[i],
                std::max(tolerance * std::abs(expected[i]), 0.1 * tolerance / share[i]));
  }
}

}  // namespace fricid::estimate
