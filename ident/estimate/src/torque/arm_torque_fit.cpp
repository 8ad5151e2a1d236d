#include "fricid/estimate/torque/arm_torque_fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/estimate/torque/folds.hpp"
#include "fricid/friction/tangent.hpp"
#include "fricid/optimise/damped_step.hpp"
#include "friction/friction_search.hpp"
#include "friction/ripple_search.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "rigid_body/regression.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kDifference = 1e-5;  // of the Jacobian, in coordinates
constexpr double kLongestStep = 1;    // of one iteration in any coordinate
// Pull to where a step starts. Half of the squares counts data: a coordinate moves by its own size
// for a gain of one datum. Without it a step wanders along what the data leave open, above all
// where a link's pseudo-inertia is nearly singular and its coordinates hardly act.
constexpr double kStepRidge = 1;
// A weight w of a network counts like a row in which the torque errs by this share of Fn w.
constexpr double kOutputPull = 0.5, kInputPull = 0.15;
// Static friction counts like a row in which the torque errs by sigma where it differs from Coulomb
// friction by this share of the greater: motion that never rests says little of it. At half of it a
// UR10, which has a fifth of the friction at rest, errs up to a third more.
constexpr double kStaticPull = 0.1;
constexpr double kBlock = 1;  // of rows that depend on each other [s]
constexpr double kFewestBlocks = 10;
constexpr int kMostHalvings = 6;  // of a draw
constexpr std::uint64_t kDrawStream = 1 << 21;
constexpr double kFirstGain = 1e-2;  // smallest gain of a pass that another follows

/// A joint's friction and its place in theta.
struct JointModel {
  friction::RobotFriction one;
  std::size_t begin, size;
};

std::vector<JointModel> joint_models(const friction::RobotFriction& model) {
  std::vector<JointModel> out;
  for (int j = 0; j < model.joint_count(); ++j) {
    const auto begin = static_cast<std::size_t>(model.parameter_begin(j));
    const auto end = static_cast<std::size_t>(model.parameter_begin(j + 1));
    out.push_back({friction::RobotFriction({model.joints()[static_cast<std::size_t>(j)]}), begin,
                   end - begin});
  }
  return out;
}

/// d F[f] / d theta_p at the rows that count, for the parameters `wanted` of one joint, by forward
/// differences, one parameter per lane. @param slope  dtheta_p/dc: size of a change
Eigen::MatrixXd friction_jacobian(const ArmTorqueData::Joint& joint,
                                  const friction::RobotFriction& one, std::span<const double> theta,
                                  const std::vector<std::size_t>& wanted,
                                  const Eigen::VectorXd& slope) {
  constexpr std::size_t kColumns = PackD::kLanes - 1;  // lane 0 holds theta itself
  Eigen::MatrixXd J(joint.tau.size(), std::ssize(wanted));
  std::vector<double> step;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const double h = kDifference * slope[static_cast<Eigen::Index>(i)];
    step.push_back(theta[wanted[i]] + h < one.parameters()[wanted[i]].info.upper ? h : -h);
  }
  std::vector<PackD> lanes, out, work;
  for (std::size_t first = 0; first < wanted.size(); first += kColumns) {
    const std::size_t count = std::min(kColumns, wanted.size() - first);
    lanes.assign(theta.begin(), theta.end());
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t p = wanted[first + i];
      lanes[p].set(static_cast<int>(i) + 1, theta[p] + step[first + i]);
    }
    Eigen::Index r = 0;
    for (std::size_t s = 0; s < joint.row.size(); ++s) {
      joint.friction.residual(one, lanes, static_cast<int>(s), out, work);
      for (const int k : joint.row[s]) {
        const PackD& e = out[static_cast<std::size_t>(k)];
        for (std::size_t i = 0; i < count; ++i)
          J(r, static_cast<Eigen::Index>(first + i)) =
              (e[static_cast<int>(i) + 1] - e[0]) / step[first + i];
        ++r;
      }
    }
  }
  return J;
}

/// Coulomb friction of the law whose static friction theta[p] is; nothing where it is another
/// parameter.
std::optional<double> coulomb_beside(const friction::Friction& friction, std::size_t p) {
  const std::vector<friction::ParameterRef>& parameters = friction.model.parameters();
  if (parameters[p].info.role != friction::Role::kStatic) return {};
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].joint == parameters[p].joint && parameters[i].law == parameters[p].law &&
        parameters[i].info.role == friction::Role::kCoulomb)
      return friction.theta[i];
  return {};
}

/// The objective of one pass, sigma held.
class Problem {
 public:
  Problem(const ArmTorqueData& data, const ArmPoint& start, const ArmTorqueOptions& options,
          int jobs)
      : data_(data),
        models_(joint_models(start.arm().friction.model)),
        point_(start),
        jobs_(jobs),
        precision_(prior(start.arm().robot, options)),
        centre_(options.nominal) {
    sigma_.resize(data.n());
    for (int j = 0; j < data.n(); ++j) {
      const Eigen::VectorXd& tau = data.joint(j).tau;
      const double rows = std::max<double>(1, static_cast<double>(tau.size()));
      sigma_[j] = std::max({std::sqrt(data.residual(start.arm(), j).squaredNorm() / rows),
                            kSmallestSigma * std::sqrt(tau.squaredNorm() / rows), 1e-12});
    }
    add_pulls(options.friction_prior, options.pull_static);
  }

  double value(const Eigen::VectorXd& c) {
    point_.move_to(c);
    std::vector<double> sum(models_.size());
    parallel_for(data_.n(), jobs_, [&](int j) {
      sum[static_cast<std::size_t>(j)] =
          data_.residual(point_.arm(), j).squaredNorm() / (sigma_[j] * sigma_[j]);
    });
    const Eigen::VectorXd off = point_.arm().robot.pi - centre_;
    double total = off.dot(precision_ * off);
    for (const double s : sum) total += s;
    for (const Pull& pull : pulls_) {
      const double d = point_.arm().friction.theta[pull.theta] - pull.centre;
      total += pull.weight * d * d;
    }
    return std::isfinite(total) ? total : kBadValue;
  }

  /// Step from c that leaving a block of rows out makes, (H - B'B)^-1 B'e with B, e its rows of the
  /// Jacobian and of the residual over sigma (coordinates, blocks). A block is a second of all
  /// recordings of one motion.
  Eigen::MatrixXd deletions(const Eigen::VectorXd& c, const Eigen::MatrixXd& H) {
    point_.move_to(c);
    const Arm& arm = point_.arm();
    const Eigen::Index p = arm.robot.pi.size(), all = point_.coordinates().size(),
                       rest = all - std::ssize(point_.coordinates().friction());
    const Eigen::MatrixXd by_c = point_.jacobian();
    struct Part {
      optimise::Block block;
      Eigen::MatrixXd J, Y;  // by friction, by the rest
      Eigen::VectorXd e;
      std::vector<std::vector<Eigen::Index>> rows;  // of each block
    };
    const std::vector<int> first = first_blocks();
    std::vector<Part> parts(models_.size());
    parallel_for(data_.n(), jobs_, [&](int j) {
      const auto i = static_cast<std::size_t>(j);
      const ArmTorqueData::Joint& joint = data_.joint(j);
      Part& part = parts[i];
      part.block = block_of(models_[i]);
      const JointFrictionData::Linear at =
          friction_rows_and_slopes(joint, models_[i], part.block, by_c);
      part.J = at.J / sigma_[j];
      part.Y = joint.Y * by_c.topRightCorner(p, rest) / sigma_[j];
      part.e = (joint.Y * arm.robot.pi + at.f - joint.tau) / sigma_[j];
      part.rows.resize(static_cast<std::size_t>(first.back()));
      Eigen::Index r = 0;
      for (std::size_t s = 0; s < joint.row.size(); ++s)
        for (const int k : joint.row[s])
          part.rows[static_cast<std::size_t>(first[s] + k / block_length(s))].push_back(r++);
    });
    Eigen::MatrixXd out(all, first.back());
    parallel_for(first.back(), jobs_, [&](int b) {
      Eigen::MatrixXd left = H;
      Eigen::VectorXd score = Eigen::VectorXd::Zero(all);
      for (const Part& part : parts) {
        const std::vector<Eigen::Index>& rows = part.rows[static_cast<std::size_t>(b)];
        const Eigen::MatrixXd J = part.J(rows, Eigen::all), Y = part.Y(rows, Eigen::all);
        const Eigen::VectorXd e = part.e(rows);
        const auto [begin, size] = part.block;
        left.block(begin, begin, size, size).noalias() -= J.transpose() * J;
        const Eigen::MatrixXd beside = Y.transpose() * J;
        left.block(all - rest, begin, rest, size) -= beside;
        left.block(begin, all - rest, size, rest) -= beside.transpose();
        left.bottomRightCorner(rest, rest).noalias() -= Y.transpose() * Y;
        score.segment(begin, size) += J.transpose() * e;
        score.tail(rest) += Y.transpose() * e;
      }
      out.col(b) = left.ldlt().solve(score);
    });
    return out;
  }

  optimise::Quadratic linearise(const Eigen::VectorXd& c, double known) {
    point_.move_to(c);
    const Arm& arm = point_.arm();
    const ArmCoordinates& coordinates = point_.coordinates();
    const Eigen::Index p = arm.robot.pi.size(), all = coordinates.size(),
                       of_friction = std::ssize(coordinates.friction()), rest = all - of_friction;
    const Eigen::MatrixXd by_c = point_.jacobian();
    const Eigen::MatrixXd G = by_c.topRightCorner(p, rest);  // dpi / d(the rest)
    struct Part {
      optimise::Block block;
      Eigen::MatrixXd D, B;
      Eigen::VectorXd g, g_pi;
      double square = 0;
    };
    std::vector<Part> parts(models_.size());
    parallel_for(data_.n(), jobs_, [&](int j) {
      const auto i = static_cast<std::size_t>(j);
      const ArmTorqueData::Joint& joint = data_.joint(j);
      Part& part = parts[i];
      part.block = block_of(models_[i]);
      const double w = 1 / (sigma_[j] * sigma_[j]);
      // columns by coordinate: of theta_p, times dtheta_p/dc
      JointFrictionData::Linear at = friction_rows_and_slopes(joint, models_[i], part.block, by_c);
      const Eigen::VectorXd e = joint.Y * arm.robot.pi + at.f - joint.tau;
      part.D.noalias() = w * at.J.transpose() * at.J;
      part.B.noalias() = w * (joint.Y.transpose() * at.J);
      part.g.noalias() = w * at.J.transpose() * e;
      part.g_pi.noalias() = w * joint.Y.transpose() * e;
      part.square = w * e.squaredNorm();
    });

    Eigen::MatrixXd R = precision_;
    const Eigen::VectorXd d = arm.robot.pi - centre_;
    Eigen::VectorXd g_pi = precision_ * d;
    optimise::Quadratic out{d.dot(g_pi), Eigen::VectorXd(all), Eigen::MatrixXd::Zero(all, all), {}};
    for (int j = 0; j < data_.n(); ++j) {
      const Part& part = parts[static_cast<std::size_t>(j)];
      const auto [begin, size] = part.block;
      R += data_.joint(j).YY / (sigma_[j] * sigma_[j]);
      g_pi += part.g_pi;
      out.value += part.square;
      out.blocks.push_back(part.block);
      out.g.segment(begin, size) = part.g;
      out.H.block(begin, begin, size, size) = part.D;
      out.H.block(of_friction, begin, rest, size).noalias() = G.transpose() * part.B;
      out.H.block(begin, of_friction, size, rest) =
          out.H.block(of_friction, begin, rest, size).transpose();
    }
    out.g.tail(rest).noalias() = G.transpose() * g_pi;
    out.H.bottomRightCorner(rest, rest).noalias() = G.transpose() * R * G;
    for (const Pull& pull : pulls_) {
      const double off = arm.friction.theta[pull.theta] - pull.centre,
                   slope = by_c(p + static_cast<Eigen::Index>(pull.theta), pull.coordinate);
      out.value += pull.weight * off * off;
      out.g[pull.coordinate] += pull.weight * off * slope;
      out.H(pull.coordinate, pull.coordinate) += pull.weight * slope * slope;
    }
    // the objective is value + 2 g'dx + dx'H dx; its quadratic is half of that
    if (!std::isnan(known)) out.value = known;
    return out;
  }

 private:
  static Eigen::MatrixXd prior(dynamics::RobotModel robot, const ArmTorqueOptions& options) {
    robot.pi = options.nominal;
    if (has_prior(options.rigid_body)) return prior_precision(robot, options.rigid_body);
    const Eigen::MatrixXd pull = weak_pull(robot, options.rigid_body.guesses);
    return pull.transpose() * pull;
  }

  /// Coordinates of one joint's friction.
  optimise::Block block_of(const JointModel& model) const {
    const std::vector<std::size_t>& theta = point_.coordinates().friction();
    const auto first = std::ranges::lower_bound(theta, model.begin);
    const auto last = std::ranges::lower_bound(theta, model.begin + model.size);
    return {first - theta.begin(), last - first};
  }

  /// F[f] and its derivatives by the coordinates of a joint's friction.
  JointFrictionData::Linear friction_rows_and_slopes(const ArmTorqueData::Joint& joint,
                                                     const JointModel& model,
                                                     const optimise::Block& block,
                                                     const Eigen::MatrixXd& by_c) const {
    const Arm& arm = point_.arm();
    const std::span<const double> theta =
        std::span(arm.friction.theta).subspan(model.begin, model.size);
    std::vector<std::size_t> wanted;
    Eigen::VectorXd slope(block.size);
    for (Eigen::Index k = 0; k < block.size; ++k) {
      const std::size_t p =
          point_.coordinates().friction()[static_cast<std::size_t>(block.begin + k)];
      wanted.push_back(p - model.begin);
      slope[k] = by_c(arm.robot.pi.size() + static_cast<Eigen::Index>(p), block.begin + k);
    }
    JointFrictionData::Linear at =
        friction::Tangent::is_known(model.one)
            ? joint.friction.linearise(model.one, theta, wanted, joint.row)
            : JointFrictionData::Linear{joint.predict(model.one, theta),
                                        friction_jacobian(joint, model.one, theta, wanted, slope)};
    at.J *= slope.asDiagonal();
    joint.centre(at.f);
    joint.centre(at.J);
    return at;
  }

  int block_length(std::size_t recording) const {
    return std::max(1, static_cast<int>(std::lround(kBlock / data_.recordings()[recording].dt)));
  }

  /// First block of each recording, and behind them the number of blocks.
  std::vector<int> first_blocks() const {
    std::vector<int> first(data_.recordings().size() + 1);
    for (const std::vector<int>& motion : by_motion(data_.recordings())) {
      int most = 0;
      for (const int recording : motion) {
        const auto s = static_cast<std::size_t>(recording);
        first[s] = first.back();
        const int length = block_length(s);
        most = std::max(most, (data_.recordings()[s].length() + length - 1) / length);
      }
      first.back() += most;
    }
    return first;
  }

  /// A parameter of friction, where it is pulled to and how hard.
  struct Pull {
    std::size_t theta;
    Eigen::Index coordinate;
    double centre, weight;
  };

  /// Small weights of networks, or those of the prior, and static friction equal to Coulomb
  /// friction are what the data have to move; with a prior the other parameters too.
  void add_pulls(const std::optional<FrictionPrior>& prior, bool pull_static) {
    using enum friction::Role;
    const friction::Friction& friction = point_.arm().friction;
    const std::vector<std::size_t>& moved = point_.coordinates().friction();
    const Eigen::MatrixXd by_c = point_.jacobian();
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const friction::ParameterRef& p = friction.model.parameters()[moved[i]];
      const auto c = static_cast<Eigen::Index>(i);
      const double known = prior ? prior->theta[moved[i]] : 0;
      if (const std::optional<double> Fc = coulomb_beside(friction, moved[i]); Fc && pull_static)
        pulls_.push_back({moved[i], c, *Fc,
                          1 / std::pow(kStaticPull * std::max(*Fc, friction.theta[moved[i]]), 2)});
      if (p.joint != friction::kWholeRobot && friction::is_weight(p.info.role)) {
        const int scale = friction::find_parameter(friction.model, p.joint, kNetworkTorque);
        const double size = (p.info.role == kOutputWeight ? kOutputPull : kInputPull) *
                            friction.theta[static_cast<std::size_t>(scale)] / sigma_[p.joint];
        pulls_.push_back({moved[i], c, known, size * size});
      } else if (prior && p.info.role != kWaveNumber && p.info.role != kAmplitude &&
                 p.info.role != kPhase) {
        const double size =
            p.info.scale == friction::Scale::kLog
                ? std::abs(known)
                : by_c(point_.arm().robot.pi.size() + static_cast<Eigen::Index>(moved[i]), c);
        pulls_.push_back({moved[i], c, known, 1 / std::pow(prior->sd * size, 2)});
      }
    }
  }

  const ArmTorqueData& data_;
  std::vector<JointModel> models_;
  std::vector<Pull> pulls_;
  ArmPoint point_;
  int jobs_;
  Eigen::MatrixXd precision_;
  Eigen::VectorXd centre_, sigma_;
};

/// Where theta has ripples without amplitude.
std::vector<std::size_t> unknown_ripples(const friction::Friction& friction) {
  std::vector<std::size_t> terms = ripple_terms(friction.model);
  std::erase_if(terms, [&](std::size_t i) { return friction.theta[ripple_amplitude(i)] != 0; });
  return terms;
}

/// Looks for ripples in what the arm leaves of the torque.
void find_ripples(const ArmTorqueData& data, const std::vector<std::size_t>& terms, Arm& arm,
                  int jobs) {
  const FrictionTorques target = friction_target(arm.robot, arm.robot.pi, data.recordings(), jobs);
  const std::vector<JointModel> models = joint_models(arm.friction.model);
  parallel_for(data.n(), jobs, [&](int j) {
    const JointModel& joint = models[static_cast<std::size_t>(j)];
    std::vector<std::size_t> own;
    for (const std::size_t term : terms)
      if (term >= joint.begin && term < joint.begin + joint.size) own.push_back(term - joint.begin);
    const JointFrictionData left(data.recordings(), target, j, data.cutoff_hz());
    seed_ripples(left, joint.one, own,
                 std::span(arm.friction.theta).subspan(joint.begin, joint.size));
  });
}

}  // namespace

TorquePull torque_pull(const ArmTorqueData& data, const Arm& fitted,
                       const ArmTorqueOptions& options, int jobs) {
  const ArmCoordinates coordinates(fitted, options.coordinates);
  ArmPoint point(coordinates, fitted);
  point.move_to(point.c());
  Problem problem(data, point, options, jobs);
  return {point.c(), problem.linearise(point.c(), std::numeric_limits<double>::quiet_NaN())};
}

ArmErrors arm_errors(const ArmTorqueData& data, const Arm& fitted, const ArmTorqueOptions& options,
                     int count, std::uint64_t seed, int jobs) {
  const ArmCoordinates coordinates(fitted, options.coordinates);
  ArmPoint point(coordinates, fitted);
  point.move_to(point.c());
  const Eigen::VectorXd c = point.c();
  Problem problem(data, point, options, jobs);
  const optimise::Quadratic at = problem.linearise(c, std::numeric_limits<double>::quiet_NaN());
  Eigen::MatrixXd H = at.H;
  H.diagonal().array() += kStepRidge;
  Eigen::MatrixXd moves = problem.deletions(c, H);
  const auto blocks = static_cast<double>(moves.cols());
  if (blocks < kFewestBlocks) return {};
  moves.colwise() -= moves.rowwise().mean().eval();
  moves *= std::sqrt((blocks - 1) / blocks);
  RowMatrix w(count, moves.cols());
  fill_normal(seed, kDrawStream, 0, {w.data(), static_cast<std::size_t>(w.size())});
  const double least = problem.value(c);
  ArmErrors errors{.root = point.jacobian() * moves, .draws = {}};
  // of shares of a sum of one, whatever the data leave of the sum
  for (const std::vector<std::size_t>& law : friction::shares(fitted.friction.model)) {
    const auto row_of = [&](std::size_t i) {
      return errors.root.row(fitted.robot.pi.size() + static_cast<Eigen::Index>(i));
    };
    Eigen::RowVectorXd of_sum = Eigen::RowVectorXd::Zero(errors.root.cols());
    double sum = 0;
    for (const std::size_t i : law) {
      of_sum += row_of(i);
      sum += fitted.friction.theta[i];
    }
    for (const std::size_t i : law) row_of(i) -= fitted.friction.theta[i] / sum * of_sum;
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXd move = moves * w.row(i).transpose();
    const auto is_quadratic = [&] {
      const double rise = problem.value(coordinates.box().clamp(c + move)) - least;
      return rise - 2 * at.g.dot(move) < 2 * move.dot(at.H * move);
    };
    for (int half = 0; half < kMostHalvings && !is_quadratic(); ++half) move /= 2;
    point.move_to(coordinates.box().clamp(c + move));
    errors.draws.push_back(point.arm());
  }
  return errors;
}

ArmTorqueFit fit_arm_torque(const ArmTorqueData& data, const Arm& start,
                            const ArmTorqueOptions& options, int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  ArmTorqueFit fit;
  fit.arm = start;
  bool converged = false;
  const std::vector<std::size_t> sought =
      options.find_ripples ? unknown_ripples(start.friction) : std::vector<std::size_t>();
  const int passes = sought.empty() ? 1 : 2;
  for (int pass = 0; pass < passes; ++pass) {
    const bool before = pass + 1 < passes;
    if (passes > 1 && !before) find_ripples(data, sought, fit.arm, jobs);
    CoordinateOptions frame = options.coordinates;
    if (before)
      for (const std::size_t term : sought) frame.limits.push_back({ripple_amplitude(term), 0, 0});
    const ArmCoordinates coordinates(fit.arm, frame);
    ArmPoint point(coordinates, fit.arm);
    point.move_to(point.c());
    Problem problem(data, point, options, jobs);
    const optimise::Minimum found = optimise::damped_least_squares(
        [&](const Eigen::VectorXd& c, double value) { return problem.linearise(c, value); },
        [&](const Eigen::VectorXd& c) { return problem.value(c); }, coordinates.box(),
        {point.c(), std::numeric_limits<double>::quiet_NaN()},
        {.damping = {.longest = kLongestStep,
                     .keep_direction = true,
                     .ridge = kStepRidge,
                     .attempts = 8,
                     .lessen = 10,
                     .least = 1e-9,
                     .most = 1e8,
                     .hold_at_bounds = true},
         .iterations = options.iterations,
         .smallest_gain = before ? kFirstGain : options.smallest_gain});
    point.move_to(found.c);
    fit.arm = point.arm();
    converged = found.converged;
  }
  fit.sigma.resize(data.n());
  for (int j = 0; j < data.n(); ++j)
    fit.sigma[j] = std::sqrt(data.residual(fit.arm, j).squaredNorm() /
                             std::max<double>(1, static_cast<double>(data.joint(j).tau.size())));
  const bool finite = fit.sigma.allFinite() && fit.arm.robot.pi.allFinite();
  fit.outcome = !finite     ? Outcome::kFailed
                : converged ? Outcome::kConverged
                            : Outcome::kIterationLimit;
  fit.message = finite ? "friction and rigid body fitted together" : "no finite prediction";
  fit.seconds = seconds_since(begin);
  return fit;
}

}  // namespace fricid::estimate
