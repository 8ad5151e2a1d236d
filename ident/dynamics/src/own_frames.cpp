// Kinematics, energies and the regressor in the frames of the links, in double. An implementation
// independent of the templates, so that tests can compare the two.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>

#include "fricid/base/error.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "motors.hpp"

namespace fricid::dynamics {

namespace detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix36 = Eigen::Matrix<double, 3, 6>;
using Matrix610 = Eigen::Matrix<double, 6, 10>;

Matrix3d skew(const Vector3d& a) {
  return (Matrix3d() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
}

/// L(w) (Ixx, Ixy, Iyy, Ixz, Iyz, Izz)' = I w.
Matrix36 inertia_times(const Vector3d& w) {
  return (Matrix36() << w.x(), w.y(), 0, w.z(), 0, 0,  //
          0, w.x(), w.y(), 0, w.z(), 0,                //
          0, 0, 0, w.x(), w.y(), w.z())
      .finished();
}

Matrix3d inertia_matrix(const double* pi) {
  return (Matrix3d() << pi[4], pi[5], pi[7], pi[5], pi[6], pi[8], pi[7], pi[8], pi[9]).finished();
}

Matrix3d joint_rotation(const Joint& joint, double q) {
  if (joint.type != JointType::kRevolute) return joint.R0;
  return joint.R0 * Eigen::AngleAxisd(q, joint.axis).toRotationMatrix();
}

Vector3d joint_origin(const Joint& joint, double q) {
  if (!slides(joint)) return joint.p0;
  return joint.p0 + joint.R0 * joint.axis * q;
}

}  // namespace

struct OwnFrameKernels {
  /// Motion of every link; a_base is the acceleration of the base less gravity.
  static std::vector<OwnFrame>& sweep(const RobotModel& model, Workspace<double>& ws,
                                      std::span<const double> q, std::span<const double> v,
                                      std::span<const double> a, const Vector3d& a_base) {
    OwnFrame base{Matrix3d::Identity(), Vector3d::Zero(), Vector3d::Zero(),
                  Vector3d::Zero(),     Vector3d::Zero(), a_base};
    for (size_t i = 0; i < model.joints.size(); ++i) {
      const Joint& joint = model.joints[i];
      const OwnFrame& parent =
          joint.parent < 0 ? base : ws.own_frames_[static_cast<size_t>(joint.parent)];
      OwnFrame& own = ws.own_frames_[i];
      own.R = joint_rotation(joint, q[i]);
      own.p = joint_origin(joint, q[i]);
      const Matrix3d Rt = own.R.transpose();
      own.w = Rt * parent.w;
      own.alpha = Rt * parent.alpha;
      own.v = Rt * (parent.v + parent.w.cross(own.p));
      own.a = Rt * (parent.a + parent.alpha.cross(own.p) + parent.w.cross(parent.w.cross(own.p)));
      const Vector3d rate = joint.axis * v[i];
      const double acceleration = a.empty() ? 0.0 : a[i];
      if (joint.type == JointType::kRevolute) {
        own.alpha += own.w.cross(rate) + joint.axis * acceleration;
        own.w += rate;
      } else {
        own.a += 2 * own.w.cross(rate) + joint.axis * acceleration;
        own.v += rate;
      }
    }
    return ws.own_frames_;
  }

  static std::span<const double> joints_of(Workspace<double>& ws, std::span<const double> m,
                                           std::vector<double>& room) {
    return Motors<double>::joints_of(ws, m, room);
  }

  static void regressor(const RobotModel& model, Workspace<double>& ws,
                        std::span<const double> motors, std::span<const double> v,
                        std::span<const double> a, Eigen::Ref<Eigen::MatrixXd> Y) {
    const std::span<const double> q = joints_of(ws, motors, ws.q_);
    const auto& frames =
        sweep(model, ws, q, joints_of(ws, v, ws.v_), joints_of(ws, a, ws.a_), -model.gravity);
    Y.setZero();
    for (int k = 0; k < model.n(); ++k) {
      // force and moment of link k about its origin, by parameter
      const OwnFrame& link = frames[static_cast<size_t>(k)];
      Matrix610 A = Matrix610::Zero();
      A.block<3, 1>(0, 0) = link.a;
      A.block<3, 3>(0, 1) = skew(link.alpha) + skew(link.w) * skew(link.w);
      A.block<3, 3>(3, 1) = -skew(link.a);
      A.block<3, 6>(3, 4) = inertia_times(link.alpha) + skew(link.w) * inertia_times(link.w);

      // seen by every joint from k down to the base
      for (int i = k; i >= 0;) {
        const Joint& joint = model.joints[static_cast<size_t>(i)];
        const int row = joint.type == JointType::kRevolute ? 3 : 0;
        Y.block<1, 10>(i, 10 * k) = joint.axis.transpose() * A.block<3, 10>(row, 0);
        const OwnFrame& own = frames[static_cast<size_t>(i)];
        const Eigen::Matrix<double, 3, 10> force = own.R * A.topRows<3>();
        const Eigen::Matrix<double, 3, 10> moment = own.R * A.bottomRows<3>() + skew(own.p) * force;
        A << force, moment;
        i = joint.parent;
      }
    }
    for (size_t k = 0; k < model.linear_torques.size(); ++k) {
      const LinearTorque& torque = model.linear_torques[k];
      Y(torque.joint, model.linear_begin() + static_cast<int>(k)) =
          shape_of(torque, q[static_cast<size_t>(torque.joint)]);
    }
    for (Eigen::Index c = 0; c < Y.cols(); ++c)
      Motors<double>::to_motors(ws, {Y.col(c).data(), static_cast<size_t>(model.n())});
    for (int i = 0; i < model.n(); ++i)
      Y(i, model.armature_begin() + i) = a[static_cast<size_t>(i)];
  }

  static double kinetic_energy(const RobotModel& model, Workspace<double>& ws,
                               std::span<const double> pi, std::span<const double> q,
                               std::span<const double> v) {
    const auto& frames =
        sweep(model, ws, joints_of(ws, q, ws.q_), joints_of(ws, v, ws.v_), {}, Vector3d::Zero());
    double energy = 0;
    for (size_t i = 0; i < frames.size(); ++i) {
      const OwnFrame& link = frames[i];
      const double* p = &pi[10 * i];
      const Vector3d h(p[1], p[2], p[3]);
      energy += 0.5 * p[0] * link.v.squaredNorm() + link.v.dot(link.w.cross(h)) +
                0.5 * link.w.dot(inertia_matrix(p) * link.w) +
                0.5 * pi[10 * frames.size() + i] * v[i] * v[i];
    }
    return energy;
  }

  static double potential_energy(const RobotModel& model, Workspace<double>& ws,
                                 std::span<const double> pi, std::span<const double> motors) {
    const std::span<const double> q = joints_of(ws, motors, ws.q_);
    double energy = 0;
    for (int i = 0; i < model.n(); ++i) {
      const Pose pose = frame_pose(model, Frame{.name = "", .link = i}, q);
      const double* p = &pi[static_cast<size_t>(10 * i)];
      const Vector3d h(p[1], p[2], p[3]);
      energy -= model.gravity.dot(p[0] * pose.p + pose.R * h);
    }
    return energy;
  }
};

}  // namespace detail

void regressor(const RobotModel& model, Workspace<double>& ws, std::span<const double> q,
               std::span<const double> v, std::span<const double> a,
               Eigen::Ref<Eigen::MatrixXd> Y) {
  detail::OwnFrameKernels::regressor(model, ws, q, v, a, Y);
}

double kinetic_energy(const RobotModel& model, Workspace<double>& ws, std::span<const double> pi,
                      std::span<const double> q, std::span<const double> v) {
  return detail::OwnFrameKernels::kinetic_energy(model, ws, pi, q, v);
}

double potential_energy(const RobotModel& model, Workspace<double>& ws, std::span<const double> pi,
                        std::span<const double> motors) {
  return detail::OwnFrameKernels::potential_energy(model, ws, pi, motors);
}

Pose frame_pose(const RobotModel& model, const Frame& frame, std::span<const double> q) {
  Pose pose{frame.R, frame.p};
  for (int i = frame.link; i >= 0;) {
    const auto k = static_cast<size_t>(i);
    const Joint& joint = model.joints[k];
    const Eigen::Matrix3d R = detail::joint_rotation(joint, q[k]);
    pose.p = R * pose.p + detail::joint_origin(joint, q[k]);
    pose.R = R * pose.R;
    i = joint.parent;
  }
  return pose;
}

Pose frame_pose(const RobotModel& model, std::string_view frame, std::span<const double> q) {
  std::vector<std::string_view> known;
  for (const Frame& candidate : model.frames) {
    if (candidate.name == frame) return frame_pose(model, candidate, q);
    known.push_back(candidate.name);
  }
  throw UserError("{}: unknown frame \"{}\"; known frames: {}", model.name, frame,
                  fmt::join(known, ", "));
}

}  // namespace fricid::dynamics
