// Friction of a joint along its recorded motion, pieces side by side.
#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>

#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/friction/laws/maxwell_slip.hpp"

namespace fricid::estimate {

// Where two pieces meet, their states differ by at most this share of their size.
inline constexpr double kForgotten = 1e-6;

/// Travel over which the springs of maxwell_slip follow the joint, the longest [rad or m].
inline double longest_spring(const friction::RobotFriction& friction,
                             std::span<const double> theta) {
  double longest = 0;
  for (std::size_t K = 0; const friction::ParameterRef& p : friction.parameters()) {
    if (p.owner == friction::MaxwellSlip::kName && p.info.role == friction::Role::kStiffness)
      longest = std::max(longest, theta[K + 1] / theta[K]);
    ++K;
  }
  return longest;
}

/// Where the state of a joint's single spring is, a maxwell_slip of one element; < 0: it has none.
inline int state_of_single_spring(const friction::RobotFriction& friction) {
  const friction::JointSpec& joint = friction.joints().front();
  for (std::size_t i = 0; i < joint.laws.size(); ++i)
    if (joint.laws[i].law == friction::MaxwellSlip::kName && joint.laws[i].elements == 1) {
      friction::JointSpec before = joint;
      before.laws.resize(i);
      return before.laws.empty() ? 0 : friction::RobotFriction({before}).state_size();
    }
  return -1;
}

template <class Driver>
bool JointFrictionData::drive(std::span<const Group> groups,
                              const friction::RobotFriction& friction, Driver& driver) const {
  const auto states = static_cast<std::size_t>(friction.state_size());
  const int spring = spring_.empty() ? -1 : state_of_single_spring(friction);
  // states at which a piece begins after its run-in, or ends where another begins
  struct Passed {
    int sequence, sample;
    bool begins;
    std::vector<double> z;
  };
  std::vector<Passed> passed;
  std::vector<PackD> z(states);
  std::vector<LaneSample> lanes;
  for (const Group& group : groups) {
    std::ranges::fill(z, PackD(0));
    for (int lane = 0; const MotionPiece& piece : group.pieces) {
      if (spring >= 0 && piece.start == 0)
        z[static_cast<std::size_t>(spring)].set(lane,
                                                spring_[static_cast<std::size_t>(piece.sequence)]);
      ++lane;
    }
    driver.reset();
    const int longest = static_cast<int>(group.at.size());
    const auto pass = [&](const MotionPiece& piece, int lane, int sample) {
      const bool begins = sample == piece.begin;
      const SampleRange& range = series_[static_cast<std::size_t>(piece.sequence)].range;
      if (sample == (begins ? range.begin : range.end)) return;
      Passed& at = passed.emplace_back(piece.sequence, sample, begins, std::vector<double>(states));
      for (std::size_t i = 0; i < states; ++i) at.z[i] = z[i][lane];
    };
    std::vector<int> changes;  // steps at which a piece begins or ends
    for (const MotionPiece& piece : group.pieces)
      changes.insert(changes.end(), {piece.begin - piece.start, piece.end - piece.start});
    std::ranges::sort(changes);
    changes.erase(std::ranges::unique(changes).begin(), changes.end());
    auto next = changes.begin();
    const auto change = [&](int k) {
      lanes.clear();
      for (int lane = 0; const MotionPiece& piece : group.pieces) {
        const int sample = piece.start + k;
        if (sample == piece.begin || sample == piece.end) pass(piece, lane, sample);
        if (sample >= piece.begin && sample < piece.end)
          lanes.push_back(
              {lane, static_cast<std::size_t>(piece.sequence), static_cast<std::size_t>(sample)});
        ++lane;
      }
    };
    lanes.clear();
    for (int k = 0; k <= longest; ++k) {
      for (LaneSample& at : lanes) ++at.sample;
      if (next != changes.end() && *next == k) {
        change(k);
        ++next;
      }
      if (k == longest) break;
      const auto step = static_cast<std::size_t>(k);
      if (!lanes.empty()) driver.torque(group.at[step], z, lanes);
      driver.step(over_sample(group.over, step), z);
    }
  }

  std::ranges::sort(passed, {},
                    [](const Passed& p) { return std::tuple(p.sequence, p.sample, p.begins); });
  std::vector<double> size(states, 0.0);
  for (const Passed& at : passed)
    for (std::size_t i = 0; i < states; ++i) size[i] = std::max(size[i], std::abs(at.z[i]));
  for (std::size_t k = 0; k + 1 < passed.size(); k += 2)
    for (std::size_t i = 0; i < states; ++i)
      if (!(std::abs(passed[k].z[i] - passed[k + 1].z[i]) <= kForgotten * size[i])) return false;
  return true;
}

template <class Driver>
void JointFrictionData::drive(const friction::RobotFriction& friction,
                              std::span<const double> theta, Driver& driver) const {
  if (2 * longest_spring(friction, theta) <= run_in_ && drive(groups_, friction, driver)) return;
  std::vector<MotionPiece> whole;
  for (int s = 0; s < sequences(); ++s) {
    const SampleRange& range = series_[static_cast<std::size_t>(s)].range;
    if (range.size() > 0) whole.push_back({s, 0, range.begin, range.end});
  }
  drive(side_by_side(whole), friction, driver);
}

}  // namespace fricid::estimate
