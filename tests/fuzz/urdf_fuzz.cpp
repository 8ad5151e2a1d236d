// libFuzzer target: a URDF as the engine reads it, and the dynamics of the robot that it describes.
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace fricid;
  fuzz::reads({"robot.urdf"}, [&] {
    const dynamics::RobotModel robot = dynamics::parse_urdf(
        std::string(fuzz::text_of(data, size)), "robot.urdf", Eigen::Matrix3d::Identity());
    dynamics::require_inertia(robot, "robot.urdf");
    const auto n = static_cast<std::size_t>(robot.n());
    dynamics::Workspace<double> ws(robot);
    const std::vector<double> pi(robot.pi.data(), robot.pi.data() + robot.pi.size()), q(n, 0.1),
        v(n, 0.2), tau(n, 1.0);
    std::vector<double> a(n);
    dynamics::forward_dynamics<double>(robot, ws, pi, q, v, tau, a);
    for (const dynamics::Frame& frame : robot.frames) dynamics::frame_pose(robot, frame, q);
  });
  return 0;
}
