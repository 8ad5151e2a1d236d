#include "fricid/estimate/wash_out.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/pack.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/system/initial_state.hpp"

namespace fricid::estimate {
namespace {

// a piece of a recording that one lane washes out
constexpr double kPiece = 4, kRunIn = 4;  // [s]
struct Piece {
  int recording, begin, end;
};

/// Drives the friction through up to one piece per lane, each from `run_in` samples ahead of it.
void wash_out_pieces(const friction::Friction& friction,
                     std::span<const signals::Recording> recordings, std::span<const Piece> pieces,
                     int run_in, signals::Band band, std::span<const std::vector<double>> z0,
                     std::vector<RowMatrix>& z) {
  const friction::RobotFriction& model = friction.model;
  const auto n = static_cast<std::size_t>(model.joint_count());
  const std::vector<PackD> theta(friction.theta.begin(), friction.theta.end());
  std::vector<PackD> state(static_cast<std::size_t>(model.state_size()), PackD(0));
  std::vector<friction::Input<PackD>> in(n);
  int first = 0, last = 0;  // of the steps relative to each piece's begin
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& p = pieces[i];
    first = std::min(first, -std::min(run_in, p.begin));
    last = std::max(last, p.end - p.begin);
    if (p.begin <= run_in)
      for (std::size_t k = 0; k < state.size(); ++k)
        set_lane(state[k], static_cast<int>(i), z0[static_cast<std::size_t>(p.recording)][k]);
  }
  for (int step = first; step < last; ++step) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const Piece& p = pieces[i];
      const int row = p.begin + step, lane = static_cast<int>(i);
      const auto at = static_cast<std::size_t>(p.recording);
      const signals::Recording& r = recordings[at];
      const RowMatrix& q = r.motion(band).q;
      if (step >= 0 && row < p.end)
        for (std::size_t k = 0; k < state.size(); ++k)
          z[at](row, static_cast<Eigen::Index>(k)) = fricid::lane(state[k], lane);
      // before its recording begins and after its piece ends a lane stands still
      const bool moves = row >= 0 && row + 1 < p.end;
      const int from = std::clamp(row, 0, p.end - 1), to = moves ? row + 1 : from;
      for (std::size_t j = 0; j < n; ++j) {
        const auto c = static_cast<Eigen::Index>(j);
        set_lane(in[j].q, lane, q(to, c));
        set_lane(in[j].v, lane, (q(to, c) - q(from, c)) / r.dt);
        set_lane(in[j].load, lane, r.held_tau(from, c));
        set_lane(in[j].temperature, lane, r.temperature(from, c));
      }
    }
    model.step<PackD>(theta, in, recordings.front().dt, state);
  }
}

}  // namespace

std::vector<RowMatrix> wash_out(const Arm& arm, std::span<const signals::Recording> recordings,
                                int jobs, signals::Band band) {
  std::vector<RowMatrix> z;
  std::vector<std::vector<double>> z0(recordings.size());
  std::vector<Piece> pieces;
  const double dt = recordings.front().dt;
  // a law of the whole robot may keep its initial state: each recording in one piece
  int length = std::max(1, static_cast<int>(std::lround(kPiece / dt)));
  if (arm.friction.model.has_whole())
    for (const signals::Recording& r : recordings) length = std::max(length, r.length());
  const int run_in = static_cast<int>(std::lround(kRunIn / dt));
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const int T = recordings[i].length();
    z.push_back(RowMatrix::Zero(T, arm.friction.model.state_size()));
    for (int begin = 0; begin < T; begin += length)
      pieces.push_back({static_cast<int>(i), begin, std::min(T, begin + length)});
  }
  parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
    const signals::Recording& r = recordings[static_cast<std::size_t>(i)];
    const signals::Motion& motion = r.motion(band);
    z0[static_cast<std::size_t>(i)] =
        initial_friction_state(arm, r.dt, motion.q, motion.v, r.held_tau, r.temperature);
  });
  const int groups = (static_cast<int>(pieces.size()) + PackD::kLanes - 1) / PackD::kLanes;
  parallel_for(groups, jobs, [&](int g) {
    const auto begin = static_cast<std::size_t>(g * PackD::kLanes);
    const auto count = std::min<std::size_t>(PackD::kLanes, pieces.size() - begin);
    wash_out_pieces(arm.friction, recordings, std::span(pieces).subspan(begin, count), run_in, band,
                    z0, z);
  });
  return z;
}

}  // namespace fricid::estimate
