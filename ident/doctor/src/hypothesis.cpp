#include "hypothesis.hpp"

#include <string>
#include <utility>

namespace fricid::doctor {
namespace {

using data::RowMatrix;

// Whether the logged velocity goes with the logged position of joint j.
bool velocity_follows(const data::Dataset& d, const Motion& motion, int j) {
  if (d.v.size() == 0) return false;
  const VelocityProducts sums = compare_velocity(motion, j, [&](int k) { return d.v(k, j); });
  return sums.dot > 0.5 * sums.square;
}

}  // namespace

std::vector<int> Hypothesis::joints() const {
  if (!axes.empty()) return axes;
  std::vector<int> named;
  for (const int j : {joint, other})
    if (j >= 0) named.push_back(j);
  return named;
}

Sight Hypothesis::undone(Sight s) const {
  if (coupled) {
    if (moves)
      for (RowMatrix* x : {&s.q, &s.v, &s.a})
        *x = at_joints ? coupled->to_motors(*x) : coupled->to_joints(*x);
    if (forces)
      s.tau = at_joints ? coupled->torque_to_motors(s.tau) : coupled->torque_to_joints(s.tau);
  } else if (reversed) {
    for (int j = 0, n = static_cast<int>(s.q.cols()); j < n - 1 - j; ++j) swap(j, n - 1 - j, s);
  } else if (other >= 0) {
    swap(joint, other, s);
  } else {
    for (const int j : joints()) {
      if (moves)
        for (RowMatrix* x : {&s.q, &s.v, &s.a}) x->col(j) *= factor;
      if (forces) s.tau.col(j) *= factor;
    }
  }
  return s;
}

void Hypothesis::swap(int one, int two, Sight& s) const {
  if (moves) {
    for (RowMatrix* x : {&s.q, &s.v, &s.a}) x->col(one).swap(x->col(two));
    std::swap(s.rows[static_cast<std::size_t>(one)], s.rows[static_cast<std::size_t>(two)]);
  }
  if (forces) s.tau.col(one).swap(s.tau.col(two));
}

Finding describe(const data::Dataset& d, const Motion& motion, const Hypothesis& h, double size,
                 const std::string& unit) {
  std::string signal = h.moves ? "q" : "";
  if (h.moves && d.v.size() > 0 && (h.joint < 0 || velocity_follows(d, motion, h.joint)))
    signal += " v";
  if (h.forces) signal += h.moves ? " tau" : "tau";
  return {.kind = h.kind,
          .signal = signal,
          .joint = h.joint,
          .other = h.other,
          .begin_s = d.t[0],
          .end_s = d.t[d.length() - 1],
          .size = size,
          .unit = unit};
}

}  // namespace fricid::doctor
