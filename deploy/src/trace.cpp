#include "trace.hpp"

#include <span>

#include "fricid/friction/detail/kernels.hpp"

namespace fricid::deploy {
namespace {

struct Arguments {
  std::vector<Symbol> theta, z, tau_f;
  std::vector<friction::Input<Symbol>> in;

  Arguments(Graph& graph, const friction::RobotFriction& friction)
      : tau_f(static_cast<std::size_t>(friction.joint_count())) {
    for (int i = 0; i < friction.parameter_count(); ++i)
      theta.emplace_back(graph, graph.add(Op::kParameter, i));
    for (int i = 0; i < friction.state_size(); ++i) z.emplace_back(graph, graph.add(Op::kState, i));
    for (int j = 0; j < friction.joint_count(); ++j) {
      const auto field = [&](Field which) {
        return Symbol(graph, graph.add(Op::kInput, j, static_cast<int>(which)));
      };
      in.push_back(
          {field(Field::kQ), field(Field::kV), field(Field::kLoad), field(Field::kTemperature)});
    }
  }
};

std::vector<int> nodes_of(const std::vector<Symbol>& values, Graph& graph) {
  std::vector<int> nodes;
  for (const Symbol& value : values) nodes.push_back(value.in(graph));
  return nodes;
}

}  // namespace

Traced trace(const friction::RobotFriction& friction) {
  Traced traced;
  {
    Arguments x(traced.torque, friction);
    friction.torque<Symbol>(x.theta, x.in, x.z, x.tau_f);
    traced.tau_f = nodes_of(x.tau_f, traced.torque);
  }
  {
    Arguments x(traced.step, friction);
    friction.step<Symbol>(x.theta, x.in, kStep, x.z);
    traced.z_next = nodes_of(x.z, traced.step);
  }
  return traced;
}

std::vector<double> traced_theta(const friction::Friction& friction) {
  const std::vector<double> rates = friction::training_rates(friction.model, friction.theta);
  std::vector<double> theta = friction.theta;
  for (std::size_t p = 0; p < theta.size(); ++p)
    if (rates[p] == 0) theta[p] = 0;
  return theta;
}

}  // namespace fricid::deploy
