// Friction that grows with the load, found beside the rigid body.
#include <algorithm>
#include <cmath>

#include "rigid_body/inertia_prior.hpp"
#include "rigid_body/reweight.hpp"
#include "rigid_body/solve.hpp"
#include "rigid_body/unknowns.hpp"

namespace fricid::estimate {
namespace {

constexpr int kLoadPasses = 8;         // of friction that grows with the torque of the last pass
constexpr double kStillGrowth = 1e-4;  // change of that growth
constexpr double kLeastGrowth = 0.01;  // that is shown, ..
constexpr double kGrowthErrors = 6;    // .. in standard errors, ..
constexpr double kGrowthGain = 0.5;    // .. in log of the variance that it explains of its joint

/// Rows with columns (n) of friction that grows with the load, all zero: no joint has any yet.
Regression with_room_for_growth(Regression data, int n) {
  data.rows.conservativeResize(Eigen::NoChange, data.rows.cols() + n);
  data.rows.rightCols(n).setZero();
  return data;
}

/// Sets the columns of growth of the joints, F[sign v_j] |load_j|.
/// @param load  (N) of the rows
void set_growth(const std::vector<int>& joints, int n, const Eigen::VectorXd& load,
                Regression& data) {
  const Eigen::Index growth = data.rows.cols() - n, coulomb = growth - 3 * n;
  data.rows.rightCols(n).setZero();
  for (Eigen::Index r = 0; r < load.size(); ++r)
    if (const int j = data.joint[static_cast<std::size_t>(r)]; std::ranges::count(joints, j) > 0)
      data.rows(r, growth + j) = std::abs(load[r]) * data.rows(r, coulomb + j);
}

/// What the regression predicts, and the growth that it finds.
struct UnderLoad {
  Eigen::VectorXd load;    ///< (N)
  Eigen::VectorXd growth;  ///< (n)
  Eigen::VectorXd sigma;   ///< (n)
};

UnderLoad weigh_under_load(const dynamics::RobotModel& robot, const Regression& data,
                           const RigidBodyOptions& options, GearSide side) {
  const int n = robot.n();
  const Unknowns unknowns = unknowns_of(robot, data, options);
  const Eigen::MatrixXd X = pick(data.rows, unknowns.columns);
  const Weighted solved = reweight(X, data.tau, data.joint, n, options.robust,
                                   unknowns.prior_information, unknowns.prior_mean);
  const Eigen::Index loading = side == GearSide::kMotor ? X.cols() : unknowns.head();
  UnderLoad out{X.leftCols(loading) * solved.x.head(loading), Eigen::VectorXd::Zero(n),
                solved.sigma};
  const int growth = robot.parameter_count() + 3 * n;
  for (std::size_t k = 0; k < unknowns.columns.size(); ++k)
    if (unknowns.columns[k] >= growth)
      out.growth[unknowns.columns[k] - growth] = solved.x[static_cast<Eigen::Index>(k)];
  return out;
}

/// Whether growth explains far more of a joint. @param sigma  (n) of the residuals without
bool explains_more(const UnderLoad& found, const Eigen::VectorXd& sigma) {
  return ((found.growth.array() > kLeastGrowth) &&
          (2 * (sigma.array() / found.sigma.array()).log() > kGrowthGain))
      .any();
}

/// Repeats the regression until the load that it predicts is that of the growth that it finds, in
/// the last columns of `data`.
/// @return joints whose friction grows; none where growth does not explain far more of any
std::vector<int> find_growth(const dynamics::RobotModel& robot, const RigidBodyOptions& options,
                             const RigidBodyFit& without, GearSide side, Regression& data) {
  const int n = robot.n();
  data.rows.rightCols(n).setZero();
  UnderLoad found = weigh_under_load(robot, data, options, side);
  std::vector<int> growing;
  for (int j = 0; j < n; ++j)
    if (without.Fc_se[j] > 0) growing.push_back(j);
  for (int pass = 0; pass < kLoadPasses; ++pass) {
    set_growth(growing, n, found.load, data);
    const UnderLoad next = weigh_under_load(robot, data, options, side);
    const double change = (next.growth - found.growth).cwiseAbs().maxCoeff();
    found = next;
    if (!explains_more(found, without.sigma)) return {};
    const auto falls = [&](int j) { return !(found.growth[j] > 0); };
    if (std::erase_if(growing, falls) == 0 && change < kStillGrowth) break;
  }
  return growing;
}

bool is_certain_growth(const RigidBodyFit& fit) {
  return ((fit.growth.array() > kGrowthErrors * fit.growth_se.array()) &&
          (fit.growth.array() > kLeastGrowth))
      .any();
}

/// Log of the geometric mean over the joints of what a regression leaves.
double spread(const RigidBodyFit& fit) { return fit.sigma.array().log().mean(); }

}  // namespace

std::optional<RigidBodyFit> rigid_body_under_load(const dynamics::RobotModel& robot,
                                                  std::span<const signals::Recording> sequences,
                                                  const RigidBodyOptions& options,
                                                  const RigidBodyFit& without) {
  const int n = robot.n();
  if (without.sigma.size() != n) return {};
  const RigidBodyOptions known = as_needed(options, without);
  RigidBodyFit counts;
  Regression data = with_room_for_growth(stack(robot, sequences, known, nullptr, counts), n);
  const NoiseRows noise = draw_noise_rows(robot, sequences, data, options.cutoff_hz);
  std::optional<RigidBodyFit> best;
  for (const GearSide side : {GearSide::kMotor, GearSide::kLink}) {
    const std::vector<int> growing = find_growth(robot, known, without, side, data);
    if (growing.empty()) continue;
    RigidBodyFit fit = solve(robot, sequences, data, noise, known, counts);
    fit.growth_of = side;
    if (is_certain_growth(fit) && (!best || spread(fit) < spread(*best))) best = std::move(fit);
  }
  if (!best) return {};
  best->prior = without.prior;
  best->slower = without.slower;
  best->without_inertia = without.without_inertia;
  return best;
}

void widen_errors(const RigidBodyFit& under_load, RigidBodyFit& fit) {
  fit.growth = under_load.growth;
  fit.growth_se = under_load.growth_se;
  fit.growth_of = under_load.growth_of;
  const auto widen = [](Eigen::VectorXd& error, const Eigen::VectorXd& value,
                        const Eigen::VectorXd& of_other) {
    if (value.size() == of_other.size())
      error = (error.array().square() + (value - of_other).array().square()).sqrt();
  };
  widen(fit.base_se, fit.base, under_load.base);
  widen(fit.Fc_se, fit.Fc, under_load.Fc);
  widen(fit.Fv_se, fit.Fv, under_load.Fv);
  widen(fit.offset_se, fit.offset, under_load.offset);
}

}  // namespace fricid::estimate
