#include "fricid/estimate/torque/joint_fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>

#include "blocks.hpp"
#include "fricid/base/lowest_point.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/estimate/predict_torque.hpp"
#include "fricid/estimate/prepared.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"
#include "fricid/estimate/torque/carry_over.hpp"
#include "fricid/estimate/torque/sum_start.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kWarms = 0.5;           // [K] sd of a temperature that says something
constexpr double kBothWays = 0.05;       // share of the sliding in the rarer direction, at least
constexpr double kLeastFriction = 0.01;  // share of the torque: a start has some

constexpr double kWorseByChance = 2;                       // with a prior, on few seconds
constexpr double kMostLoadGain = 0.9, kCutLoadGain = 0.5;  // d friction / d load
constexpr int kMostCuts = 3;
constexpr int kMostLoads = 6;       // passes
constexpr double kPromising = 0.1;  // gain on the training rows
/// What makes friction grow with the load.
bool is_growth(friction::Role role) {
  return role == friction::Role::kLoadGrowth || role == friction::Role::kLoadCoefficient;
}

/// Share of the samples above `min_speed` that move in the rarer direction.
double share_of_rarer_direction(std::span<const signals::Recording> recordings, int joint,
                                double min_speed) {
  double forward = 0, back = 0;
  for (const signals::Recording& r : recordings) {
    const auto v = r.narrow.v.col(joint).array();
    const auto used = r.use.col(joint).template cast<double>();
    forward += ((v > min_speed).template cast<double>() * used).sum();
    back += ((v < -min_speed).template cast<double>() * used).sum();
  }
  return std::min(forward, back) / std::max(1.0, forward + back);
}

/// First sample up to which x covers an interval; its size where it never does, 0 for an interval
/// of none.
int covers(ConstRowMatrix x, int column, double interval) {
  if (interval <= 0) return 0;
  double low = x(0, column), high = low;
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    low = std::min(low, x(k, column));
    high = std::max(high, x(k, column));
    if (high - low >= interval) return static_cast<int>(k);
  }
  return static_cast<int>(x.rows());
}

/// (n) travel over which the single spring of a joint follows it [rad or m]; 0: it has none.
Eigen::VectorXd spring_lengths(const Arm& arm) {
  Eigen::VectorXd length = Eigen::VectorXd::Zero(arm.robot.n());
  for (int j = 0; j < arm.robot.n(); ++j) {
    if (const std::optional<SpringIndices> at = single_spring(arm.friction.model, j))
      length[j] = arm.friction.theta[at->W] / arm.friction.theta[at->K];
  }
  return length;
}

}  // namespace

JointFits::JointFits(const Prepared& prepared, const MultiStepOptions& windows, int jobs)
    : prepared_(prepared),
      windows_(windows),
      jobs_(jobs),
      periods_(by_period(prepared.recordings)),
      split_(split_recordings(periods_.recordings, windows.hold_out)),
      recordings_(periods_.recordings),
      all_(prepared.robot, recordings_, prepared.options.cutoff_hz),
      training_(prepared.robot, recordings_, prepared.options.cutoff_hz, {}, split_.train_end),
      held_out_(prepared.robot, recordings_, prepared.options.cutoff_hz, split_.test_begin),
      motion_errors_(recordings_, prepared.options.cutoff_hz, jobs),
      folds_(folds_of(periods_.recordings)),
      judging_(held_out_rollouts(periods_.recordings, split_)),
      has_viscous_(static_cast<std::size_t>(prepared.robot.n()), true) {
  if (!is_short())
    for (int i = 0; i < static_cast<int>(recordings_.size()); ++i) {
      if (periods_.origins[static_cast<std::size_t>(i)].begin > 0) continue;  // in motion
      judging_.seconds.push_back({i, 0});
      judging_.whole.push_back({i, 0});
    }
  windows_.torque_scale = torque_rms(prepared.recordings);
  const Temperatures temperatures = temperatures_of(prepared.recordings);
  temperature_ = temperatures.mean;
  has_temperature_ = temperatures.sd > kWarms;
  for (int j = 0; j < n(); ++j) {
    slides_both_ways_.push_back(
        share_of_rarer_direction(recordings_, j,
                                 prepared.rigid_body.least_speed[static_cast<std::size_t>(j)]) >=
        kBothWays);
    double low = kInfinity, high = -kInfinity;
    for (const signals::Recording& r : recordings_) {
      low = std::min(low, r.filtered_tau.col(j).minCoeff());
      high = std::max(high, r.filtered_tau.col(j).maxCoeff());
    }
    load_varies_.push_back(varies_enough(low, high));
  }
  take_load_of(start(friction::JointSpec{{{"coulomb_viscous", 0, {}}}}));
}

std::vector<RowMatrix> JointFits::predicted_torques(const Arm& arm) const {
  std::vector<RowMatrix> torques(recordings_.size());
  parallel_for(static_cast<int>(torques.size()), jobs_, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    torques[at] = predict_torque(arm, recordings_[at], prepared_.options.cutoff_hz);
  });
  return torques;
}

void JointFits::take_loads(std::vector<RowMatrix> loads) {
  for (std::size_t i = 0; i < loads.size(); ++i) recordings_[i].load = std::move(loads[i]);
  for (ArmTorqueData* data : {&all_, &training_, &held_out_}) data->take_load();
}

void JointFits::take_springs_of(const Arm& arm) {
  constexpr int kSteps = 8;  // from one cap to the other
  const Eigen::VectorXd length = spring_lengths(arm);
  if (length.isZero() && springs_.deflection.size() == 0) return;
  const auto recordings = std::ssize(recordings_);
  springs_ = {Eigen::MatrixXd(recordings, n()), Eigen::MatrixXi(recordings, n())};
  for (Eigen::Index s = 0; s < recordings; ++s)
    for (int j = 0; j < n(); ++j)
      springs_.until(s, j) =
          covers(recordings_[static_cast<std::size_t>(s)].wide.q, j, 2 * length[j]);

  const auto deflected = [&](double share) {
    return Eigen::VectorXd::Ones(recordings) * (share * length).transpose();
  };
  const auto share = [](double step) { return 2 * step / kSteps - 1; };
  std::vector<Eigen::MatrixXd> squares;  // per joint (steps, recordings)
  squares.assign(static_cast<std::size_t>(n()), Eigen::MatrixXd(kSteps + 1, recordings));
  springs_.deflection.setZero();
  all_.take_springs(springs_);
  for (int i = 0; i <= kSteps; ++i) {
    all_.begin_springs_at(deflected(share(i)));
    parallel_for(n(), jobs_, [&](int j) {
      squares[static_cast<std::size_t>(j)].row(i) = all_.squares(arm, j).transpose();
    });
  }
  for (Eigen::Index s = 0; s < recordings; ++s)
    for (int j = 0; j < n(); ++j)
      springs_.deflection(s, j) =
          share(lowest_point(
              std::span(squares[static_cast<std::size_t>(j)].col(s).data(), kSteps + 1))) *
          length[j];
  for (ArmTorqueData* data : {&all_, &training_, &held_out_}) data->take_springs(springs_);
}

void JointFits::take_load_of(const Arm& arm) { take_loads(predicted_torques(arm)); }

JointFits::UnderOwnLoad JointFits::under_own_load(const Arm& start, Rows rows,
                                                  double smallest_gain) {
  UnderOwnLoad out{start, 0};
  if (!start.friction.model.reads_load()) return out;
  Arm& arm = out.arm;
  std::vector<RowMatrix> before, moved_before;
  for (int pass = 0; pass < kMostLoads; ++pass) {
    std::vector<RowMatrix> predicted = predicted_torques(arm);
    std::vector<RowMatrix> loads = predicted, moved = predicted;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] -= recordings_[i].load;

    bool settled = true;
    for (Eigen::Index j = 0; j < n(); ++j) {
      double size = 0, step = 0, turn = 0, along = 0;
      for (std::size_t i = 0; i < moved.size(); ++i) {
        size += predicted[i].col(j).squaredNorm();
        step += moved[i].col(j).squaredNorm();
        if (pass == 0) continue;
        const Eigen::VectorXd turned = moved[i].col(j) - moved_before[i].col(j);
        turn += turned.squaredNorm();
        along += turned.dot(moved[i].col(j));
      }
      if (pass == 0) out.moved = std::max(out.moved, std::sqrt(step / std::max(size, 1e-300)));
      settled = settled && step <= smallest_gain * smallest_gain * size;
      if (turn == 0) continue;
      const double mixed = std::clamp(along / turn, -1.0, 1.0);
      for (std::size_t i = 0; i < loads.size(); ++i)
        loads[i].col(j) -= mixed * (predicted[i].col(j) - before[i].col(j));
    }
    if (settled) break;
    take_loads(std::move(loads));
    arm = on_torque(arm, rows, WaveSearch::kNone, smallest_gain).arm;
    before = std::move(predicted);
    moved_before = std::move(moved);
  }
  return out;
}

void JointFits::take_prior(std::optional<ArmPrior> prior) { prior_ = std::move(prior); }

bool JointFits::keeps_prior(double with, double without) const {
  return with < (is_short() ? kWorseByChance : 1) * without;
}

bool JointFits::is_like_prior(const Arm& arm) const {
  return prior_ && std::ranges::equal(arm.friction.model.parameters(),
                                      prior_->arm.friction.model.parameters(), friction::is_same);
}

bool JointFits::has_room_for_windows() const {
  const double samples = 2 * windows_.window_s / prepared_.recordings.front().dt;
  return std::ranges::all_of(split_.train_end, [&](int end) { return end > samples + 1; });
}

bool JointFits::is_short() const {
  double seconds = 0;
  for (std::size_t s = 0; s < recordings_.size(); ++s)
    seconds += recordings_[s].dt * (recordings_[s].length() - split_.test_begin[s]);
  return seconds < kFewSeconds;
}

std::vector<friction::LvmParts> JointFits::all_parts() const {
  friction::LvmParts all;
  all.temperature = has_temperature_;
  std::vector<friction::LvmParts> parts(static_cast<std::size_t>(n()), all);
  for (int j = 0; j < n(); ++j) {
    friction::LvmParts& of_joint = parts[static_cast<std::size_t>(j)];
    of_joint.asymmetry = can_show(friction::SumPart::kAsymmetry, j);
    of_joint.load = of_joint.power_flow = can_show(friction::SumPart::kLoad, j);
  }
  return parts;
}

bool JointFits::can_show(friction::SumPart part, int joint) const {
  using enum friction::SumPart;
  const auto j = static_cast<std::size_t>(joint);
  switch (part) {
    case kTemperature:
      return has_temperature_;
    case kAsymmetry:
      return slides_both_ways_[j];
    case kLoad:
    case kPowerFlow:
    case kGearLoad:
    case kLoadedViscous:
    case kLoadedStribeck:
      return load_varies_[j];
    default:
      return true;
  }
}

int JointFits::n() const { return prepared_.robot.n(); }

Arm JointFits::start(std::vector<friction::JointSpec> joints) const {
  Arm arm;
  arm.robot = prepared_.robot;
  arm.robot.pi = prepared_.rigid_body.pi;
  SumStart start{.joints = {}, .load = windows_.torque_scale, .temperature = temperature_};
  for (int j = 0; j < n(); ++j) {
    const double torque = windows_.torque_scale[static_cast<std::size_t>(j)];
    start.joints.push_back({std::max(prepared_.rigid_body.Fc[j], kLeastFriction * torque),
                            std::max(prepared_.rigid_body.Fv[j], 0.0)});
  }
  return start_sum(arm, std::move(joints), start);
}

Arm JointFits::start(const friction::JointSpec& spec) const {
  return start(std::vector<friction::JointSpec>(static_cast<std::size_t>(n()), spec));
}

Arm JointFits::start(const std::vector<friction::LvmParts>& parts) const {
  std::vector<friction::JointSpec> joints;
  for (const friction::LvmParts& of_joint : parts) joints.push_back(friction::lvm_sum(of_joint));
  Arm arm = start(std::move(joints));
  for (int j = 0; j < n(); ++j)
    if (!parts[static_cast<std::size_t>(j)].viscous)
      arm.friction.theta[static_cast<std::size_t>(linear_viscous(arm.friction.model, j))] = 0;
  return arm;
}

double JointFits::held_out_torque(const Arm& arm) const {
  double sum = 0;
  int moving = 0;
  for (int j = 0; j < n(); ++j) {
    const Eigen::Index rows = held_out_.joint(j).tau.size();
    if (rows == 0) continue;                         // the joint rests in all that is held out
    const Eigen::VectorXd& tau = all_.joint(j).tau;  // of a short stretch it may hardly vary
    const double size = (tau.array() - tau.mean()).square().mean();
    sum += held_out_.residual(arm, j).squaredNorm() / static_cast<double>(rows) /
           std::max(size, 1e-300);
    ++moving;
  }
  return moving > 0 ? sum / moving : 0;
}

double JointFits::residual_rms(const Arm& arm, int j) const {
  const Eigen::VectorXd e = training_.residual(arm, j);
  return std::sqrt(e.squaredNorm() / std::max<double>(1, static_cast<double>(e.size())));
}

Candidate JointFits::judged(std::string name, const Arm& arm, double seconds) const {
  Candidate out;
  out.name = std::move(name);
  out.arm = arm;
  const std::vector<double> sums = friction::sums_of_shares(arm.friction);
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (const friction::ParameterInfo& info = arm.friction.model.parameters()[i].info;
        info.role == friction::Role::kShare)
      out.arm.friction.theta[i] = std::max(arm.friction.theta[i] / sums[i], info.lower);
  out.seconds = seconds;
  out.rollouts = rollout_errors(out.arm, periods_.recordings, judging_, windows_.judge, jobs_);
  out.held_out = std::exp(out.rollouts.mean());
  out.torque = held_out_torque(out.arm);
  out.parameters =
      friction::free_parameter_count(arm.friction) - static_cast<int>(limits_of(arm).size());
  return out;
}

void JointFits::take_viscous_of(const std::vector<friction::LvmParts>& parts) {
  for (std::size_t j = 0; j < parts.size(); ++j) has_viscous_[j] = parts[j].viscous;
}

std::vector<Limit> JointFits::limits_of(const Arm& arm) const {
  const friction::RobotFriction& model = arm.friction.model;
  std::vector<Limit> limits = sum_limits(arm);
  for (int j = 0; j < n(); ++j) {
    const bool is_sum = friction::find_parameter(model, j, friction::Role::kPowerViscous) >= 0 &&
                        friction::find_parameter(model, j, "viscous", "Fv") < 0;
    if (is_sum && !has_viscous_[static_cast<std::size_t>(j)])
      limits.push_back({static_cast<std::size_t>(linear_viscous(model, j)), 0, 0});
  }
  if (is_short())
    for (const std::size_t i : load_corners(model))
      limits.push_back({i, arm.friction.theta[i], arm.friction.theta[i]});
  return limits;
}

ArmTorqueOptions JointFits::torque_options(const Arm& arm) const {
  ArmTorqueOptions options;
  options.rigid_body = as_needed(prepared_.options, prepared_.rigid_body);
  options.nominal = prepared_.robot.pi;
  if (pulls_to_regression_) {
    options.rigid_body.prior.use = true;
    options.nominal = prepared_.rigid_body.pi;
  }
  options.coordinates.torque_scale = windows_.torque_scale;
  options.coordinates.limits = limits_of(arm);
  if (is_like_prior(arm)) {
    options.rigid_body.prior.use = true;
    options.nominal = prior_->arm.robot.pi;
    options.friction_prior = {prior_->arm.friction.theta, prior_->sd};
  }
  return options;
}

std::vector<Limit> JointFits::load_limits(const Arm& arm, double most, double aimed) const {
  const friction::Friction& friction = arm.friction;
  std::vector<double> gain(static_cast<std::size_t>(n()));
  parallel_for(n(), jobs_,
               [&](int j) { gain[static_cast<std::size_t>(j)] = all_.load_gain(arm, j); });
  std::vector<Limit> limits;
  for (std::size_t i = 0; i < friction.theta.size(); ++i) {
    const friction::ParameterRef& p = friction.model.parameters()[i];
    if (!is_growth(p.info.role) || friction.theta[i] == 0) continue;
    const double of_joint = gain[static_cast<std::size_t>(p.joint)];
    if (of_joint > most) limits.push_back({i, p.info.lower, friction.theta[i] * aimed / of_joint});
  }
  return limits;
}

ArmTorqueFit JointFits::on_torque(const Arm& given, Rows rows, WaveSearch waves,
                                  double smallest_gain) const {
  ArmTorqueOptions options = torque_options(given);
  Arm start = given;
  for (const Limit& limit : options.coordinates.limits)  // what another arm had of it goes
    if (limit.lower == limit.upper) start.friction.theta[limit.parameter] = limit.lower;
  options.waves = waves;
  options.smallest_gain = smallest_gain;
  // parts are compared without the pull: banks of springs stand for other memories by Fs < Fc
  options.pull_static = rows == Rows::kAll;
  const ArmTorqueData& data = rows == Rows::kAll ? all_ : training_;
  ArmTorqueFit fit = fit_arm_torque(data, start, options, jobs_);
  options.waves = WaveSearch::kNone;
  for (int cut = 0; cut < kMostCuts; ++cut) {
    const std::vector<Limit> limits = load_limits(fit.arm, kMostLoadGain, kCutLoadGain);
    if (limits.empty()) break;
    for (const Limit& limit : limits) {
      fit.arm.friction.theta[limit.parameter] = limit.upper;
      options.coordinates.limits.push_back(limit);
    }
    fit = fit_arm_torque(data, fit.arm, options, jobs_);
  }
  return fit;
}

Arm JointFits::on_torque_of_springs(const Arm& start) {
  constexpr int kPasses = 8;
  constexpr double kSmallestGain = 1e-4;  // steps through the kinks of springs gain little at first
  Arm arm = start;
  for (int pass = 0; pass < kPasses; ++pass) {
    take_springs_of(arm);
    arm = on_torque(arm, Rows::kTraining, WaveSearch::kNone, kSmallestGain).arm;
  }
  return arm;
}

std::vector<Arm> JointFits::cross_fit(const Arm& fitted) const {
  ArmTorqueOptions options = torque_options(fitted);
  options.waves = WaveSearch::kNone;
  std::ranges::copy(load_limits(fitted, 0, kMostLoadGain),
                    std::back_inserter(options.coordinates.limits));
  std::vector<Arm> arms;
  for (const Fold& fold : folds_) {
    const std::vector<signals::Recording> rest = without(fold, recordings_);
    ArmTorqueData data(prepared_.robot, rest, prepared_.options.cutoff_hz);
    if (springs_.deflection.size() > 0) data.take_springs(springs_);
    arms.push_back(fit_arm_torque(data, fitted, options, jobs_).arm);
  }
  return arms;
}

ArmErrors JointFits::errors_of(const Arm& fitted, int count, std::uint64_t seed) const {
  return arm_errors(all_, motion_errors_, fitted, torque_options(fitted), count, seed, jobs_);
}

PartEvidence JointFits::compare(const Arm& with, const Arm& without, int j,
                                friction::SumPart part) const {
  const Eigen::ArrayXd a = held_out_.residual(with, j).array().square(),
                       b = held_out_.residual(without, j).array().square();
  std::vector<double> blocks;  // sum of b - a
  const ArmTorqueData::Joint& joint = held_out_.joint(j);
  for (const auto& [begin, size] : blocks_of(joint.row, joint.friction.blocks()))
    blocks.push_back((b - a).segment(begin, size).sum());
  double mean = 0, square = 0;
  const auto count = static_cast<double>(std::max<std::size_t>(2, blocks.size()));
  for (const double x : blocks) mean += x / count;
  for (const double x : blocks) square += (x - mean) * (x - mean) / (count - 1);
  const double size = std::max(a.sum() / count, 1e-300);
  PartEvidence out{
      .part = part, .joint = j, .gain = mean / size, .error = std::sqrt(square / count) / size};
  // a gain in one block alone is one standard error; the quantile of Student's t that one standard
  // deviation is of a normal number, within some per cent
  out.on = out.gain > (1 + 0.5 / (count - 1)) * out.error;
  return out;
}

std::vector<Cable> JointFits::promising_cables(const Arm& arm) const {
  std::vector<Cable> cables(static_cast<std::size_t>(n()));
  parallel_for(n(), jobs_, [&](int j) {
    const Cable cable = strongest_cable(training_, arm, j);
    if (cable.gain > kPromising) cables[static_cast<std::size_t>(j)] = cable;
  });
  return cables;
}

std::vector<bool> JointFits::promises(friction::SumPart part, const Arm& arm) const {
  std::vector<char> of_joint(static_cast<std::size_t>(n()));
  parallel_for(n(), jobs_, [&](int j) {
    const LoadedSpeed found = loaded_speed(training_, arm, j);
    const double gain = part == friction::SumPart::kLoadedViscous ? found.viscous : found.stribeck;
    of_joint[static_cast<std::size_t>(j)] = can_show(part, j) && gain > kPromising;
  });
  return {of_joint.begin(), of_joint.end()};
}

std::vector<PositionWave> JointFits::waves_of(const Arm& arm) const {
  std::vector<PositionWave> waves(static_cast<std::size_t>(n()));
  parallel_for(n(), jobs_, [&](int j) {
    waves[static_cast<std::size_t>(j)] = strongest_wave(training_, held_out_, arm, j);
  });
  return waves;
}

std::vector<TightSpot> JointFits::spots_of(const Arm& arm) const {
  std::vector<TightSpot> spots;
  for (int j = 0; j < n(); ++j) spots.push_back(tightest_spot(training_, held_out_, arm, j));
  return spots;
}

std::vector<TorqueBend> JointFits::bends_of(const Arm& arm) const {
  std::vector<TorqueBend> bends;
  for (int j = 0; j < n(); ++j) bends.push_back(bend_of(training_, held_out_, arm, j));
  return bends;
}

Candidate JointFits::on_windows(const Candidate& start, std::string_view label) const {
  ArmTorqueOptions torque = torque_options(start.arm);
  std::vector<Limit>& limits = torque.coordinates.limits;
  std::ranges::copy(held_networks(start.arm.friction), std::back_inserter(limits));
  std::ranges::copy(load_limits(start.arm, 0, kMostLoadGain), std::back_inserter(limits));
  MultiStepOptions options = windows_;
  options.limits = limits;
  const MultiStepReport trained =
      refine_on_windows(start.arm, torque_pull(all_, motion_errors_, start.arm, torque, jobs_),
                        periods_.recordings, options, label, jobs_);
  Candidate out = judged(start.name + ", windows", trained.arm, trained.seconds);
  out.rival = start.rival;
  out.near_regression = start.near_regression;
  return out;
}

}  // namespace fricid::estimate
