#include "torque/arm_torque_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/estimate/time_blocks.hpp"
#include "fricid/friction/tangent.hpp"
#include "friction/friction_search.hpp"
#include "rigid_body/dilution.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "rigid_body/regression.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kDifference = 1e-5;  // of the Jacobian, in coordinates
// A weight w of a network counts like a row in which the torque errs by this share of Fn w.
constexpr double kOutputPull = 0.5, kInputPull = 0.15;
// Static friction counts like a row in which the torque errs by sigma where it differs from Coulomb
// friction by this share of the greater: motion that never rests says little of it. At half of it a
// UR10, which has a fifth of the friction at rest, errs up to a third more.
constexpr double kStaticPull = 0.1;
// Derivatives of a joint are taken anew where they foretold its residual less well than this share
// of it.
constexpr double kStale = 0.1;

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

Eigen::MatrixXd prior(dynamics::RobotModel robot, const ArmTorqueOptions& options) {
  robot.pi = options.nominal;
  if (has_prior(options.rigid_body)) return prior_precision(robot, options.rigid_body);
  const Eigen::MatrixXd pull = weak_pull(robot, options.rigid_body.guesses);
  return pull.transpose() * pull;
}

}  // namespace

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

ArmTorqueProblem::ArmTorqueProblem(const ArmTorqueData& data, const ArmPoint& start,
                                   const ArmTorqueOptions& options, int jobs, BodyCoordinates body)
    : data_(data),
      body_(body),
      models_(joint_models(start.arm().friction.model)),
      point_(start),
      jobs_(jobs),
      precision_(prior(start.arm().robot, options)),
      centre_(options.nominal),
      slopes_(models_.size()),
      residual_(models_.size()) {
  sigma_.resize(data.n());
  for (int j = 0; j < data.n(); ++j) {
    const Eigen::VectorXd& tau = data.joint(j).tau;
    const double rows = std::max<double>(1, static_cast<double>(tau.size()));
    sigma_[j] = std::max({std::sqrt(data.residual(start.arm(), j).squaredNorm() / rows),
                          kSmallestSigma * std::sqrt(tau.squaredNorm() / rows), 1e-12});
  }
  add_pulls(options.friction_prior, options.pull_static);
}

double ArmTorqueProblem::value(const Eigen::VectorXd& c) {
  point_.move_to(c);
  std::vector<double> sum(models_.size());
  parallel_for(data_.n(), jobs_, [&](int j) {
    const auto i = static_cast<std::size_t>(j);
    residual_[i] = data_.residual(point_.arm(), j);
    sum[i] = residual_[i].squaredNorm() / (sigma_[j] * sigma_[j]);
  });
  valued_at_ = c;
  const Eigen::VectorXd off = point_.arm().robot.pi - centre_;
  double total = off.dot(precision_ * off);
  for (const double s : sum) total += s;
  for (const Pull& pull : pulls_) {
    const double d = point_.arm().friction.theta[pull.theta] - pull.centre;
    total += pull.weight * d * d;
  }
  return std::isfinite(total) ? total / 2 : kBadValue;
}

optimise::Quadratic ArmTorqueProblem::linearise(const Eigen::VectorXd& c, double known) {
  point_.move_to(c);
  const Arm& arm = point_.arm();
  const ArmCoordinates& coordinates = point_.coordinates();
  const Eigen::Index p = arm.robot.pi.size(), all = coordinates.size(),
                     of_friction = std::ssize(coordinates.friction()), rest = all - of_friction;
  const Eigen::MatrixXd by_c = jacobian();
  const Eigen::MatrixXd G = by_c.topRightCorner(p, rest);  // dpi / d(the rest)
  struct Gradient {
    Eigen::VectorXd friction, pi;
    double square = 0;
  };
  std::vector<Gradient> parts(models_.size());
  const bool is_valued = valued_at_.size() == c.size() && valued_at_ == c;
  parallel_for(data_.n(), jobs_, [&](int j) {
    const auto i = static_cast<std::size_t>(j);
    const ArmTorqueData::Joint& joint = data_.joint(j);
    const double w = 1 / (sigma_[j] * sigma_[j]);
    if (!is_valued || !slopes_hold(j, c))
      take_slopes(j, c, by_c);
    else
      slopes_[i].is_kept = true;
    const Eigen::VectorXd& e = residual_[i];
    parts[i].friction.noalias() = w * slopes_[i].J.transpose() * e;
    parts[i].pi.noalias() = w * joint.Y.transpose() * e;
    parts[i].square = w * e.squaredNorm();
  });
  valued_at_ = c;

  Eigen::MatrixXd R = precision_;
  const Eigen::VectorXd d = arm.robot.pi - centre_;
  Eigen::VectorXd g_pi = precision_ * d;
  optimise::Quadratic out{d.dot(g_pi), Eigen::VectorXd(all), Eigen::MatrixXd::Zero(all, all), {}};
  for (int j = 0; j < data_.n(); ++j) {
    const Gradient& part = parts[static_cast<std::size_t>(j)];
    const Slopes& slopes = slopes_[static_cast<std::size_t>(j)];
    const auto [begin, size] = slopes.block;
    R += data_.joint(j).YY / (sigma_[j] * sigma_[j]);
    g_pi += part.pi;
    out.value += part.square;
    out.blocks.push_back(slopes.block);
    out.g.segment(begin, size) = part.friction;
    out.H.block(begin, begin, size, size) = slopes.D;
    out.H.block(of_friction, begin, rest, size).noalias() = G.transpose() * slopes.B;
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
  out.value = std::isnan(known) ? out.value / 2 : known;
  return out;
}

bool ArmTorqueProblem::slopes_hold(int j, const Eigen::VectorXd& c) const {
  const auto i = static_cast<std::size_t>(j);
  const Slopes& slopes = slopes_[i];
  if (slopes.e.size() == 0) return false;
  const Eigen::VectorXd moved = c.segment(slopes.block.begin, slopes.block.size) - slopes.c,
                        of_body = data_.joint(j).Y * (point_.arm().robot.pi - slopes.pi);
  return (residual_[i] - slopes.e - slopes.J * moved - of_body).norm() <=
         kStale * residual_[i].norm();
}

void ArmTorqueProblem::take_slopes(int j, const Eigen::VectorXd& c, const Eigen::MatrixXd& by_c) {
  const auto i = static_cast<std::size_t>(j);
  const ArmTorqueData::Joint& joint = data_.joint(j);
  const double w = 1 / (sigma_[j] * sigma_[j]);
  Slopes& slopes = slopes_[i];
  slopes.block = block_of(models_[i]);
  // columns by coordinate: of theta_p, times dtheta_p/dc
  JointFrictionData::Linear at = friction_rows_and_slopes(joint, models_[i], slopes.block, by_c);
  slopes.c = c.segment(slopes.block.begin, slopes.block.size);
  slopes.pi = point_.arm().robot.pi;
  slopes.e = residual_[i] = joint.Y * slopes.pi + at.f - joint.tau;
  slopes.D.noalias() = w * at.J.transpose() * at.J;
  slopes.B.noalias() = w * (joint.Y.transpose() * at.J);
  slopes.J = std::move(at.J);
  slopes.is_kept = false;
}

bool ArmTorqueProblem::forget_slopes() {
  const bool any = std::ranges::any_of(slopes_, &Slopes::is_kept);
  if (any) slopes_.assign(slopes_.size(), {});
  return any;
}

std::vector<ArmTorqueProblem::Rows> ArmTorqueProblem::rows_at(const Eigen::VectorXd& c) {
  point_.move_to(c);
  const Arm& arm = point_.arm();
  const Eigen::Index p = arm.robot.pi.size(),
                     rest = c.size() - std::ssize(point_.coordinates().friction());
  const Eigen::MatrixXd by_c = jacobian();
  std::vector<Rows> rows(models_.size());
  parallel_for(data_.n(), jobs_, [&](int j) {
    const auto i = static_cast<std::size_t>(j);
    const ArmTorqueData::Joint& joint = data_.joint(j);
    const optimise::Block block = block_of(models_[i]);
    const JointFrictionData::Linear at = friction_rows_and_slopes(joint, models_[i], block, by_c);
    rows[i] = {.block = block,
               .J = at.J / sigma_[j],
               .Y = joint.Y * by_c.topRightCorner(p, rest) / sigma_[j],
               .e = (joint.Y * arm.robot.pi + at.f - joint.tau) / sigma_[j]};
  });
  return rows;
}

Eigen::MatrixXd ArmTorqueProblem::jacobian() const {
  Eigen::MatrixXd by_c = point_.jacobian();
  const Eigen::Index p = point_.arm().robot.pi.size();
  if (body_ == BodyCoordinates::kPi) by_c.topRightCorner(p, p).setIdentity();
  return by_c;
}

Eigen::MatrixXd ArmTorqueProblem::scores_of(
    const std::vector<Rows>& rows, const std::function<Eigen::VectorXd(int)>& errors) const {
  const Eigen::Index all = point_.coordinates().size();
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(all, data_.n());
  parallel_for(data_.n(), jobs_, [&](int j) {
    Eigen::VectorXd m = errors(j) / sigma_[j];
    data_.joint(j).centre(m);
    const auto& [block, J, Y, e] = rows[static_cast<std::size_t>(j)];
    scores.col(j).segment(block.begin, block.size) = J.transpose() * m;
    scores.col(j).tail(Y.cols()) = Y.transpose() * m;
  });
  return scores;
}

Eigen::MatrixXd ArmTorqueProblem::motion_scores(const std::vector<Rows>& rows,
                                                const MotionErrors& motion) const {
  return scores_of(rows, [&](int j) {
    const ArmTorqueData::Joint& joint = data_.joint(j);
    const JointModel& model = models_[static_cast<std::size_t>(j)];
    return motion.of(joint.friction, j, model.one, theta_of(model), joint.row);
  });
}

Eigen::VectorXd ArmTorqueProblem::timing_score(const std::vector<Rows>& rows) const {
  const Eigen::MatrixXd of_joints = scores_of(rows, [&](int j) {
    const ArmTorqueData::Joint& joint = data_.joint(j);
    Eigen::VectorXd late(joint.tau.size());
    Eigen::Index r = 0;
    for (std::size_t s = 0; s < joint.row.size(); ++s)
      for (const int k : joint.row[s]) late[r++] = late_by(data_.recordings()[s], k, j);
    return late;
  });
  return of_joints.rowwise().sum();
}

Eigen::MatrixXd ArmTorqueProblem::noise_information() const {
  const dynamics::RobotModel& robot = point_.arm().robot;
  const int n = robot.n(), p = robot.parameter_count();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(p, p);
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd still(n, p), moved(n, p);
  for (std::size_t s = 0; s < data_.recordings().size(); ++s) {
    const signals::Recording& recording = data_.recordings()[s];
    std::vector<std::vector<int>> joints(static_cast<std::size_t>(recording.length()));
    for (int j = 0; j < n; ++j)
      for (const int k : data_.joint(j).row[s]) joints[static_cast<std::size_t>(k)].push_back(j);
    const signals::Motion noisy = with_noise(recording, data_.cutoff_hz(), s);
    for (int k = 0; k < recording.length(); ++k) {
      const std::vector<int>& at = joints[static_cast<std::size_t>(k)];
      if (at.empty()) continue;
      regressor_at(robot, ws, recording.narrow, k, still);
      regressor_at(robot, ws, noisy, k, moved);
      for (const int j : at) {
        const Eigen::RowVectorXd row = (moved.row(j) - still.row(j)) / sigma_[j];
        sum.selfadjointView<Eigen::Lower>().rankUpdate(row.transpose());
      }
    }
  }
  return sum.selfadjointView<Eigen::Lower>();
}

Eigen::MatrixXd ArmTorqueProblem::deletions(const std::vector<Rows>& all_rows,
                                            const Eigen::MatrixXd& H) const {
  const TimeBlocks time(data_.recordings(), kBlock);
  const int passages = time.passages();
  std::vector<std::vector<std::vector<Eigen::Index>>> of_passage(models_.size());
  for (std::size_t i = 0; i < models_.size(); ++i) {
    of_passage[i].resize(static_cast<std::size_t>(passages));
    const std::vector<std::vector<int>>& samples = data_.joint(static_cast<int>(i)).row;
    Eigen::Index r = 0;
    for (std::size_t s = 0; s < samples.size(); ++s)
      for (const int k : samples[s])
        of_passage[i][static_cast<std::size_t>(time.passage_of(s, k))].push_back(r++);
  }
  Eigen::MatrixXd out(H.rows(), passages);
  parallel_for(passages, jobs_, [&](int b) {
    Eigen::MatrixXd left = H;
    Eigen::VectorXd score = Eigen::VectorXd::Zero(H.rows());
    for (std::size_t i = 0; i < models_.size(); ++i) {
      const std::vector<Eigen::Index>& rows = of_passage[i][static_cast<std::size_t>(b)];
      const Eigen::MatrixXd J = all_rows[i].J(rows, Eigen::all),
                            Y = all_rows[i].Y(rows, Eigen::all);
      const Eigen::VectorXd e = all_rows[i].e(rows);
      const auto [begin, size] = all_rows[i].block;
      const Eigen::Index rest = Y.cols(), behind = H.rows() - rest;
      left.block(begin, begin, size, size).noalias() -= J.transpose() * J;
      const Eigen::MatrixXd beside = Y.transpose() * J;
      left.block(behind, begin, rest, size) -= beside;
      left.block(begin, behind, size, rest) -= beside.transpose();
      left.bottomRightCorner(rest, rest).noalias() -= Y.transpose() * Y;
      score.segment(begin, size) += J.transpose() * e;
      score.tail(rest) += Y.transpose() * e;
    }
    out.col(b) = left.ldlt().solve(score);
  });
  return out;
}

std::span<const double> ArmTorqueProblem::theta_of(const JointModel& model) const {
  return std::span(point_.arm().friction.theta).subspan(model.begin, model.size);
}

optimise::Block ArmTorqueProblem::block_of(const JointModel& model) const {
  const std::vector<std::size_t>& theta = point_.coordinates().friction();
  const auto first = std::ranges::lower_bound(theta, model.begin);
  const auto last = std::ranges::lower_bound(theta, model.begin + model.size);
  return {first - theta.begin(), last - first};
}

JointFrictionData::Linear ArmTorqueProblem::friction_rows_and_slopes(
    const ArmTorqueData::Joint& joint, const JointModel& model, const optimise::Block& block,
    const Eigen::MatrixXd& by_c) const {
  const Arm& arm = point_.arm();
  const std::span<const double> theta = theta_of(model);
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

void ArmTorqueProblem::add_pulls(const std::optional<FrictionPrior>& prior, bool pull_static) {
  using enum friction::Role;
  const friction::Friction& friction = point_.arm().friction;
  const std::vector<std::size_t>& moved = point_.coordinates().friction();
  const Eigen::MatrixXd by_c = point_.jacobian();
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const friction::ParameterRef& p = friction.model.parameters()[moved[i]];
    const auto c = static_cast<Eigen::Index>(i);
    const double known = prior ? prior->theta[moved[i]] : 0;
    const int sliding = coulomb_beside(friction.model, moved[i]);
    if (p.info.role == kStatic && sliding >= 0 && pull_static) {
      const double Fc = friction.theta[static_cast<std::size_t>(sliding)];
      pulls_.push_back(
          {moved[i], c, Fc, 1 / std::pow(kStaticPull * std::max(Fc, friction.theta[moved[i]]), 2)});
    }
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

}  // namespace fricid::estimate
