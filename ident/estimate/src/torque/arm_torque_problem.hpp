// The squares of the torque of all joints, as a function of friction and rigid body together.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/friction/motion_errors.hpp"
#include "fricid/estimate/torque/arm_torque_data.hpp"
#include "fricid/estimate/torque/arm_torque_fit.hpp"
#include "fricid/optimise/damped_step.hpp"

namespace fricid::estimate {

// Pull to where a step starts. Half of the squares counts data: a coordinate moves by its own size
// for a gain of one datum. Without it a step wanders along what the data leave open, above all
// where a link's pseudo-inertia is nearly singular and its coordinates hardly act.
inline constexpr double kStepRidge = 1;

/// A joint's friction and its place in theta.
struct JointModel {
  friction::RobotFriction one;
  std::size_t begin, size;
};

std::vector<JointModel> joint_models(const friction::RobotFriction& model);

/// Coordinates of the rigid body in derivatives. Those of `ArmCoordinates` keep it physical, but a
/// link at the edge of what is physical hardly moves with them, whatever the data say of it.
enum class BodyCoordinates { kPhysical, kPi };

/// The objective of one pass of `fit_arm_torque`, sigma held.
class ArmTorqueProblem {
 public:
  /// @param start  sets sigma; the coordinates are its own
  /// @param body   of `linearise`, `rows_at` and what is made of them; points are in c all the same
  ArmTorqueProblem(const ArmTorqueData& data, const ArmPoint& start,
                   const ArmTorqueOptions& options, int jobs,
                   BodyCoordinates body = BodyCoordinates::kPhysical);

  /// Half of the squares over sigma^2, and of the pulls.
  double value(const Eigen::VectorXd& c);
  /// A joint's derivatives are those of an earlier c while they foretell its residual within a
  /// tenth; the gradient's residual is that at c.
  /// @param known  the value at c, if it is; NaN otherwise
  optimise::Quadratic linearise(const Eigen::VectorXd& c, double known);

  /// Makes `linearise` take all derivatives anew. @return whether the last took any from earlier
  bool forget_slopes();

  /// Rows of a joint over its sigma.
  struct Rows {
    optimise::Block block;
    Eigen::MatrixXd J, Y;  ///< derivatives by its friction, and by what is not friction
    Eigen::VectorXd e;
  };
  std::vector<Rows> rows_at(const Eigen::VectorXd& c);

  /// d(pi, theta) by the coordinates of the derivatives, where `rows_at` was called last.
  Eigen::MatrixXd jacobian() const;

  /// J'm (coordinates, n) with m the error of each joint's rows that the motion makes
  /// (`MotionErrors`).
  /// @param rows  where `rows_at` was called last
  Eigen::MatrixXd motion_scores(const std::vector<Rows>& rows, const MotionErrors& motion) const;
  /// J'm (coordinates) with m the error of all rows that an unknown timing of the torque makes.
  Eigen::VectorXd timing_score(const std::vector<Rows>& rows) const;

  /// N'N over the squares of sigma (p x p), N being what noise of the encoders adds to the
  /// regressor of the rows (`motion_of_noise`).
  Eigen::MatrixXd noise_information() const;

  /// Step that leaving a passage of rows out makes (`TimeBlocks`, of a second), (H - B'B)^-1 B'e
  /// with B, e its rows of the Jacobian and of the residual over sigma (coordinates, passages).
  Eigen::MatrixXd deletions(const std::vector<Rows>& all_rows, const Eigen::MatrixXd& H) const;

 private:
  /// A parameter of friction, where it is pulled to and how hard.
  struct Pull {
    std::size_t theta;
    Eigen::Index coordinate;
    double centre, weight;
  };

  /// A joint's rows where they were linearised last.
  struct Slopes {
    optimise::Block block{};
    Eigen::VectorXd c, pi, e;  ///< its friction's coordinates, the rigid body, the residual [N m]
    Eigen::MatrixXd J, D, B;   ///< de/dc; J'J and Y'J over sigma^2
    bool is_kept = false;      ///< `linearise` took them from an earlier point
  };

  /// Whether joint j's slopes foretell its residual where the value was taken last.
  bool slopes_hold(int j, const Eigen::VectorXd& c) const;
  /// Linearises joint j's rows anew.
  void take_slopes(int j, const Eigen::VectorXd& c, const Eigen::MatrixXd& by_c);
  std::span<const double> theta_of(const JointModel& model) const;
  /// J'm (coordinates, n). @param errors  m of a joint's rows [N m]
  Eigen::MatrixXd scores_of(const std::vector<Rows>& rows,
                            const std::function<Eigen::VectorXd(int)>& errors) const;
  /// Coordinates of one joint's friction.
  optimise::Block block_of(const JointModel& model) const;
  /// F[f] and its derivatives by the coordinates of a joint's friction.
  JointFrictionData::Linear friction_rows_and_slopes(const ArmTorqueData::Joint& joint,
                                                     const JointModel& model,
                                                     const optimise::Block& block,
                                                     const Eigen::MatrixXd& by_c) const;
  /// Small weights of networks, or those of the prior, and static friction equal to Coulomb
  /// friction are what the data have to move; with a prior the other parameters too.
  void add_pulls(const std::optional<FrictionPrior>& prior, bool pull_static);

  const ArmTorqueData& data_;
  BodyCoordinates body_;
  std::vector<JointModel> models_;
  std::vector<Pull> pulls_;
  ArmPoint point_;
  int jobs_;
  Eigen::MatrixXd precision_;
  Eigen::VectorXd centre_, sigma_;
  std::vector<Slopes> slopes_;
  std::vector<Eigen::VectorXd> residual_;  // of each joint's rows, where they were taken last
  Eigen::VectorXd valued_at_;              // c of that
};

}  // namespace fricid::estimate
