#include "rigid_body/weights.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/unit_of_joint.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/estimate/prepared.hpp"

namespace fricid::estimate {
namespace {

constexpr double kOther = 0.25;  // of the larger of the two
constexpr double kWorth = 0.1;   // of the joint's torque
constexpr double kCertain = 4;   // standard errors
constexpr int kMostSamples = 500;

}  // namespace

std::vector<std::string> other_weights(const dynamics::RobotModel& robot,
                                       std::span<const signals::Recording> recordings,
                                       const RigidBodyFit& fit) {
  std::vector<std::string> found;
  if (!fit.prior.empty() || fit.outcome != Outcome::kConverged || robot.gravity.isZero())
    return found;
  std::vector<int> columns = dynamics::base_parameters(robot).columns;
  if (std::ssize(columns) != fit.base.size()) return found;
  // what a link weighs, not a constant torque or a spring that the file declares
  const auto is_of_links = [&](int column) { return column < robot.linear_begin(); };
  const auto links = static_cast<Eigen::Index>(std::ranges::count_if(columns, is_of_links));
  columns.resize(static_cast<std::size_t>(links));
  const Eigen::VectorXd by_file = (fit.base_of_pi * robot.pi).head(links),
                        by_fit = fit.base.head(links), error = fit.base_se.head(links);

  const auto n = static_cast<std::size_t>(robot.n());
  dynamics::Workspace<double> ws(robot);
  const std::vector<double> still(n, 0.0);
  Eigen::MatrixXd Y(robot.n(), robot.parameter_count());
  Eigen::ArrayXd file = Eigen::ArrayXd::Zero(robot.n()), fitted = file, off = file, variance = file;
  Eigen::Index total = 0, samples = 0;
  for (const signals::Recording& r : recordings) total += r.length();
  const Eigen::Index every = std::max<Eigen::Index>(1, total / kMostSamples);
  for (const signals::Recording& r : recordings)
    for (Eigen::Index k = 0; k < r.length(); k += every, ++samples) {
      dynamics::regressor(robot, ws, {r.narrow.q.row(k).data(), n}, still, still, Y);
      const Eigen::MatrixXd G = Y(Eigen::all, columns);
      const Eigen::ArrayXd of_file = G * by_file, of_fit = G * by_fit;
      file += of_file.square();
      fitted += of_fit.square();
      off += (of_fit - of_file).square();
      variance += (G * error.asDiagonal()).cwiseAbs2().rowwise().sum().array();
    }
  const auto rms = [&](const Eigen::ArrayXd& squares) {
    return Eigen::ArrayXd((squares / static_cast<double>(samples)).sqrt());
  };
  const Eigen::ArrayXd of_file = rms(file), of_fit = rms(fitted), apart = rms(off),
                       uncertain = rms(variance);
  const std::vector<double> torque = torque_rms(recordings);
  for (int j = 0; j < robot.n(); ++j) {
    const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    const double least =
        std::max({kOther * std::max(of_file[j], of_fit[j]),
                  kWorth * torque[static_cast<std::size_t>(j)], kCertain * uncertain[j]});
    if (apart[j] > least)
      found.push_back(fmt::format("{} ({:.3g} {}, {:.3g} by the file)", joint.name, of_fit[j],
                                  unit_of_joint("N m", slides(joint)), of_file[j]));
  }
  return found;
}

}  // namespace fricid::estimate
