// The engine's rigid-body dynamics against MuJoCo's, an independent implementation: the KR6 from
// its MJCF, the test robots from the same URDF that the engine reads.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "source_dir.hpp"

namespace fricid::sim::test {
namespace {

using dynamics::RobotModel;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, -1, -1, Eigen::RowMajor>;

constexpr double kTolerance = 1e-10;  // relative to the largest entry
constexpr int kStates = 200;

const std::filesystem::path kModels = source_dir() / "models";

/// A MuJoCo model and what it says about a state, in the engine's order of joints.
class Oracle {
 public:
  Oracle(const std::filesystem::path& path, const RobotModel& robot) {
    char error[500] = "";
    m_.reset(mj_loadXML(path.c_str(), nullptr, error, sizeof error));
    if (!m_) throw std::runtime_error(error);
    d_.reset(mj_makeData(m_.get()));
    if (m_->nv != robot.n()) throw std::runtime_error(path.string() + ": other number of joints");
    for (int i = 0; i < robot.n(); ++i) {
      const int joint =
          mj_name2id(m_.get(), mjOBJ_JOINT, robot.joints[static_cast<size_t>(i)].name.c_str());
      if (joint < 0) throw std::runtime_error(path.string() + ": joint missing");
      dof_.push_back(m_->jnt_dofadr[joint]);
      m_->dof_armature[dof_.back()] = robot.pi(robot.armature_begin() + i);
      m_->dof_damping[dof_.back()] = m_->dof_frictionloss[dof_.back()] = 0;
    }
    m_->opt.disableflags |= mjDSBL_CONTACT | mjDSBL_LIMIT;
  }

  void set(const VectorXd& q, const VectorXd& v, const VectorXd& a) {
    for (int i = 0; i < q.size(); ++i) {
      const int dof = dof_[static_cast<size_t>(i)];
      d_->qpos[dof] = q(i);
      d_->qvel[dof] = v(i);
      d_->qacc[dof] = a(i);
    }
    mj_inverse(m_.get(), d_.get());
  }
  VectorXd inverse() const { return pick(d_->qfrc_inverse); }
  VectorXd bias() const { return pick(d_->qfrc_bias); }
  VectorXd rne() {
    VectorXd result(m_->nv);
    mj_rne(m_.get(), d_.get(), 0, result.data());
    return pick(result.data());
  }
  MatrixXd mass() const {
    MatrixXd M(m_->nv, m_->nv);
    for (int i = 0; i < m_->nv; ++i) {
      const VectorXd unit = VectorXd::Unit(m_->nv, i);
      mj_mulM(m_.get(), d_.get(), M.col(i).data(), unit.data());
    }
    return M(dof_, dof_);
  }
  VectorXd forward(const VectorXd& tau) {
    for (int i = 0; i < tau.size(); ++i) d_->qfrc_applied[dof_[static_cast<size_t>(i)]] = tau(i);
    mj_forward(m_.get(), d_.get());
    return pick(d_->qacc);
  }
  dynamics::Pose site(const char* name) const {
    const int id = mj_name2id(m_.get(), mjOBJ_SITE, name);
    if (id < 0) throw std::runtime_error("no such site");
    return {Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d_->site_xmat + 9 * id),
            Eigen::Map<const Eigen::Vector3d>(d_->site_xpos + 3 * id)};
  }

 private:
  VectorXd pick(const double* values) const {
    VectorXd picked(m_->nv);
    for (int i = 0; i < m_->nv; ++i) picked(i) = values[dof_[static_cast<size_t>(i)]];
    return picked;
  }

  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> m_{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, decltype(&mj_deleteData)> d_{nullptr, mj_deleteData};
  std::vector<int> dof_;
};

std::span<const double> view(const VectorXd& x) {
  return {x.data(), static_cast<size_t>(x.size())};
}
std::span<double> view(VectorXd& x) { return {x.data(), static_cast<size_t>(x.size())}; }

void expect_close(const MatrixXd& x, const MatrixXd& y, const char* what) {
  const double scale = std::max(1.0, y.cwiseAbs().maxCoeff());
  EXPECT_LE((x - y).cwiseAbs().maxCoeff(), kTolerance * scale) << what;
}

void compare(const RobotModel& robot, Oracle& oracle) {
  const int n = robot.n();
  dynamics::Workspace<double> ws(robot);
  Rng rng(11, 0);
  VectorXd q(n), v(n), a(n), tau(n), h(n);
  const VectorXd zero = VectorXd::Zero(n);
  RowMajor M(n, n);
  for (int k = 0; k < kStates && !::testing::Test::HasFailure(); ++k) {
    SCOPED_TRACE(testing::Message() << robot.name << ", state " << k);
    for (int i = 0; i < n; ++i) {
      q(i) = 1.5 * rng.normal();
      v(i) = k % 10 == 0 ? 0.0 : 2 * rng.normal();
      a(i) = 5 * rng.normal();
    }
    oracle.set(q, v, a);
    dynamics::crba<double>(robot, ws, view(robot.pi), view(q),
                           {M.data(), static_cast<size_t>(M.size())});
    expect_close(M, oracle.mass(), "mass matrix");
    dynamics::rnea<double>(robot, ws, view(robot.pi), view(q), view(v), view(zero), view(h));
    expect_close(h, oracle.bias(), "bias");
    expect_close(h, oracle.rne(), "mj_rne");
    dynamics::rnea<double>(robot, ws, view(robot.pi), view(q), view(v), view(a), view(tau));
    expect_close(tau, oracle.inverse(), "inverse dynamics");
    dynamics::forward_dynamics<double>(robot, ws, view(robot.pi), view(q), view(v), view(tau),
                                       view(a));
    expect_close(a, oracle.forward(tau), "forward dynamics");
  }
}

TEST(DynamicsVsMujoco, TestRobotsFromTheSameUrdf) {
  for (const char* name : {"pendulum", "planar_2r", "scara", "branched", "arm_7r"}) {
    const auto path = kModels / "test" / (std::string(name) + ".urdf");
    const RobotModel robot = dynamics::load_urdf(path);
    Oracle oracle(path, robot);
    compare(robot, oracle);
  }
}

TEST(DynamicsVsMujoco, Kr6FromUrdfAndMjcf) {
  const Eigen::Matrix3d on_floor = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d on_ceiling = Eigen::Vector3d(1, -1, -1).asDiagonal();
  for (const auto& [file, mount] :
       {std::pair("kr6_floor.xml", on_floor), std::pair("kr6_ceiling.xml", on_ceiling)}) {
    SCOPED_TRACE(file);
    const RobotModel robot = dynamics::load_urdf(kModels / "kr6_r700" / "kr6_r700.urdf", mount);
    Oracle oracle(kModels / "kr6_r700" / file, robot);
    compare(robot, oracle);
  }
}

TEST(DynamicsVsMujoco, Kr6FlangeAndToolPose) {
  const RobotModel robot = dynamics::load_urdf(kModels / "kr6_r700" / "kr6_r700.urdf");
  Oracle oracle(kModels / "kr6_r700" / "kr6_r700.xml", robot);
  Rng rng(12, 0);
  const VectorXd zero = VectorXd::Zero(robot.n());
  VectorXd q(robot.n());
  for (int k = 0; k < kStates; ++k) {
    for (double& x : q) x = 1.5 * rng.normal();
    oracle.set(q, zero, zero);
    for (const char* frame : {"flange", "tool0"}) {
      const dynamics::Pose ours = frame_pose(robot, frame, view(q)), theirs = oracle.site(frame);
      EXPECT_LT((ours.p - theirs.p).norm(), 1e-12) << frame;
      EXPECT_LT((ours.R - theirs.R).norm(), 1e-12) << frame;
    }
  }
}

}  // namespace
}  // namespace fricid::sim::test
