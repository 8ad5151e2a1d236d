#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fricid/base/csv.hpp"
#include "fricid/deploy/c_header.hpp"
#include "writers.hpp"

namespace fricid::deploy {
namespace {

// Joints that slide have columns of their own, since their units are others.
struct Columns {
  bool turn = false, slide = false;

  explicit Columns(const std::vector<dynamics::Joint>& joints)
      : turn(!std::ranges::all_of(joints, dynamics::slides)),
        slide(std::ranges::any_of(joints, dynamics::slides)) {}

  std::string header() const {
    return fmt::format("joint{}{}\n", turn ? ",velocity_rad_s,friction_Nm" : "",
                       slide ? ",velocity_m_s,friction_N" : "");
  }
  std::string line(const dynamics::Joint& joint, double v, double tau_f) const {
    const bool slides = dynamics::slides(joint);
    return fmt::format("{}{},{:.9g},{:.9g}{}\n", csv_cell(joint.name), turn && slides ? ",," : "",
                       v, tau_f, slide && !slides ? ",," : "");
  }
};

// Speeds from 1e-4 of the fastest on, evenly on a logarithmic scale.
std::vector<double> speeds(double fastest) {
  constexpr int kCount = 41;
  std::vector<double> result;
  for (int i = kCount - 1; i >= 0; --i)
    result.push_back(-fastest * std::pow(10, -4.0 * (kCount - 1 - i) / (kCount - 1)));
  result.push_back(0);
  for (int i = kCount - 1; i >= 0; --i) result.push_back(-result[static_cast<std::size_t>(i)]);
  return result;
}

}  // namespace

Exported write_csv(const data::ModelFile& model) {
  constexpr double kUsual = 3;  // [rad/s] where no limit is given
  const friction::Friction& friction = model.arm.friction;
  const auto n = static_cast<std::size_t>(model.arm.robot.n());
  const Columns columns(model.arm.robot.joints);
  std::string text = columns.header();
  std::vector<double> tau_f(n);
  for (std::size_t j = 0; j < n; ++j) {
    const dynamics::Joint& joint = model.arm.robot.joints[j];
    for (const double v : speeds(joint.velocity > 0 ? joint.velocity : kUsual)) {
      std::vector<friction::Input<double>> in(n, {0, 0, 0, kRoomTemperature});
      in[j].v = v;
      if (friction.model.joint_count() > 0)
        friction.model.steady_torque<double>(friction.theta, in, tau_f);
      text += columns.line(joint, v, tau_f[j]);
    }
  }
  Exported exported{.files = {{code_name(model) + "_friction.csv", text}},
                    .losses = torques_left_out(model.arm.robot, false)};
  exported.losses.emplace_back(fmt::format(
      "steady sliding alone, at q = 0, no load, {} K, other joints at rest: presliding, hysteresis "
      "and what depends on q, load or temperature are left out",
      kRoomTemperature));
  if (model.arm.robot.coupled())
    exported.losses.push_back("velocity and friction are those of the motors: " +
                              motors_in_words(model.arm.robot));
  return exported;
}

}  // namespace fricid::deploy
