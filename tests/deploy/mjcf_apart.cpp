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

}  // namespace

Apart apart(const data::ModelFile& model, const Drive& drive) {
  const sim::MjModelPtr m = in_mujoco(export_model(model, "mjcf_friction"));
  m->opt.timestep = drive.step;
  const sim::MjDataPtr d(mj_makeData(m.get()));
  const friction::Friction& friction = model.arm.friction;
  std::vector<double> z(static_cast<std::size_t>(friction.model.state_size())), tau_f(2);
  std::vector<friction::Input<double>> in(2, {0, 0, 0, kRoomTemperature});
  const double h = drive.step / drive.substeps;
  double sum = 0, most = 0, least = 0;
  const int length = static_cast<int>(std::lround(4 / drive.step));
  for (int k = 0; k < length; ++k) {
    for (int j = 0; j < 2; ++j)
      in[static_cast<std::size_t>(j)].load = d->qfrc_applied[j] =
          drive.share * torque(k * drive.step, j);
    mj_step(m.get(), d.get());
    for (int s = 0; s < drive.substeps; ++s) {
      friction.model.torque<double>(friction.theta, in, z, tau_f);
      // two flywheels on one axis: M = I [[2, 1], [1, 1]]
      const double I = 0.1, a = in[0].load - tau_f[0], b = in[1].load - tau_f[1];
      const std::array<double, 2> acceleration{(a - b) / I, (2 * b - a) / I};
      for (std::size_t j = 0; j < 2; ++j) {
        in[j].v += h * acceleration[j];
        in[j].q += h * in[j].v;
      }
      friction.model.step<double>(friction.theta, in, h, z);
    }
    for (int j = 0; j < 2; ++j) {
      const double q = in[static_cast<std::size_t>(j)].q;
      sum += std::pow(d->qpos[j] - q, 2) / (2 * length);
      most = std::max(most, q), least = std::min(least, q);
    }
  }
  return {std::sqrt(sum), most - least};
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
