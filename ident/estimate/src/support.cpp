#include "support.hpp"

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/data/contract.hpp"

namespace fricid::estimate {

Temperatures temperatures_of(std::span<const signals::Recording> recordings) {
  double sum = 0, square = 0, count = 0;
  for (const signals::Recording& r : recordings) {
    sum += r.temperature.sum();
    square += r.temperature.squaredNorm();
    count += static_cast<double>(r.temperature.size());
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, square / count - mean * mean))};
}

bool is_beyond_gear(std::span<const signals::Recording> recordings) {
  return std::ranges::any_of(
      recordings, [](const signals::Recording& r) { return data::is_link_torque(r.log); });
}

Eigen::VectorXd filtered_torque_rms(std::span<const signals::Recording> recordings) {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(recordings.front().n());
  double rows = 0;
  for (const signals::Recording& r : recordings) {
    squares += r.filtered_tau.colwise().squaredNorm().transpose();
    rows += static_cast<double>(r.filtered_tau.rows());
  }
  return (squares / rows).cwiseSqrt();
}

int reversals_in(const Eigen::Ref<const Eigen::VectorXd, 0, Eigen::InnerStride<>>& v,
                 double least) {
  int reversals = 0;
  double direction = 0;
  for (const double speed : v) {
    if (std::abs(speed) < least) continue;
    reversals += speed * direction < 0;
    direction = speed;
  }
  return reversals;
}

friction::JointSpec joint_spec_of(const ModelOptions& config) {
  const auto law_of = [&](std::string_view name, int elements,
                          const std::vector<std::string>& modifiers) -> friction::LawSpec {
    for (const friction::LawInfo& law : friction::law_table())
      if (law.name == name)
        return {std::string(name), law.has_elements ? elements : 0, modifiers_of(modifiers)};
    std::string known = "simple";
    for (const friction::LawInfo& law : friction::law_table())
      known += fmt::format(", {}", law.name);
    throw UserError("model {}: unknown law \"{}\"; known: {}", config.name, name, known);
  };
  friction::JointSpec joint;
  for (const LawOptions& law : config.laws)
    joint.laws.push_back(law_of(law.law, law.elements, law.modifiers));
  if (!joint.laws.empty()) return joint;
  const std::string_view given = config.law.empty() ? config.name : config.law;
  joint.laws.push_back(
      law_of(given == "simple" ? "coulomb_viscous" : given, config.elements, config.modifiers));
  return joint;
}

friction::FrictionGuess guess_of(const RigidBodyFit& rigid, const JointFrictionData& data,
                                 int joint) {
  return {std::max(rigid.Fc[joint], 0.01 * data.largest_target()), std::max(rigid.Fv[joint], 0.0)};
}

}  // namespace fricid::estimate
