#include "mjcf_apart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "in_mujoco.hpp"
#include "law_errors.hpp"

namespace fricid::deploy::test {
namespace {

// Torque that reverses from presliding to sliding [N m].
double torque(double t, int joint) {
  return (2 + 2 * t) * std::sin(2 * M_PI * (0.7 + 0.2 * joint) * t) + 0.8 * std::sin(17 * t);
}

// The flywheels with the law, in explicit steps.
class Flywheels {
 public:
  Flywheels(const friction::Friction& friction, double step)
      : friction_(friction),
        h_(step),
        z_(static_cast<std::size_t>(friction.model.state_size())),
        in_(2, {0, 0, 0, kRoomTemperature}) {}

  void step(const std::array<double, 2>& torque) {
    std::array<double, 2> tau_f{};
    for (std::size_t j = 0; j < 2; ++j) in_[j].load = torque[j];
    friction_.model.torque<double>(friction_.theta, in_, z_, tau_f);
    // two flywheels on one axis: M = I [[2, 1], [1, 1]]
    const double I = 0.1, a = torque[0] - tau_f[0], b = torque[1] - tau_f[1];
    const std::array<double, 2> acceleration{(a - b) / I, (2 * b - a) / I};
    for (std::size_t j = 0; j < 2; ++j) {
      in_[j].v += h_ * acceleration[j];
      in_[j].q += h_ * in_[j].v;
    }
    friction_.model.step<double>(friction_.theta, in_, h_, z_);
  }
  double q(std::size_t joint) const { return in_[joint].q; }
  double v(std::size_t joint) const { return in_[joint].v; }

 private:
  const friction::Friction& friction_;
  double h_;
  std::vector<double> z_;
  std::vector<friction::Input<double>> in_;
};

}  // namespace

Apart apart(const data::ModelFile& model, const Drive& drive) {
  const sim::MjModelPtr m = in_mujoco(export_model(model, "mjcf_friction"));
  m->opt.timestep = drive.step;
  m->opt.integrator = drive.integrator;
  const sim::MjDataPtr d(mj_makeData(m.get()));
  Flywheels exact(model.arm.friction, drive.step / drive.substeps),
      coarse(model.arm.friction, drive.step);
  double most = 0, least = 0;
  Apart squares;
  const int length = static_cast<int>(std::lround(4 / drive.step));
  for (int k = 0; k < length; ++k) {
    std::array<double, 2> torques{};
    for (int j = 0; j < 2; ++j)
      torques[static_cast<std::size_t>(j)] = d->qfrc_applied[j] =
          drive.share * torque(k * drive.step, j);
    mj_step(m.get(), d.get());
    coarse.step(torques);
    for (int s = 0; s < drive.substeps; ++s) exact.step(torques);
    for (std::size_t j = 0; j < 2; ++j) {
      squares.rms += std::pow(d->qpos[j] - exact.q(j), 2);
      squares.law_rms += std::pow(coarse.q(j) - exact.q(j), 2);
      squares.half_step += std::pow(drive.step / 2 * exact.v(j), 2);
      most = std::max(most, exact.q(j)), least = std::min(least, exact.q(j));
    }
  }
  const auto root = [&](double sum) { return std::sqrt(sum / (2 * length)); };
  return {root(squares.rms), root(squares.law_rms), most - least, root(squares.half_step)};
}

data::ModelFile gms_without_stribeck() {
  data::ModelFile model = robot_with("gms");
  friction::Friction& friction = model.arm.friction;
  for (int j = 0; j < 2; ++j)
    friction.theta[static_cast<std::size_t>(
        find_parameter(friction.model, j, friction::Role::kStatic))] =
        friction.theta[static_cast<std::size_t>(
            find_parameter(friction.model, j, friction::Role::kCoulomb))];
  return model;
}

}  // namespace fricid::deploy::test
