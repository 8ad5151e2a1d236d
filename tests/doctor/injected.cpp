#include "doctor/injected.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "fricid/scene/problem.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::doctor {
namespace {

using data::Dataset;
using data::RowMatrix;
using dynamics::RobotModel;

constexpr double kDegree = std::numbers::pi / 180;

std::vector<RowMatrix*> tables(Dataset& d) { return {&d.q, &d.tau, &d.v, &d.temperature}; }

int any_joint(const Dataset& d, Rng& rng) {
  return std::min(d.n() - 1, static_cast<int>(d.n() * rng.uniform()));
}
// A row with `after` rows behind it.
int any_row(const Dataset& d, double after_s, Rng& rng) {
  const int begin = d.length() / 10;
  const int end = d.length() - begin - static_cast<int>(after_s * d.rate_hz);
  return begin + static_cast<int>((end - begin) * rng.uniform());
}
bool turns(const RobotModel& robot, int j) {
  return robot.joints[static_cast<std::size_t>(j)].type == dynamics::JointType::kRevolute;
}

void keep_rows(Dataset& d, const std::vector<int>& rows) {
  d.t = Eigen::VectorXd(d.t(rows));
  for (RowMatrix* table : tables(d))
    if (table->size() > 0) *table = RowMatrix((*table)(rows, Eigen::all));
}

// A row of joint j after which it travels far within a second, at more than its usual speed.
int row_in_motion(const Dataset& d, int j, Rng& rng) {
  const int second = static_cast<int>(d.rate_hz);
  const double range = d.q.col(j).maxCoeff() - d.q.col(j).minCoeff();
  int best = any_row(d, 1.5, rng);
  double farthest = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const int k = any_row(d, 1.5, rng);
    const double travel = std::abs(d.q(k + second, j) - d.q(k, j)) / range;
    const double speed = std::abs(d.q(k + second / 20, j) - d.q(k, j)) * 20 / range;
    if (std::min(travel, speed) <= farthest) continue;
    farthest = std::min(travel, speed);
    best = k;
  }
  return best;
}

// Slows down to a stop over the last but one second and stays there.
void come_to_rest(Dataset& d) {
  const Dataset log = d;
  const int T = d.length(), second = static_cast<int>(d.rate_hz), from = T - 3 * second;
  double phase = from;
  for (int k = from; k < T; ++k) {
    const double speed = std::max(0.0, 1 - static_cast<double>(k - from) / second);
    const int row = static_cast<int>(phase);
    const double share = phase - row;
    const auto between = [&](const RowMatrix& x) {
      return (1 - share) * x.row(row) + share * x.row(row + 1);
    };
    d.q.row(k) = speed > 0 ? Eigen::RowVectorXd(between(log.q)) : d.q.row(k - 1).eval();
    d.tau.row(k) = speed > 0 ? Eigen::RowVectorXd(between(log.tau)) : d.tau.row(k - 1).eval();
    d.v.row(k) = speed * between(log.v);
    phase += speed;
  }
}

// Takes each sample late by up to `most` periods: at the time that is logged.
void take_late(Dataset& d, double most, Rng& rng) {
  const Dataset log = d;
  for (int k = 0; k + 1 < d.length(); ++k) {
    const double late = most * rng.uniform();
    d.t[k] += late * d.dt();
    const int next = std::min(k + 2, d.length() - 1), before = std::max(k - 1, 0);
    for (const auto table : {&Dataset::q, &Dataset::v}) {
      const RowMatrix& x = log.*table;
      const double bend = late * (late - 1) / 4;  // of the parabola through four samples
      (d.*table).row(k) = (1 - late) * x.row(k) + late * x.row(k + 1) +
                          bend * (x.row(next) - x.row(k + 1) - x.row(k) + x.row(before));
    }
    d.tau.row(k) = (1 - late) * log.tau.row(k) + late * log.tau.row(k + 1);
  }
}

std::vector<Injection> make_injections() {
  using D = Dataset&;
  using R = RobotModel&;
  return {
      {"nothing", [](D, R, Rng&) { return Injected{}; }, true},
      {"comes to rest at the end",
       [](D d, R, Rng&) {
         come_to_rest(d);
         return Injected{};
       },
       true},
      {"5 to 60 samples lost",
       [](D d, R, Rng& rng) {
         const int lost = 5 + static_cast<int>(55 * rng.uniform()), at = any_row(d, 0.5, rng);
         std::vector<int> rows;
         for (int k = 0; k < d.length(); ++k)
           if (k < at || k >= at + lost) rows.push_back(k);
         keep_rows(d, rows);
         return Injected{"gap"};
       }},
      {"rows twice",
       [](D d, R, Rng& rng) {
         const int at = any_row(d, 0.5, rng);
         std::vector<int> rows;
         for (int k = 0; k < d.length(); ++k)
           for (int copy = 0; copy < (k >= at && k < at + 3 ? 2 : 1); ++copy) rows.push_back(k);
         keep_rows(d, rows);
         return Injected{"duplicate"};
       }},
      {"times off by 5 % of the period",
       [](D d, R, Rng& rng) {
         for (int k = 0; k < d.length(); ++k) d.t[k] += 0.05 * d.dt() * rng.normal();
         return Injected{"jitter"};
       }},
      {"clock off by up to 1 %",
       [](D d, R, Rng&) {
         d.t = (d.t.array() * (1 + 0.005 * d.t.array() / d.t[d.length() - 1])).eval();
         return Injected{"clock_drift"};
       }},
      {"4 % stale packets",
       [](D d, R, Rng&) {
         for (int k = 1; k < d.length(); ++k)
           if (k % 25 == 3)
             for (RowMatrix* x : tables(d)) x->row(k) = x->row(k - 1).eval();
         return Injected{"repeated"};
       }},
      {"rows of a source of a third of the rate",
       [](D d, R, Rng&) {
         for (int k = 0; k < d.length(); ++k)
           for (RowMatrix* x : tables(d)) x->row(k) = x->row(k - k % 3).eval();
         return Injected{"held"};
       }},
      {"torque of a source of half the rate",
       [](D d, R, Rng&) {
         for (int k = 1; k < d.length(); k += 2) d.tau.row(k) = d.tau.row(k - 1).eval();
         return Injected{"held"};
       }},
      {"0.2 s missing",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng), at = any_row(d, 0.5, rng);
         d.q.col(j)
             .segment(at, static_cast<int>(0.2 * d.rate_hz))
             .setConstant(std::numeric_limits<double>::quiet_NaN());
         return Injected{"missing", j};
       }},
      {"torque late by 1.5 samples to 0.2 s",
       [](D d, R, Rng& rng) {
         const double least = 1.5, most = 0.2 * d.rate_hz;
         const double samples = least * std::pow(most / least, rng.uniform());
         delay_torque(d, samples);
         return Injected{"delay", -1, samples};
       }},
      {"torque of the other sign",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         d.tau.col(j) *= -1;
         return Injected{"sign", j};
       }},
      {"motion of the other sign",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         d.q.col(j) *= -1;
         d.v.col(j) *= -1;
         return Injected{"sign", j};
       }},
      {"arm on its head",
       [](D, R robot, Rng&) {
         robot.gravity *= -1;
         return Injected{"mount"};
       }},
      {"neighbours swapped",
       [](D d, R, Rng& rng) {
         const int j = std::max(1, any_joint(d, rng));
         for (RowMatrix* x : tables(d)) x->col(j).swap(x->col(j - 1));
         return Injected{"swapped", j};
       }},
      {"torques of neighbours swapped",
       [](D d, R, Rng& rng) {
         const int j = std::max(1, any_joint(d, rng));
         d.tau.col(j).swap(d.tau.col(j - 1));
         return Injected{"swapped", j};
       }},
      {"degrees",
       [](D d, R robot, Rng&) {
         for (int j = 0; j < d.n(); ++j)
           if (turns(robot, j))
             for (RowMatrix* x : {&d.q, &d.v}) x->col(j) /= kDegree;
         return Injected{"angle_unit"};
       }},
      {"torque in N mm",
       [](D d, R, Rng&) {
         d.tau *= 1000;
         return Injected{"torque_unit"};
       }},
      {"torque of one motor before its gear",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         d.tau.col(j) /= 120;
         return Injected{"torque_unit", j};
       }},
      {"velocity before the gear",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         d.v.col(j) *= 100;
         return Injected{"velocity", j};
       }},
      {"temperature in degrees Celsius",
       [](D d, R, Rng&) {
         d.temperature.array() -= 273.15;
         return Injected{"temperature_unit"};
       }},
      {"position in steps of 0.1 degrees",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         d.q.col(j) = (d.q.col(j).array() / (0.1 * kDegree)).round() * (0.1 * kDegree);
         return Injected{"quantised", j};
       }},
      {"torque in 20 steps",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         const double step = (d.tau.col(j).maxCoeff() - d.tau.col(j).minCoeff()) / 20;
         d.tau.col(j) = (d.tau.col(j).array() / step).round() * step;
         return Injected{"quantised", j};
       }},
      {"torque clipped at 70 %",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         const double limit = 0.7 * d.tau.col(j).cwiseAbs().maxCoeff();
         d.tau.col(j) = d.tau.col(j).cwiseMax(-limit).cwiseMin(limit).eval();
         return Injected{"saturated", j};
       }},
      {"position stuck for 1 s in motion",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng), k = row_in_motion(d, j, rng);
         d.q.col(j).segment(k, static_cast<int>(d.rate_hz)).setConstant(d.q(k, j));
         return Injected{"stuck", j};
       }},
      {"torque stuck for 1 s",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng), k = row_in_motion(d, j, rng);
         d.tau.col(j).segment(k, static_cast<int>(d.rate_hz)).setConstant(d.tau(k, j));
         return Injected{"stuck", j};
       }},
      {"joint that stands still",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         d.q.col(j).setConstant(d.q(0, j));
         d.v.col(j).setZero();
         return Injected{"still", j};
       }},
      {"spike in the position",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         d.q(any_row(d, 0.5, rng), j) += 0.05 * (d.q.col(j).maxCoeff() - d.q.col(j).minCoeff());
         return Injected{"spike", j};
       }},
      {"spikes in the torque",
       [](D d, R, Rng& rng) {
         const int j = any_joint(d, rng);
         const double range = d.tau.col(j).maxCoeff() - d.tau.col(j).minCoeff();
         for (int spike = 0; spike < 3; ++spike) d.tau(any_row(d, 0.5, rng), j) += range;
         return Injected{"spike", j};
       }},
      {"position loses a turn",
       [](D d, R robot, Rng& rng) {
         const int j = any_joint(d, rng);
         if (!turns(robot, j)) return Injected{};
         d.q.col(j).tail(d.length() - any_row(d, 0.5, rng)).array() += 2 * std::numbers::pi;
         return Injected{"jump", j};
       }},
      {"position slips by 1 to 10 degrees",
       [](D d, R robot, Rng& rng) {
         const int j = any_joint(d, rng);
         if (!turns(robot, j)) return Injected{};
         d.q.col(j).tail(d.length() - any_row(d, 0.5, rng)).array() +=
             (1 + 9 * rng.uniform()) * kDegree;
         return Injected{"jump", j};
       }},
      {"comes to rest, position in steps of 0.005 degrees",
       [](D d, R, Rng&) {
         come_to_rest(d);
         d.q = (d.q.array() / (0.005 * kDegree)).round() * (0.005 * kDegree);
         return Injected{};
       },
       true},
      {"taken up to a fifth of the period late, and stamped so",
       [](D d, R, Rng& rng) {
         take_late(d, 0.2, rng);
         return Injected{"uneven"};
       }},
      {"torque through a filter of first order, corner 2 to 3 Hz",
       [](D d, R, Rng& rng) {
         const double share = std::min(1.0, 2 * std::numbers::pi * (2 + rng.uniform()) / d.rate_hz);
         for (int k = 1; k < d.length(); ++k)
           d.tau.row(k) = (1 - share) * d.tau.row(k - 1) + share * d.tau.row(k);
         return Injected{"low_pass"};
       }},
      {"1 % of the rows lost, time by the number of rows",
       [](D d, R, Rng& rng) {
         std::vector<int> rows;
         for (int k = 0; k < d.length(); ++k)
           if (rng.uniform() > 0.01) rows.push_back(k);
         const Eigen::VectorXd t = d.t.head(std::ssize(rows));
         keep_rows(d, rows);
         d.t = t;
         return Injected{"lost"};
       }},
      {"rows of two robots in turn",
       [](D d, R, Rng&) {
         std::vector<int> rows;  // of the second robot another part of the motion
         for (int k = 0; k < d.length(); ++k)
           rows.push_back(k % 2 == 0 ? k : (k + d.length() / 3) % d.length());
         const Eigen::VectorXd t = d.t;
         keep_rows(d, rows);
         d.t = t;
         return Injected{"in_turn"};
       }},
      {"2 % of the rows behind the next",
       [](D d, R, Rng& rng) {
         std::vector<int> rows;
         for (int k = 0; k < d.length(); ++k) rows.push_back(k);
         for (std::size_t k = 1; k < rows.size(); ++k)
           if (rng.uniform() < 0.02) std::swap(rows[k - 1], rows[k]);
         keep_rows(d, rows);
         return Injected{"out_of_order"};
       }},
  };
}

constexpr std::array kArms{"kr6_full",
                           "kr6_lugre",
                           "kr6_load",
                           "kr6_stickslip",
                           "kr6_thermal",
                           "models/kuka_kr300/kuka_kr300.urdf",
                           "models/test/arm_7r.urdf",
                           "models/test/scara.urdf"};

struct Movement {
  const char* what;
  double base_rad_s;
  int harmonics;
};
constexpr std::array kMotions{Movement{"slow", 0.3, 8}, Movement{"fast", 1, 5}};

// An arm by its URDF alone, with the friction of its effort limits.
std::string scene_of(const std::string& urdf) {
  return fmt::format(R"(
name = "arm"
[robot]
urdf = "{}"
[friction]
[excitation]
velocity_share = 0.7
clearance_m = 0.0
[sensors]
encoder_noise_rad = 4e-6
encoder_step_rad = 4e-6
torque_noise = 0.0005
torque_step = 0.0005
)",
                     (source_dir() / urdf).string());
}

}  // namespace

RobotModel as_in_a_file(RobotModel robot, int i) {
  Rng rng(23, static_cast<std::uint64_t>(i));
  const auto about_one = [&] { return std::exp(0.15 * rng.normal()); };
  for (int j = 0; j < robot.n(); ++j) {
    robot.pi.segment<10>(10 * j) *= about_one();
    robot.pi[robot.armature_begin() + j] *= i % 2 == 0 ? about_one() : 0;
  }
  return robot;
}

void delay_torque(Dataset& d, double samples) {
  const RowMatrix old = d.tau;
  for (int k = 0; k < d.length(); ++k) {
    const double at = std::clamp(k - samples, 0.0, static_cast<double>(d.length() - 1));
    const int i = std::min(static_cast<int>(at), d.length() - 2);
    d.tau.row(k) = (1 - (at - i)) * old.row(i) + (at - i) * old.row(i + 1);
  }
}

const std::vector<Injection>& injections() {
  static const std::vector<Injection> all = make_injections();
  return all;
}

int number_of_clean_logs() { return static_cast<int>(kArms.size() * kMotions.size()); }

CleanLog simulate_log(int i) {
  const std::string arm = kArms[static_cast<std::size_t>(i) % kArms.size()];
  const Movement& motion = kMotions[static_cast<std::size_t>(i) / kArms.size()];
  scene::Scene s = arm.starts_with("kr6")
                       ? scene::load_scene(source_dir() / "scenes" / (arm + ".toml"))
                       : scene::load_scene_text(scene_of(arm));
  s.seed = static_cast<std::uint64_t>(i + 1);
  s.excitation.train = s.excitation.repeats = 1;
  s.excitation.validation = 0;
  s.excitation.criterion = sim::Criterion::kNone;
  s.excitation.harmonics = motion.harmonics;
  s.excitation.base_rad_s = motion.base_rad_s;
  s.sensors.rate_hz = 1000;
  s.plant.step_s = kSimulatorStep;
  s.sensors.velocity = s.sensors.temperature = true;
  const scene::Problem problem = scene::resolve(std::move(s));
  return {fmt::format("{}, {}", arm, motion.what), sim::simulate(problem, 1).train[0],
          as_in_a_file(problem.robot, i)};
}

Dataset decimated(const Dataset& log, int every) {
  Dataset d = log;
  std::vector<int> rows;
  for (int k = 0; k < log.length(); k += every) rows.push_back(k);
  keep_rows(d, rows);
  d.rate_hz = log.rate_hz / every;
  return d;
}

Judged judge(const Dataset& damaged, const RobotModel& robot, const Injected& truth) {
  Judged judged;
  for (const Finding& f : diagnose(damaged, &robot)) {
    if (!is_told(f)) continue;
    judged.said += to_text(f, damaged) + "\n";
    if (name_of(f.kind) != truth.name) {
      ++judged.others;
    } else if (truth.joint < 0 || f.joint == truth.joint || f.other == truth.joint) {
      judged.found = true;
      judged.delay_error = f.kind == FindingKind::kDelay ? f.size - truth.samples : 0;
    }
  }
  return judged;
}

}  // namespace fricid::doctor
