#include "fricid/dynamics/couplings.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"

namespace fricid::dynamics {

Eigen::MatrixXd joints_of_motors(std::span<const Coupling> couplings, int n) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
  for (const Coupling& coupling : couplings) A(coupling.joint, coupling.motor) += coupling.factor;
  return A;
}

bool is_transmission(const Eigen::MatrixXd& A) {
  constexpr double kLeast = 1e-3;
  return std::abs(A.determinant()) > kLeast;
}

std::vector<Coupling> couplings_of(std::span<const NamedCoupling> named,
                                   std::span<const std::string> joints, std::string_view table,
                                   const PlaceOfKey& place) {
  const auto at = [&](std::size_t i, std::string_view key) {
    return fmt::format("{}: {}[{}]{}", place(fmt::format("{}[{}]{}", table, i, key)), table, i + 1,
                       key);
  };
  std::vector<Coupling> couplings;
  for (std::size_t i = 0; i < named.size(); ++i) {
    const NamedCoupling& c = named[i];
    const auto index = [&](std::string_view key, const std::string& name) {
      const auto found = std::ranges::find(joints, name);
      if (found == joints.end())
        throw UserError("{} = \"{}\"; allowed: {}", at(i, key), name, fmt::join(joints, ", "));
      return static_cast<int>(found - joints.begin());
    };
    const int joint = index(".joint", c.joint), motor = index(".motor", c.motor);
    if (joint == motor) throw UserError("{} couples {} with itself", at(i, ""), c.joint);
    couplings.push_back({joint, motor, c.factor});
  }
  if (!couplings.empty() &&
      !is_transmission(joints_of_motors(couplings, static_cast<int>(joints.size()))))
    throw UserError(
        "{}, with those before it, leaves a joint that no motor turns alone; allowed: factors by "
        "which the motors turn every joint",
        at(named.size() - 1, ""));
  return couplings;
}

}  // namespace fricid::dynamics
