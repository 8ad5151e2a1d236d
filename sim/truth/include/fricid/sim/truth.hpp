// Ground truth of a simulated recording, in a struct and file of its own. No estimator links this
// library, so none can read it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/sim/trace.hpp"

namespace fricid::sim {

/// A friction as JSON and back:
/// {"joints": [{"laws": [{"law", "elements", "modifiers": [{"name", "order"}],
///                        "parameters": [{"owner", "symbol", "value", "unit"}]}]}]}.
std::string friction_text(const friction::Friction& friction);
/// @param place  of the text, for messages
/// @throws UserError on text that is not of the form that `friction_text` writes
friction::Friction friction_of(const std::string& text, const std::string& place);

/// The truth of one sequence. At every sample  M(q) a + h(q, v) + tau_f = tau.
struct Truth {
  static constexpr std::string_view kFormat = "fricid.truth/1";

  std::string name;                      ///< of its data set, e.g. "train_0"
  std::vector<std::string> joint_names;  ///< (n)
  double rate_hz = 0;
  Trace trace;
  friction::Friction friction;

  double dt() const { return 1 / rate_hz; }

  /// All fields but the name, which is that of the file.
  template <class Archive>
  void visit(Archive& archive) {
    archive.joints(joint_names);
    archive.attribute("rate_hz", rate_hz, number("Hz", 0, 1e6, "sample rate"));
    archive.text_attribute(
        "friction", [&] { return friction_text(friction); },
        [&](const std::string& found, const std::string& place) {
          friction = friction_of(found, place);
        },
        text("the friction that was injected, JSON"));
    archive.times(trace.t);
    archive.of_joints("q", trace.q, signal("rad", "position"));
    archive.of_joints("v", trace.v, signal("rad/s", "velocity"));
    archive.of_joints("a", trace.a, signal("rad/s^2", "acceleration"));
    archive.of_joints("tau", trace.tau, signal("N m", "motor torque applied"));
    archive.of_joints("tau_f", trace.tau_f, signal("N m", "friction torque"));
    archive.of_states("z", trace.z, signal("law's own", "states of the friction"));
    archive.of_joints("temperature", trace.temperature, signal("K", "of the joint"));
  }
};

/// HDF5. Written atomically.
void save_truth(const Truth& truth, const std::filesystem::path& path);
/// @throws UserError naming the file when it is missing, a folder, truncated or of another format
Truth load_truth(const std::filesystem::path& path);

}  // namespace fricid::sim
