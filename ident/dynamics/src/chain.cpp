#include "chain.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace fricid::dynamics::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kParallel = 1e-9;  // below this sine, two axes count as parallel
constexpr double kExact = 1e-14;  // a quarter turn may be off by rounding, not by a truncated pi/2

Vector3d any_normal(const Vector3d& z) {
  Eigen::Index smallest;
  z.cwiseAbs().minCoeff(&smallest);
  return z.cross(Vector3d::Unit(smallest)).normalized();
}

Matrix3d frame_with(const Vector3d& x, const Vector3d& z) {
  Matrix3d X;
  X << x, z.cross(x), z;
  return X;
}

/// Components that only rounding keeps from zero become zero.
Vector3d without_rounding(const Vector3d& p) {
  const double smallest = kExact * p.norm();
  return p.unaryExpr([smallest](double x) { return std::abs(x) < smallest ? 0.0 : x; });
}

Mat3<double> to_mat3(const Matrix3d& R) {
  return {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)};
}

/// Turns about x by 0, 90, -90 and 180 degrees.
Matrix3d quarter_turn(Turn kind) {
  const double c = kind == Turn::kNone ? 1 : kind == Turn::kHalf ? -1 : 0;
  const double s = kind == Turn::kPlus90 ? 1 : kind == Turn::kMinus90 ? -1 : 0;
  return (Matrix3d() << 1, 0, 0, 0, c, -s, 0, s, c).finished();
}

/// Q as a signed permutation, when it is one: where each entry of the internal h and I is in pi.
void find_swaps(const Matrix3d& Q, Link<double>& link) {
  constexpr int kSecond[3][3] = {{4, 5, 7}, {5, 6, 8}, {7, 8, 9}};  // I in pi
  constexpr int kPairs[6][2] = {{0, 0}, {0, 1}, {1, 1}, {0, 2}, {1, 2}, {2, 2}};
  int source[3];
  double sign[3];
  link.swaps = true;
  for (int k = 0; k < 3; ++k) {
    Q.col(k).cwiseAbs().maxCoeff(&source[k]);
    sign[k] = Q(source[k], k) > 0 ? 1 : -1;
    if ((Q.col(k) - sign[k] * Vector3d::Unit(source[k])).norm() > kExact) link.swaps = false;
  }
  for (size_t k = 0; k < 3; ++k) {
    link.first[k] = 1 + source[k];
    link.first_zero[k] = 0 * sign[k];
  }
  for (size_t k = 0; k < 6; ++k) {
    const auto [i, j] = kPairs[k];
    link.second[k] = kSecond[source[i]][source[j]];
    link.second_zero[k] = 0 * sign[i] * sign[j];
  }
}

}  // namespace

std::vector<Link<double>> make_links(const RobotModel& model) {
  const int n = model.n();

  // axes and frames at q = 0, in the base frame
  std::vector<Matrix3d> R(static_cast<size_t>(n));
  std::vector<Vector3d> z(static_cast<size_t>(n));
  for (size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    R[i] = joint.parent < 0 ? joint.R0 : R[static_cast<size_t>(joint.parent)] * joint.R0;
    z[i] = R[i] * joint.axis;
  }

  // x normal to the own axis and that of the first child
  std::vector<Matrix3d> X(static_cast<size_t>(n));
  for (int i = 0; i < n; ++i) {
    const auto I = static_cast<size_t>(i);
    const int parent = model.joints[I].parent;
    int child = -1;
    for (int k = n - 1; k > i; --k)
      if (model.joints[static_cast<size_t>(k)].parent == i) child = k;
    Vector3d x = Vector3d::Zero();
    if (child >= 0) x = z[I].cross(z[static_cast<size_t>(child)]);
    if (x.norm() < kParallel && parent >= 0) {
      const Vector3d x_parent = X[static_cast<size_t>(parent)].col(0);
      x = x_parent - x_parent.dot(z[I]) * z[I];
    }
    X[I] = frame_with(x.norm() < kParallel ? any_normal(z[I]) : x.normalized(), z[I]);
  }

  std::vector<Link<double>> links(static_cast<size_t>(n));
  for (size_t i = 0; i < links.size(); ++i) {
    const Joint& joint = model.joints[i];
    Link<double>& link = links[i];
    link.revolute = joint.type == JointType::kRevolute;
    link.parent = joint.parent;
    const Matrix3d Q = R[i].transpose() * X[i];
    link.Q = to_mat3(Q);
    find_swaps(Q, link);

    const bool on_base = joint.parent < 0;
    const auto parent = static_cast<size_t>(joint.parent);
    const Matrix3d Q_parent =
        on_base ? Matrix3d(Matrix3d::Identity()) : Matrix3d(R[parent].transpose() * X[parent]);
    const Matrix3d placement = Q_parent.transpose() * joint.R0 * Q;
    const Vector3d p0 = without_rounding(Q_parent.transpose() * joint.p0);
    link.p0 = {p0.x(), p0.y(), p0.z()};
    const bool has_x = p0.x() != 0, has_y = p0.y() != 0, has_z = p0.z() != 0;
    if (link.revolute && !has_y && !has_z) link.shift = Shift::kX;
    if (link.revolute && !has_z && !has_x) link.shift = Shift::kY;
    if (link.revolute && !has_x && !has_y) link.shift = Shift::kZ;
    link.turn = Turn::kGeneral;
    link.general = to_mat3(placement);
    if (on_base) continue;
    for (const Turn kind : {Turn::kNone, Turn::kPlus90, Turn::kMinus90, Turn::kHalf}) {
      const Matrix3d spin = quarter_turn(kind).transpose() * placement;
      if ((spin.col(2) - Vector3d::UnitZ()).norm() > kExact) continue;
      link.turn = kind;
      link.general = to_mat3(quarter_turn(kind));
      link.offset = std::atan2(spin(1, 0), spin(0, 0));
      break;
    }
  }
  return links;
}

}  // namespace fricid::dynamics::detail
