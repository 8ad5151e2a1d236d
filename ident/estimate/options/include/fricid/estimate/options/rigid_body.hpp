// Options of the rigid-body fit, as in a scene.
#pragma once

#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/dynamics/nominal.hpp"

namespace fricid::estimate {

/// [identify.prior]: the CAD values as a prior, for excitation too short to identify them.
struct PriorOptions {
  bool use = false;
  double mass = 0.15;
  double com_m = 0.02;
  double inertia = 0.3;
  double armature = 0.3;

  template <class Archive>
  void visit(Archive& archive) {
    archive("use", use, flag("use the robot's nominal values as a prior"));
    archive("mass", mass, number("1", 1e-6, 1e3, "relative standard deviation of each mass"));
    archive("com_m", com_m, number("m", 1e-6, 10, "standard deviation of each centre of mass"));
    archive("inertia", inertia,
            number("1", 1e-6, 1e3, "relative standard deviation of each inertia"));
    archive("armature", armature,
            number("1", 1e-6, 1e3, "relative standard deviation of each armature"));
  }
};

/// [identify]: the least-squares stage and its data, common to all models.
struct RigidBodyOptions {
  double first_s = 0;
  double cutoff_hz = 10;
  double min_speed_rad_s = 0.2;
  PriorOptions prior;

  // Not keys of a scene.
  /// Rows with |v_j| > min_speed_rad_s enter unless joint j stands or turns within so many periods
  /// of the cut-off: the filter spreads the torque of a reversal, which the sign of a velocity
  /// tells badly, over that time. Of a joint that reverses so often that less than a quarter of its
  /// fast rows are left it is shorter, down to a quarter. A slow joint's rows enter above 15 % of
  /// the speed that it exceeds 5 % of the time, where that is less.
  double memory_periods = 2.5;
  bool robust = true;  ///< Huber weights beyond 2.5 sigma
  bool offset = true;  ///< a constant torque per joint beside Coulomb and viscous friction
  /// Without `prior.use` too, where the data alone do not determine the base parameters: condition
  /// above 1e4, or fewer rows than unknowns.
  bool prior_where_needed = true;
  /// Joints whose armature is held at its nominal value, see `RigidBodyFit::without_inertia`.
  std::vector<int> held_armatures;
  dynamics::Guesses guesses;  ///< guessed parameters, with a prior width of three times their value
  /// (n_c or fewer) standard deviation of the coefficient of each linear torque about its given
  /// value [N m]; infinite or missing: free.
  std::vector<double> linear_prior_sd;

  template <class Archive>
  void visit(Archive& archive) {
    archive("first_s", first_s,
            number("s", 0, 1e9,
                   "length of training data that is used, from the first recording on; 0: all"));
    archive("cutoff_hz", cutoff_hz,
            number("Hz", 0.01, 1e4, "cut-off of the zero-phase low pass (Butterworth, order 4)"));
    archive("min_speed_rad_s", min_speed_rad_s,
            number("rad/s", 0, 100, "speed below which rows do not enter the base parameters"));
    archive.section("prior", prior, "standard deviations about the nominal robot");
  }
};

}  // namespace fricid::estimate
