// A robot as a const kinematic tree with parameters.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fricid::dynamics {

enum class JointType { kRevolute, kPrismatic };
constexpr std::string_view names(JointType) { return "revolute|prismatic"; }

/// Joint i moves link i. Frame i sits on the joint, moves with link i and equals, at q = 0, the
/// fixed placement (R0, p0) in the frame of the parent link (or of the base).
struct Joint {
  std::string name;
  std::string link;  ///< name of the moved link
  JointType type = JointType::kRevolute;
  bool continuous = false;  ///< revolute without position limits
  int parent = -1;  ///< index of the joint that moves the parent link; -1: base. < own index
  Eigen::Matrix3d R0 = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p0 = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit vector in frame i
  double lower = 0, upper = 0;                      ///< position limits [rad or m]
  double velocity = 0;                              ///< limit [rad/s or m/s]; 0: unknown
  double effort = 0;                                ///< limit [N m or N]; 0: unknown
  double acceleration = 0;                          ///< limit [rad/s^2]; 0: unknown
  double jerk = 0;                                  ///< limit [rad/s^3]; 0: unknown
};

/// Whether it slides: m, m/s, N, kg in the place of rad, rad/s, N m, kg m^2.
constexpr bool slides(const Joint& joint) { return joint.type == JointType::kPrismatic; }

/// Speeds and lengths that are 1 rad/s and 1 rad for a turning joint are this for a joint of the
/// same size that slides [m/s, m].
constexpr double travel_scale(const Joint& joint) { return slides(joint) ? 0.1 : 1; }

/// Positions that a joint takes [rad or m].
struct Travel {
  double lower, upper;
};
/// Its limits; half a turn or a metre either way where it has none, or such as nobody meant (more
/// than a hundred rad or m either way).
Travel travel_of(const Joint& joint);

/// A frame fixed to link `link` (-1: base) with pose (R, p) in the link's frame.
struct Frame {
  std::string name;
  int link = -1;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
};

/// A torque of known shape, linear in one parameter c:  tau_j += c phi(q_j).  For
/// counterbalances, springs and sensor offsets.
struct LinearTorque {
  enum class Shape { kConstant, kSin, kCos, kLinear };  ///< 1, sin(k q), cos(k q), q
  std::string name;                                     ///< for tables, e.g. "joint_a2 sin(2 q)"
  int joint = 0;
  Shape shape = Shape::kConstant;
  double k = 1;
};
/// phi(q).
double shape_of(const LinearTorque& torque, double q);
constexpr std::string_view names(LinearTorque::Shape) { return "1|sin(k q)|cos(k q)|q"; }

/// A motor that turns a further joint too, as in a wrist, a differential or a belt drive:
///     q_joint = m_joint + factor m_motor,   m: motor angles in joint units, gears taken out.
struct Coupling {
  int joint = 0;
  int motor = 0;
  double factor = 0;
};

/// Rigid-body model of an arm. Inverse dynamics is linear in the standard parameters
///
///     pi = [ (m, m cx, m cy, m cz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz) of link 0 .. n-1,
///            armature Ia of joint 0 .. n-1,  c of linear torque 0 .. n_c-1 ]   (11 n + n_c)
///
/// link inertia expressed in and taken about frame i. Units kg, kg m, kg m^2, N m.
///
/// Armature and friction act at the motors. On most arms each motor turns one joint; else
///
///     q = A m,   tau_m = A' tau_q,   A = 1 + couplings,
///
/// and `q, v, a, tau` of every dynamics algorithm are m, its derivatives and tau_m. Joint limits,
/// poses of frames and linear torques refer to the joints.
struct RobotModel {
  std::string name;
  std::vector<Joint> joints;
  std::vector<Frame> frames;
  std::vector<LinearTorque> linear_torques;
  std::vector<Coupling> couplings;
  Eigen::Vector3d gravity{0, 0, -9.81};  ///< in the base frame [m/s^2]
  Eigen::VectorXd pi;                    ///< nominal (CAD) parameters (parameter_count)
  /// Links of the file whose inertia no body has, and that have the nearest one; see `load_urdf`.
  std::vector<std::string> mended_links;

  int n() const { return static_cast<int>(joints.size()); }
  int parameter_count() const { return 11 * n() + static_cast<int>(linear_torques.size()); }
  int armature_begin() const { return 10 * n(); }
  int linear_begin() const { return 11 * n(); }
  bool coupled() const { return !couplings.empty(); }
  std::vector<std::string> joint_names() const;
  /// A and its inverse (n x n).
  Eigen::MatrixXd joints_of_motors() const;
  Eigen::MatrixXd motors_of_joints() const;
  /// "joint_a2 m cx" ... in the order of pi.
  std::vector<std::string> parameter_names() const;
};

/// Joints to be fixed at a position. Joints that <mimic> one of them are fixed with it.
struct Welds {
  std::map<std::string, double> at;  ///< position by joint [rad or m]; NaN: any
  std::string where = "fix";         ///< key that asks for them, for messages
};

/// Reads a URDF: a tree of revolute, continuous, prismatic and fixed joints. Links behind fixed or
/// welded joints are lumped into the link that carries them and kept as frames. The non-standard
/// child element <fricid armature= acceleration= jerk=/> of a joint is read when present.
/// @param mount  rotation that takes base vectors to world vectors; gravity = mount' (0, 0, -9.81)
/// @param mend_inertia  take the nearest inertia that a body can have where that of a link is none:
///                      of its second moments of mass, Sigma = tr(I)/2 1 - I, negative ones become
///                      a hundredth of the largest
/// @throws UserError naming file, link or joint: missing or non-positive mass, inertia that is not
///         physical, unsupported joint type, <mimic> of a joint that moves, no moving joint, file
///         missing, a weld of an unknown joint or beyond its limits
RobotModel load_urdf(const std::filesystem::path& path,
                     const Eigen::Matrix3d& mount = Eigen::Matrix3d::Identity(),
                     const Welds& welds = {}, bool mend_inertia = false);
RobotModel parse_urdf(const std::string& text, const std::string& source_name,
                      const Eigen::Matrix3d& mount = Eigen::Matrix3d::Identity(),
                      const Welds& welds = {}, bool mend_inertia = false);

/// Whether the motors turn every joint: A has an inverse.
bool is_transmission(const RobotModel& model);

/// Adds a linear torque with initial coefficient c and extends pi.
void add_linear_torque(RobotModel& model, LinearTorque torque, double c = 0);

/// Adds a rigid payload to a link: mass [kg], com [m] in the given frame, inertia about its com [kg
/// m^2].
void add_payload(RobotModel& model, const Frame& frame, double mass, const Eigen::Vector3d& com,
                 const Eigen::Matrix3d& inertia);

}  // namespace fricid::dynamics
