// Fit of one joint's friction law to the torque that the rigid body does not explain.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "fricid/base/pack.hpp"
#include "fricid/estimate/friction/motion_pieces.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/time_blocks.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/signals/decimated_low_pass.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// A sine in the joint angle that would scale friction, (1 + A sin(n q + phi)), and what it leaves.
struct RippleTerm {
  double n = 0;            ///< periods per 2 pi
  double A = 0;            ///< relative amplitude
  double phi = 0;          ///< [rad]
  double mean_square = 0;  ///< of the residual with it [N^2 m^2]
};

/// Orders n that a ripple is looked for at: first, first + step, ..
struct RippleGrid {
  double first, step;
  int count;
};

/// Prior of the constant torque c beside a law: c ~ N(0, sd^2). Per row, the objective gains
/// weight c^2.
struct OffsetPrior {
  double sd = std::numeric_limits<double>::infinity();  ///< [N m]
  double weight = 0;                                    ///< [1]
};

/// A value per sample of every sequence.
using PerSample = std::vector<std::vector<double>>;

/// How recordings drive friction.
struct FrictionDrive {
  int steps = 1;                                 ///< in a sample
  std::span<const signals::Motion> motion = {};  ///< per recording; empty: their wide motion
};

/// What one joint's friction has to explain: its inputs and its target torque over all sequences.
///
/// The model is driven by the measured, wide-band motion ("teacher forcing"): with z_0 = 0,
///
///     f_k     = torque(theta; q_k, v_k, load_k, z_k)         v_k central difference
///     z_{k+1} = step(theta; q_{k+1}, (q_{k+1} - q_k) / dt, load_k, dt, z_k)
///
/// (`drive_friction`). With several steps in a sample q follows a cubic curve between the samples
/// (`signals::between_samples`). F[f] + c, through the filter of the measured torque, is compared
/// with the target at used rows. The constant c is whatever fits best: without it a law that
/// differs between the directions could not be told from an offset. It has a prior where the data
/// do not tell it from friction, as in a joint that slides in one direction. It belongs to no
/// model: the constant torque of a joint is the rigid body's.
///
/// Sequences are cut into pieces that are driven side by side (`cut_motion`). Where pieces meet,
/// the state of the one is compared with that of the next; friction that has not forgotten its
/// start there is driven again, each sequence in one piece.
class JointFrictionData {
 public:
  /// @param target  per sequence, torque of every joint that friction must explain (T, n) [N m];
  ///                empty: nothing is compared
  /// @param ranges  per sequence, samples at which torque is predicted, 0 elsewhere, and beyond
  ///                which the filter sees nothing; empty: all
  JointFrictionData(std::span<const signals::Recording> sequences,
                    std::span<const RowMatrix> target, int joint, double cutoff_hz,
                    const OffsetPrior& prior = {}, std::span<const SampleRange> ranges = {},
                    const FrictionDrive& how = {});

  /// From now on a single spring (maxwell_slip of one element) begins each sequence deflected by so
  /// much [rad or m], within its cap; at first by nothing. A short spring forgets that at once.
  void begin_springs_at(std::vector<double> deflection) { spring_ = std::move(deflection); }
  const std::vector<double>& springs() const { return spring_; }  ///< empty: not deflected

  /// F[f].
  /// @param friction  structure of one joint
  PerSample predict(const friction::RobotFriction& friction, std::span<const double> theta) const;

  /// Mean square of F[f] + c - target over the used rows, with what the prior of c adds [N^2 m^2];
  /// infinity when not finite.
  double mean_square(const friction::RobotFriction& friction, std::span<const double> theta) const;

  /// c: mean of target - F[f] over the used rows, less what its prior takes [N m].
  double offset(const friction::RobotFriction& friction, std::span<const double> theta) const;

  /// F[f] - target of one sequence for eight parameter vectors at once (one per lane), without c; 0
  /// at unused rows.
  void residual(const friction::RobotFriction& friction, std::span<const PackD> theta, int sequence,
                std::vector<PackD>& out, std::vector<PackD>& work) const;

  /// F[f] and its derivatives at chosen samples.
  struct Linear {
    Eigen::VectorXd f;  ///< (rows) [N m]
    Eigen::MatrixXd J;  ///< (rows x wanted) dF[f] / dtheta_p
  };
  /// At the samples row[s] of every sequence, by sensitivities carried forward with the state.
  /// @param wanted  indices in theta
  /// @pre friction::Tangent::is_known(friction)
  Linear linearise(const friction::RobotFriction& friction, std::span<const double> theta,
                   std::span<const std::size_t> wanted,
                   std::span<const std::vector<int>> row) const;

  /// Largest |df/dload| at the samples, at twice the load: friction that is part of its own load
  /// has a value only where this is below one, and a prediction may err.
  double load_gain(const friction::RobotFriction& friction, std::span<const double> theta) const;

  /// The ripple that explains most of what F[f] leaves: by linear regression (amplitudes enter
  /// linearly as long as they are small) at the orders that a correlation of f with what is left
  /// finds promising. F is symmetric, so <e, F[f sin nq]> = <F[e], f sin nq>; the size of
  /// F[f sin nq] is taken from the filter's gain at n |v|.
  RippleTerm strongest_ripple(const friction::RobotFriction& friction,
                              std::span<const double> theta, const RippleGrid& grid) const;
  double travel() const { return travel_; }  ///< largest less smallest joint angle [rad]

  const OffsetPrior& offset_prior() const { return prior_; }
  /// Share of the mean of target - F[f] that c takes: 1 without a prior.
  double share_of_mean() const { return 1 / (1 + prior_.weight); }

  double dt() const { return dt_; }
  const TimeBlocks& blocks() const { return blocks_; }  ///< of a second
  int sequences() const { return static_cast<int>(series_.size()); }
  int length(int sequence) const {
    return static_cast<int>(series_[static_cast<std::size_t>(sequence)].at.size());
  }
  int rows() const { return rows_; }
  /// Samples of every sequence that are compared with the target.
  std::vector<std::vector<int>> used_rows() const;
  double target(int sequence, int sample) const {
    return series_[static_cast<std::size_t>(sequence)].target[static_cast<std::size_t>(sample)];
  }
  /// Of target - its mean over the used rows [N^2 m^2].
  double target_mean_square() const { return target_mean_square_; }
  double largest_target() const { return largest_target_; }

 private:
  /// One sequence.
  struct Series {
    SampleRange range;
    std::vector<friction::Input<double>> at;    // inputs of torque at sample k
    std::vector<friction::Input<double>> over;  // inputs of its steps over [t_k, t_{k+1})
    std::vector<double> target, weight;         // weight 1 at used rows, else 0

    std::size_t begin() const { return static_cast<std::size_t>(range.begin); }
    std::size_t size() const { return static_cast<std::size_t>(range.size()); }
  };
  /// Pieces side by side, one per lane; in the order of their samples from their starts on.
  struct Group {
    std::vector<MotionPiece> pieces;
    std::vector<friction::Input<PackD>> at, over;
  };
  struct Moments {
    double mean = 0, square = 0;  // of F[f] - target over the used rows
  };
  /// A lane and the sample that its piece has come to.
  struct LaneSample {
    int lane;
    std::size_t sequence, sample;
  };
  std::vector<Group> side_by_side(std::span<const MotionPiece> pieces) const;
  /// Along every group calls driver.reset(), driver.torque(in, z, lanes) where lanes are past their
  /// run-in, and driver.step(over, z) with the steps of a sample. Returns whether every piece
  /// begins in the state in which the one before it ends.
  template <class Driver>
  bool drive(std::span<const Group> groups, const friction::RobotFriction& friction,
             Driver& driver) const;
  /// Likewise, in pieces or, where friction does not forget, in whole sequences.
  template <class Driver>
  void drive(const friction::RobotFriction& friction, std::span<const double> theta,
             Driver& driver) const;
  /// f.
  PerSample unfiltered(const friction::RobotFriction& friction,
                       std::span<const double> theta) const;
  void low_pass(PerSample& x) const;
  /// The orders of a grid at which a ripple may explain most of F[f] - target.
  std::vector<double> promising_orders(const PerSample& f, const PerSample& filtered,
                                       const RippleGrid& grid) const;
  Moments moments(const friction::RobotFriction& friction, std::span<const double> theta) const;
  // What keeps f and its derivatives in `linearise` and filters them: at any row, and at rows that
  // `decimated_` is of.
  class AllColumns;
  class DecimatedColumns;
  bool are_decimated(std::span<const std::vector<int>> row) const;
  template <class Columns>
  Linear linearise_into(const friction::RobotFriction& friction, std::span<const double> theta,
                        std::span<const std::size_t> wanted,
                        std::span<const std::vector<int>> row) const;

  std::vector<Series> series_;
  std::vector<Group> groups_;
  std::vector<double> spring_;  // per sequence, deflection at its first sample; empty: 0
  OffsetPrior prior_;
  /// Inputs of the steps of friction over [t_k, t_{k+1}).
  template <class Input>
  std::span<const Input> over_sample(const std::vector<Input>& over, std::size_t k) const {
    const auto steps = static_cast<std::size_t>(steps_);
    return std::span(over).subspan(k * steps, steps);
  }
  double step_s() const { return dt_ / steps_; }

  double dt_, cutoff_hz_;
  TimeBlocks blocks_;
  int steps_;
  signals::ZeroPhaseButterworth low_pass_;
  signals::DecimatedLowPass decimated_;
  int rows_ = 0;
  double target_mean_square_ = 0, largest_target_ = 0, travel_ = 0;
  double run_in_ = 0;  // of the pieces [rad or m]
};

struct FrictionFitOptions {
  int starts = 4;  ///< the first from the data, the others spread around it
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;       ///< random stream, one per joint
  int evaluations = 200;          ///< of Nelder-Mead, per start; 16 per free parameter at most
  int iterations = 40;            ///< of Levenberg-Marquardt, per start
  double tolerance = 1e-4;        ///< of Nelder-Mead, on the scaled parameters
  std::vector<std::size_t> held;  ///< indices in theta of parameters that keep their start
  /// Error of F[f] at the used rows that the motion makes [N m], see `MotionErrors`; empty: none.
  std::function<Eigen::VectorXd(std::span<const double> theta)> motion_error;
  bool grows = false;  ///< whether the regression shows that friction grows with the load
};

/// Best parameters of one joint and how they were reached.
struct JointFrictionFit {
  Outcome outcome = Outcome::kFailed;
  std::string message = "fit_joint_friction was not called";
  std::vector<double> theta;  ///< (parameter_count)
  /// (parameter_count) with the rigid body known; NaN where held or on a bound.
  std::vector<double> standard_error;
  std::vector<double> motion_error;  ///< (parameter_count) part of it; NaN where not known
  /// Of the parameters in the coordinates of the search (logarithms where the table says so); NaN
  /// in rows and columns of those that have no standard error.
  Eigen::MatrixXd correlation;
  double offset = 0;                  ///< constant torque beside the law [N m]
  double rms = 0;                     ///< of the residual over used rows [N m]
  double explained = 0;               ///< 1 - residual / target mean square
  std::vector<double> start_rms;      ///< (starts) where each start ended [N m]
  std::vector<std::string> at_bound;  ///< symbols that ended on a bound
  /// Symbol of static friction that the motion does not show, which is taken as twice that of
  /// sliding; or none.
  std::vector<std::string> guessed = {};
  int evaluations = 0;
};

/// Minimises `mean_square` over theta within the bounds of the table, in coordinates that are
/// logarithms where the table says so: Nelder-Mead with bounds (NLopt) from several starts, each
/// followed by Levenberg-Marquardt on the residuals, with an active set at the bounds. The Jacobian
/// comes from sensitivities carried forward, of laws without any from finite differences (one
/// parameter per lane). Deterministic for (seed, stream).
JointFrictionFit fit_joint_friction(const JointFrictionData& data,
                                    const friction::RobotFriction& friction,
                                    std::vector<double> start, const FrictionFitOptions& options);

}  // namespace fricid::estimate
