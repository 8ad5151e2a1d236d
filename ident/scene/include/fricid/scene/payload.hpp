// [payload]: a load that is unknown to the fits, to be found from recordings with it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fricid/base/field.hpp"

namespace fricid::scene {

/// Recordings with the load are logs, or of the arm that the simulator loads.
struct PayloadSection {
  std::vector<std::string> logs;
  std::string frame = "flange";
  double mass_kg = 0;
  std::array<double, 3> com{};
  std::array<double, 6> inertia{};

  bool wanted() const { return mass_kg > 0 || !logs.empty(); }

  template <class Archive>
  void visit(Archive& archive) {
    archive("logs", logs, text("logs with the load, of the contract of [data]"));
    archive("frame", frame, text("frame of the URDF that carries the load"));
    archive("mass_kg", mass_kg, number("kg", 0, 2000, "of the load that the simulator adds"));
    archive("com", com, number("m", -5, 5, "its centre of mass in the frame"));
    archive("inertia", inertia,
            number("kg m^2", -1e4, 1e4, "Ixx, Iyy, Izz, Ixy, Ixz, Iyz about its centre of mass"));
  }
};

}  // namespace fricid::scene
