// Couplings as files state them, by the names of joints.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::dynamics {

/// A `Coupling` of named joints: [[robot.coupling]] of a scene, [[coupling]] of a contract.
struct NamedCoupling {
  std::string joint, motor;
  double factor = 0;

  bool operator==(const NamedCoupling&) const = default;
  /// For the templates.
  static NamedCoupling example() {
    return {.joint = "joint_a6", .motor = "joint_a5", .factor = -1};
  }
  template <class Archive>
  void visit(Archive& archive) {
    archive("joint", joint, required(text("joint that is turned too")));
    archive("motor", motor, required(text("joint whose motor turns it")));
    archive("factor", factor,
            required(number("1", -10, 10, "turns of the joint per turn of the other")));
  }
};

/// A = 1 + couplings of n joints (n x n): q = A m.
Eigen::MatrixXd joints_of_motors(std::span<const Coupling> couplings, int n);

/// Whether A has an inverse.
bool is_transmission(const Eigen::MatrixXd& A);

/// "file:line" of a key, "robot.coupling[0].joint", for messages.
using PlaceOfKey = std::function<std::string(std::string_view key)>;

/// The couplings of a robot with these joints.
/// @param table  name of the list in its file, "robot.coupling"
/// @throws UserError at the place of a coupling that names no joint or couples one with itself; at
///         that of the last if they leave a joint that no motor turns
std::vector<Coupling> couplings_of(std::span<const NamedCoupling> named,
                                   std::span<const std::string> joints, std::string_view table,
                                   const PlaceOfKey& place);

}  // namespace fricid::dynamics
