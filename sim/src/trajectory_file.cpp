#include <fmt/format.h>

#include "fricid/base/unit_of_joint.hpp"
#include "fricid/sim/excitation.hpp"

namespace fricid::sim {

std::string trajectory_toml(const Fourier& series, const dynamics::RobotModel& robot) {
  const auto list = [](const auto& x) {
    std::string text;
    for (Eigen::Index i = 0; i < x.size(); ++i) text += fmt::format("{}{}", i ? ", " : "", x[i]);
    return text;
  };
  std::string text =
      "# q(t) = q0 + sum_k a_k / (k w) sin(k w t) - b_k / (k w) cos(k w t),  k = 1, 2, ...\n"
      "# v(t) = sum_k a_k cos(k w t) + b_k sin(k w t);  period 2 pi / w; at rest at both ends\n";
  text += kTrajectoryFormat;
  text += fmt::format("w = {}  # rad/s\n", series.w);
  for (int j = 0; j < series.n(); ++j) {
    const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    text += fmt::format("\n[[joint]]\nname = \"{}\"\nq0 = {}  # {}\na = [{}]  # {}\nb = [{}]\n",
                        joint.name, series.q0[j], unit_of_joint("rad", slides(joint)),
                        list(series.a.row(j)), unit_of_joint("rad/s", slides(joint)),
                        list(series.b.row(j)));
  }
  return text;
}

std::string trajectory_csv(const Fourier& series, const dynamics::RobotModel& robot,
                           double rate_hz) {
  std::string text = "t";
  for (const char* kind : {"q_", "v_"})
    for (const dynamics::Joint& joint : robot.joints)
      text += fmt::format(",{}{}", kind, joint.name);
  text += '\n';
  const int count = static_cast<int>(series.period() * rate_hz) + 1;
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(count, 0, count - 1) / rate_hz;
  const Motion motion = TimeGrid(series.w, series.harmonics(), t).sample(series);
  for (Eigen::Index k = 0; k < count; ++k) {
    text += fmt::format("{:.6f}", t[k]);
    for (const Eigen::MatrixXd* x : {&motion.q, &motion.v})
      for (Eigen::Index j = 0; j < x->rows(); ++j) text += fmt::format(",{:.9f}", (*x)(j, k));
    text += '\n';
  }
  return text;
}

}  // namespace fricid::sim
