#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/physical_inertia.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"

namespace fricid::estimate {
namespace {

constexpr double kSmallestArmature = 1e-9;  // a start for robots whose file states none [kg m^2]
constexpr double kFirstBarrier = 1e3, kLastBarrier = 1e-6;  // weights, in units of the cost
// .. the first at least this share of the cost at the start: under a lighter barrier the first
// steps end at the edge of the cone, along which the next ones crawl
constexpr double kShareOfCost = 0.1;
constexpr double kBarrierStep = 0.2;
constexpr int kNewtonSteps = 200;    // per barrier weight, at most; tiny bodies double in each
constexpr double kDecrement = 1e-9;  // squared Newton decrement that counts as converged
constexpr double kArmijo = 0.1;

// The cone of physical parameters: pseudo-inertia of each link positive definite, armature
// positive.
struct Cone {
  int n;
  bool rotors;                            // an armature behind each link
  std::array<Eigen::Matrix4d, 10> basis;  // d pseudo_inertia / d pi

  Cone(int links, bool with_rotors) : n(links), rotors(with_rotors) {
    for (int a = 0; a < 10; ++a)
      basis[static_cast<std::size_t>(a)] = dynamics::pseudo_inertia(dynamics::Vector10::Unit(a));
  }

  // - sum log det P_i - sum log Ia_i, infinite outside.
  double barrier(const Eigen::VectorXd& pi) const {
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const Eigen::LLT<Eigen::Matrix4d> llt(dynamics::pseudo_inertia(pi.segment<10>(10 * i)));
      const double armature = rotors ? pi[10 * n + i] : 1;
      if (llt.info() != Eigen::Success || !(armature > 0))
        return std::numeric_limits<double>::infinity();
      sum -= 2 * llt.matrixLLT().diagonal().array().log().sum() + std::log(armature);
    }
    return sum;
  }

  // Rows F and right-hand side r with Hessian F'F and gradient -F'r of the barrier: with P = L L',
  // column a of a link's block is vec(L^-1 E_a L^-T) and r is vec(1).
  void roots(const Eigen::VectorXd& pi, Eigen::Ref<Eigen::MatrixXd> F,
             Eigen::Ref<Eigen::VectorXd> r) const {
    F.setZero();
    for (int i = 0; i < n; ++i) {
      const Eigen::Matrix4d L = dynamics::pseudo_inertia(pi.segment<10>(10 * i)).llt().matrixL();
      const Eigen::Matrix4d inverse =
          L.triangularView<Eigen::Lower>().solve(Eigen::Matrix4d::Identity());
      for (int a = 0; a < 10; ++a) {
        const Eigen::Matrix4d f =
            inverse * basis[static_cast<std::size_t>(a)] * inverse.transpose();
        F.col(10 * i + a).segment<16>(rows_of_link() * i) = f.reshaped();
      }
      r.segment<16>(rows_of_link() * i) = Eigen::Matrix4d::Identity().reshaped();
      if (!rotors) continue;
      F(17 * i + 16, 10 * n + i) = 1 / pi[10 * n + i];
      r[17 * i + 16] = 1;
    }
  }
  int rows_of_link() const { return rotors ? 17 : 16; }
  int rows() const { return rows_of_link() * n; }
};

// Minimises 1/2 |G pi - d|^2 within the cone, from a start inside.
Eigen::VectorXd fit_within(const Cone& cone, const Eigen::MatrixXd& G, const Eigen::VectorXd& d,
                           Eigen::VectorXd pi) {
  const Eigen::Index m = G.rows(), p = pi.size();
  Eigen::MatrixXd stacked(m + cone.rows(), p);
  Eigen::VectorXd right(m + cone.rows());
  const double first = std::max(kFirstBarrier, kShareOfCost * 0.5 * (G * pi - d).squaredNorm());
  for (double mu = first; mu > kLastBarrier; mu *= kBarrierStep) {
    const auto cost = [&](const Eigen::VectorXd& x) {
      return 0.5 * (G * x - d).squaredNorm() + mu * cone.barrier(x);
    };
    double value = cost(pi);
    for (int iteration = 0; iteration < kNewtonSteps; ++iteration) {
      // Newton step as a least-squares problem, columns of unit length.
      stacked.topRows(m) = G;
      right.head(m) = d - G * pi;
      cone.roots(pi, stacked.bottomRows(cone.rows()), right.tail(cone.rows()));
      stacked.bottomRows(cone.rows()) *= std::sqrt(mu);
      right.tail(cone.rows()) *= std::sqrt(mu);
      const Eigen::VectorXd size = stacked.colwise().norm().transpose().cwiseMax(1e-300);
      const Eigen::VectorXd step = Eigen::MatrixXd(stacked * size.cwiseInverse().asDiagonal())
                                       .colPivHouseholderQr()
                                       .solve(right)
                                       .cwiseQuotient(size);
      const double decrement = right.dot(stacked * step);
      if (!(decrement > kDecrement * (1 + mu))) break;

      // Backtrack into the cone and to a sufficient decrease.
      double length = 1, trial_value = cost(pi + step);
      while (length > 1e-12 && !(trial_value < value - kArmijo * length * decrement)) {
        length /= 2;
        trial_value = cost(pi + length * step);
      }
      if (!(trial_value < value)) break;
      pi += length * step;
      value = trial_value;
    }
  }
  return pi;
}

}  // namespace

Eigen::VectorXd fit_physical_inertia(const dynamics::RobotModel& robot, const Eigen::MatrixXd& G,
                                     const Eigen::VectorXd& d, const Eigen::VectorXd& start) {
  Eigen::VectorXd pi = start;
  auto armatures = pi.segment(robot.armature_begin(), robot.n());
  armatures = armatures.cwiseMax(kSmallestArmature).eval();
  return fit_within(Cone(robot.n(), true), G, d, pi);
}

dynamics::Vector10 fit_physical_body(const Eigen::MatrixXd& G, const Eigen::VectorXd& d,
                                     const dynamics::Vector10& start) {
  return fit_within(Cone(1, false), G, d, start);
}

}  // namespace fricid::estimate
