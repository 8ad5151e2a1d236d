#include "robot_parts.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "fricid/base/error.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/dynamics/nominal.hpp"

namespace fricid::scene {
namespace {

using dynamics::LinearTorque;

// 1, q, sin(q), cos(2 q), sin(31.4*q)
std::optional<LinearTorque> parse_term(std::string term) {
  std::erase_if(term, [](char c) { return c == ' ' || c == '*'; });
  LinearTorque torque;
  if (term == "1") return torque;
  if (term == "q") {
    torque.shape = LinearTorque::Shape::kLinear;
    return torque;
  }
  const bool sine = term.starts_with("sin("), cosine = term.starts_with("cos(");
  if ((!sine && !cosine) || !term.ends_with("q)")) return std::nullopt;
  torque.shape = sine ? LinearTorque::Shape::kSin : LinearTorque::Shape::kCos;
  const std::string_view factor = std::string_view(term).substr(4, term.size() - 6);
  if (factor.empty()) return torque;
  const auto [end, error] = std::from_chars(factor.data(), factor.data() + factor.size(), torque.k);
  if (error != std::errc() || end != factor.data() + factor.size() || !std::isfinite(torque.k) ||
      torque.k <= 0)
    return std::nullopt;
  return torque;
}

}  // namespace

std::vector<double> add_torques(const Scene& scene, dynamics::RobotModel& robot) {
  std::vector<double> prior_sd;
  const std::vector<std::string>& joints = scene.joints;
  for (std::size_t i = 0; i < scene.robot.torques.size(); ++i) {
    const LinearTorqueSection& config = scene.robot.torques[i];
    const std::string key = fmt::format("robot.torque[{}]", i);
    const std::string shown = fmt::format("robot.torque[{}]", i + 1);
    const auto joint = std::find(joints.begin(), joints.end(), config.joint);
    if (joint == joints.end())
      throw UserError("{}: {}.joint = \"{}\"; allowed: {}", scene.origin.place(key + ".joint"),
                      shown, config.joint, fmt::join(joints, ", "));
    if (!config.prior_sd.empty() && config.prior_sd.size() != config.terms.size())
      throw UserError("{}: {}.prior_sd = an array of {}; allowed: [] or {} numbers, one per term",
                      scene.origin.place(key + ".prior_sd"), shown, config.prior_sd.size(),
                      config.terms.size());
    for (std::size_t k = 0; k < config.terms.size(); ++k) {
      std::optional<LinearTorque> torque = parse_term(config.terms[k]);
      if (!torque)
        throw UserError(
            "{}: {}.terms[{}] = \"{}\"; allowed: 1, q, sin(q), cos(q), sin(2 q), "
            "sin(31.4 q), ...",
            scene.origin.place(key + ".terms"), shown, k + 1, config.terms[k]);
      torque->joint = static_cast<int>(joint - joints.begin());
      torque->name = fmt::format("{} {}", config.joint, config.terms[k]);
      dynamics::add_linear_torque(robot, *torque);
      prior_sd.push_back(config.prior_sd.empty() ? std::numeric_limits<double>::infinity()
                                                 : config.prior_sd[k]);
    }
  }
  return prior_sd;
}

void take_couplings(Scene& scene, const std::filesystem::path& contract_path) {
  if (contract_path.empty()) return;
  const auto of_contract = data::load_contract(contract_path).couplings;
  if (of_contract.empty()) return;
  std::vector<dynamics::NamedCoupling>& own = scene.robot.couplings;
  if (own.empty()) own = of_contract;
  if (!std::ranges::is_permutation(own, of_contract))
    throw UserError(
        "{}: robot.coupling differs from [[coupling]] of {}; allowed: the same, or none",
        scene.origin.place("robot.coupling"), contract_path.string());
}

void add_couplings(const Scene& scene, dynamics::RobotModel& robot) {
  robot.couplings =
      dynamics::couplings_of(scene.robot.couplings, scene.joints, "robot.coupling",
                             [&](std::string_view key) { return scene.origin.place(key); });
}

namespace {

/// A load as two sections of a scene name it.
struct Load {
  std::string_view keys;  ///< that its keys begin with
  const std::string& frame;
  double mass;
  const std::array<double, 3>& com;
  const std::array<double, 6>& inertia;
};

void add_load(const Scene& scene, const Load& load, dynamics::RobotModel& model) {
  const auto frame = std::ranges::find(model.frames, load.frame, &dynamics::Frame::name);
  if (frame == model.frames.end()) {
    std::vector<std::string> names;
    for (const dynamics::Frame& f : model.frames) names.push_back(f.name);
    const std::string key = fmt::format("{}frame", load.keys);
    throw UserError("{}: {} = \"{}\"; allowed: {}", scene.origin.place(key), key, load.frame,
                    fmt::join(names, ", "));
  }
  const auto& [xx, yy, zz, xy, xz, yz] = load.inertia;
  const Eigen::Matrix3d inertia{{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
  // The sum with the link must stay a body: about its own centre Ixx + Iyy >= Izz, and so on.
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  if (moments[0] < 0 || moments[0] + moments[1] < moments[2]) {
    const std::string key = fmt::format("{}inertia", load.keys);
    throw UserError(
        "{}: {} has principal moments {:g}, {:g}, {:g} kg m^2; allowed: none negative, the largest "
        "at most the sum of the others",
        scene.origin.place(key), key, moments[0], moments[1], moments[2]);
  }
  dynamics::add_payload(model, *frame, load.mass,
                        Eigen::Map<const Eigen::Vector3d>(load.com.data()), inertia);
}

}  // namespace

void add_armatures(const Scene& scene, dynamics::RobotModel& robot) {
  const std::string place = scene.origin.place("robot.armature"),
                    guess = scene.origin.place("robot.guess_armature");
  const bool states = !scene.robot.armature.empty(), guesses = scene.robot.guess_armature;
  if (!scene.robot.mjcf.empty() && (states || guesses))
    throw UserError(
        "{}: robot.{} beside robot.mjcf; allowed: one of them, without mjcf the simulator's arm is "
        "made of the URDF",
        states ? place : guess, states ? "armature" : "guess_armature");
  if (guesses && !scene.simulates())
    throw UserError(
        "{}: robot.guess_armature beside logs; allowed: with [friction]; a fit to logs guesses "
        "armatures that are not stated",
        guess);
  auto armature = robot.pi.segment(robot.armature_begin(), robot.n());
  const Eigen::VectorXd usual = dynamics::usual_armature(robot);
  for (const auto& [name, value] : scene.robot.armature) {
    const auto joint = std::ranges::find(scene.joints, name);
    if (joint == scene.joints.end())
      throw UserError("{}: robot.armature: no joint {}; allowed: {}", place, name,
                      fmt::join(scene.joints, ", "));
    armature[joint - scene.joints.begin()] = value;
  }
  if (guesses) armature = (armature.array() == 0).select(usual, armature);
}

void add_payload(const Scene& scene, dynamics::RobotModel& model) {
  const RobotSection& robot = scene.robot;
  if (robot.payload_kg > 0)
    add_load(scene,
             {"robot.payload_", robot.payload_frame, robot.payload_kg, robot.payload_com,
              robot.payload_inertia},
             model);
}

void add_unknown_load(const Scene& scene, dynamics::RobotModel& model) {
  const PayloadSection& load = scene.payload;
  add_load(scene, {"payload.", load.frame, load.mass_kg, load.com, load.inertia}, model);
}

}  // namespace fricid::scene
