// Prints the table of docs/doctor.md#standard-errors: how often 95 % intervals hold the truth.
//
//     fricid_coverage_table [LOGS_PER_ARM]
//
// Every log is another motion of its arm with other noise, and the arm's file is wrong. Friction is
// sized by the effort limits; a gms has no Coulomb and viscous friction, so its rigid body alone is
// counted.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "doctor/injected.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/simulate.hpp"
#include "kr6_truth.hpp"
#include "source_dir.hpp"

namespace fricid::estimate {
namespace {

constexpr double kInterval = 1.96;  // standard errors
constexpr std::array kArms{"models/kr6_r700/kr6_r700.urdf", "models/kuka_kr300/kuka_kr300.urdf",
                           "models/test/arm_7r.urdf"};
constexpr std::array kLaws{"coulomb_viscous", "lugre", "gms"};
constexpr std::array kRates{1000, 500, 250};  // [Hz]
constexpr int kSearched = 250;                // where the law is fitted as well

struct Count {
  int inside = 0, all = 0;
  void add(double error, double standard_error) {
    if (std::isnan(standard_error)) return;  // none is stated
    inside += std::abs(error) < kInterval * standard_error;
    ++all;
  }
  void add(const Count& other) {
    inside += other.inside;
    all += other.all;
  }
  std::string in_percent() const {
    return all == 0 ? "" : fmt::format("{:.0f} of {}", 100. * inside / all, all);
  }
};
/// One row of the table.
struct Cell {
  Count base, Fc, Fv, law;
};

double value_of(const dynamics::Joint& joint, std::string_view symbol, int elements) {
  const double Fc = 0.06 * joint.effort, Fs = test::kStaticOverCoulomb * Fc;
  if (symbol == "Fc") return Fc;
  if (symbol == "Fs") return Fs;
  if (symbol == "vs") return test::kStribeckVelocity;
  if (symbol == "v0") return 0.01;
  if (symbol == "Fv" || symbol == "sigma2") return 0.04 * joint.effort;
  if (symbol == "sigma0") return Fs / 1.5e-3;
  if (symbol == "sigma1") return 3 * Fc;
  if (symbol == "C") return 30 * Fc;
  if (symbol.starts_with("k"))
    return Fs / elements / test::ladder(test::element_of(symbol) - 1, elements, 0.6e-3, 5e-3);
  return std::nan("");
}

std::string scene_of(const std::string& urdf) {
  return fmt::format(R"(
name = "arm"
[robot]
urdf = "{}"
mount = "{}"
[friction]
[excitation]
train = 1
repeats = 1
validation = 0
criterion = "none"
harmonics = 10
base_rad_s = 0.4
velocity_share = 0.7
clearance_m = 0.0
[plant]
step_s = 0.00025
[sensors]
encoder_noise_rad = 4e-6
encoder_step_rad = 4e-6
torque_noise = 0.002
torque_step = 0.0005
)",
                     (source_dir() / urdf).string(),
                     urdf.find("kr6") == std::string::npos ? "floor" : "ceiling");
}

/// The law that was injected, fitted by its search.
void count_search(const Prepared& prepared, const std::string& law, Count& count) {
  ModelOptions model;
  model.name = law;
  model.starts = 1;
  const FitReport report = fit_conventional(prepared, model, 1, 1);
  const friction::RobotFriction& friction = report.model.arm.friction.model;
  for (std::size_t j = 0; j < report.joints.size(); ++j)
    for (std::size_t i = 0; i < report.joints[j].theta.size(); ++i) {
      const std::string& symbol = friction.parameters()[i].symbol;
      if (symbol == "sigma1") continue;  // nothing above the cut-off tells it
      count.add(report.joints[j].theta[i] - value_of(prepared.robot.joints[j], symbol, 0),
                report.joints[j].standard_error[i]);
    }
}

/// Cells of the rates, of one motion.
std::vector<Cell> examine(const std::string& urdf, const std::string& law, int log_number) {
  scene::Scene scene = scene::load_scene_text(scene_of(urdf));
  scene.seed = static_cast<std::uint64_t>(log_number + 1);
  const dynamics::RobotModel robot = scene::resolve(scene).robot;
  const int elements = law == "gms" ? 4 : 0;
  scene.friction = test::make_friction(
      robot.n(), friction::JointSpec{{{law, elements, {}}}},
      [&](int joint, std::string_view, std::string_view symbol) {
        return value_of(robot.joints[static_cast<std::size_t>(joint)], symbol, elements);
      });
  const dynamics::RobotModel file = doctor::as_in_a_file(robot, log_number);
  std::vector<Cell> cells;
  for (const int rate : kRates) {
    scene.sensors.rate_hz = rate;
    const scene::Problem problem = scene::resolve(scene);
    const std::vector<data::Dataset> logs = sim::simulate(problem, 1).train;
    const Prepared prepared = prepare(file, problem.scene.identify, logs, 1);
    const RigidBodyFit& fit = prepared.rigid_body;
    Cell& cell = cells.emplace_back();
    dynamics::RobotModel truth = prepared.robot;  // it has offsets, which are none
    truth.pi.setZero();
    truth.pi.head(robot.pi.size()) = robot.pi;
    const Eigen::VectorXd base = dynamics::base_parameters(truth).K * truth.pi;
    for (Eigen::Index i = 0; i < base.size(); ++i)
      cell.base.add(fit.base[i] - base[i], fit.base_se[i]);
    if (law == "gms") continue;
    for (int j = 0; j < robot.n(); ++j) {
      const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
      cell.Fc.add(fit.Fc[j] - value_of(joint, "Fc", 0), fit.Fc_se[j]);
      cell.Fv.add(fit.Fv[j] - value_of(joint, "Fv", 0), fit.Fv_se[j]);
    }
    if (law == "lugre" && rate == kSearched) count_search(prepared, law, cell.law);
  }
  return cells;
}

void print_table(int per_arm) {
  fmt::print(
      "| friction | rate [Hz] | base parameters | Coulomb | viscous | all of the law, by search |\n"
      "|---|--:|--:|--:|--:|--:|\n");
  const int logs = per_arm * static_cast<int>(kArms.size());
  for (const char* law : kLaws) {
    std::vector<std::vector<Cell>> of_log(static_cast<std::size_t>(logs));
    parallel_for(logs, 0, [&](int i) {
      of_log[static_cast<std::size_t>(i)] =
          examine(kArms[static_cast<std::size_t>(i) % kArms.size()], law, i);
    });
    for (std::size_t rate = 0; rate < kRates.size(); ++rate) {
      Cell sum;
      for (const std::vector<Cell>& cells : of_log)
        for (const auto part : {&Cell::base, &Cell::Fc, &Cell::Fv, &Cell::law})
          (sum.*part).add(cells[rate].*part);
      fmt::print("| {} | {} | {} | {} | {} | {} |\n", law, kRates[rate], sum.base.in_percent(),
                 sum.Fc.in_percent(), sum.Fv.in_percent(), sum.law.in_percent());
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace fricid::estimate

int main(int argc, char** argv) {
  fricid::estimate::print_table(argc > 1 ? std::max(1, std::atoi(argv[1])) : 10);
}
