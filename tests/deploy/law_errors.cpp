#include "law_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "fricid/base/rng.hpp"
#include "fricid/deploy/c_header.hpp"

namespace fricid::deploy::test {
namespace {

constexpr int kJoints = 2, kSteps = 6000;
using Inputs = std::vector<friction::Input<double>>;

data::ModelFile model_of(std::string name, friction::RobotFriction friction, Rng& rng) {
  data::ModelFile model;
  model.name = std::move(name);
  model.label = model.name;
  for (int j = 0; j < kJoints; ++j) {
    dynamics::Joint joint;
    joint.name = fmt::format("joint \"{}\" */ ?\?/", j + 1);
    model.arm.robot.joints.push_back(joint);
  }
  std::vector<double> theta = friction::default_theta(friction);
  friction::initialise_weights(friction, 7, theta);
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const friction::ParameterInfo& info = friction.parameters()[i].info;
    const double draw = rng.normal();
    // weights further off make latents unstable, and these amplify rounding
    if (friction::is_weight(info.role))
      theta[i] += 0.1 * draw;
    else
      theta[i] *= std::exp(0.2 * std::clamp(draw, -2.0, 2.0));
    theta[i] = std::clamp(theta[i], info.lower, info.upper);
  }
  model.arm.friction = {std::move(friction), std::move(theta)};
  return model;
}

friction::RobotFriction joints_with(const friction::JointSpec& joint) {
  return friction::RobotFriction(std::vector<friction::JointSpec>(kJoints, joint));
}

bool is_finite(const friction::Input<double>& in) {
  return std::isfinite(in.q) && std::isfinite(in.v) && std::isfinite(in.load) &&
         std::isfinite(in.temperature);
}

// tau_f at each instant, before the step, sample by sample. Joints whose inputs are not finite keep
// torque and state; under a law of the whole robot all do.
std::vector<double> engine_torques(const data::ModelFile& model, const Inputs& motion, double dt) {
  const friction::Friction& friction = model.arm.friction;
  const auto n = static_cast<std::size_t>(friction.model.joint_count());
  std::vector<double> z(static_cast<std::size_t>(friction.model.state_size())), tau(n), all;
  for (std::size_t k = 0; k < motion.size() / n; ++k) {
    Inputs in(motion.begin() + static_cast<std::ptrdiff_t>(k * n),
              motion.begin() + static_cast<std::ptrdiff_t>(k * n + n));
    const bool held = friction.model.has_whole() && !std::ranges::all_of(in, is_finite);
    std::vector<double> tau_now(n), z_now = z;
    std::vector<std::size_t> known;
    for (std::size_t j = 0; j < n; ++j)
      if (is_finite(in[j]) && !held)
        known.push_back(j);
      else
        in[j] = {};
    friction.model.torque<double>(friction.theta, in, z, tau_now);
    friction.model.step<double>(friction.theta, in, dt, z_now);
    if (friction.model.has_whole() && !held) z = z_now;
    for (const std::size_t j : known) {
      tau[j] = tau_now[j];
      const auto begin = friction.model.state_begin(static_cast<int>(j)),
                 end = friction.model.state_begin(static_cast<int>(j) + 1);
      std::copy(z_now.begin() + begin, z_now.begin() + end, z.begin() + begin);
    }
    all.insert(all.end(), tau.begin(), tau.end());
  }
  return all;
}

std::string main_program(const std::vector<data::ModelFile>& models, int joints, int steps,
                         double dt) {
  std::string text = "#include <stdio.h>\n", runs;
  for (const data::ModelFile& model : models) {
    const std::string p = code_name(model);
    text += fmt::format("#include \"{}_friction.h\"\n", p);
    runs += fmt::format(
        "  {{\n    {0}_state s;\n    {0}_init(&s);\n    for (k = 0; k < {2}; ++k) {{\n"
        "      {0}_real q[{1}], v[{1}], load[{1}], temperature[{1}], tau[{1}];\n"
        "      for (j = 0; j < {1}; ++j) {{\n        const double *x = motion[k * {1} + j];\n"
        "        q[j] = ({0}_real)x[0];\n        v[j] = ({0}_real)x[1];\n"
        "        load[j] = ({0}_real)x[2];\n        temperature[j] = ({0}_real)x[3];\n      }}\n"
        "      {0}_torque(&s, q, v, load, temperature, tau);\n"
        "      for (j = 0; j < {1}; ++j) {{\n        const double y = (double)tau[j];\n"
        "        fwrite(&y, sizeof y, 1, out);\n      }}\n"
        "      {0}_step(&s, q, v, load, temperature, {0}_R({3}));\n    }}\n  }}\n",
        p, joints, steps, dt);
  }
  return text +
         fmt::format(
             "static double motion[{}][4];\nint main(int argc, char **argv) {{\n  int k, j;\n"
             "  FILE *in = argc > 2 ? fopen(argv[1], \"rb\") : NULL;\n"
             "  FILE *out = argc > 2 ? fopen(argv[2], \"wb\") : NULL;\n"
             "  if (!in || !out || fread(motion, sizeof motion, 1, in) != 1) return 1;\n{}"
             "  fclose(in);\n  return fclose(out);\n}}\n",
             joints * steps, runs);
}

void run(const std::string& command, const std::filesystem::path& log) {
  if (std::system((command + " > \"" + log.string() + "\" 2>&1").c_str()) == 0) return;
  std::stringstream said;
  said << std::ifstream(log).rdbuf();
  throw std::runtime_error(command + "\n" + said.str());
}

}  // namespace

Inputs motion() {
  Inputs motion;
  std::vector<double> q(kJoints, 0.1);
  for (int k = 0; k < kSteps; ++k)
    for (int j = 0; j < kJoints; ++j) {
      const double t = k * kDt, size = std::pow(10, -3 + 4.0 * k / kSteps);
      const bool rests = k % 1000 >= 900;
      const double v =
          rests ? 0
                : size * (std::sin(9 * t + j) + 0.7 * std::sin(31 * t) + 0.2 * std::cos(77 * t));
      q[static_cast<std::size_t>(j)] += kDt * v;
      motion.push_back(
          {q[static_cast<std::size_t>(j)], v, 20 * std::sin(5 * t + j), 293.15 + 20 * std::sin(t)});
    }
  return motion;
}

std::vector<double> torques_after_steps(const data::ModelFile& model, const Inputs& motion,
                                        double dt) {
  const friction::Friction& friction = model.arm.friction;
  const auto n = static_cast<std::size_t>(friction.model.joint_count());
  std::vector<double> z(static_cast<std::size_t>(friction.model.state_size())), tau(n), all;
  for (std::size_t k = 0; k < motion.size() / n; ++k) {
    const std::span in = std::span(motion).subspan(k * n, n);
    friction.model.step<double>(friction.theta, in, dt, z);
    friction.model.torque<double>(friction.theta, in, z, tau);
    all.insert(all.end(), tau.begin(), tau.end());
  }
  return all;
}

std::vector<data::ModelFile> all_models() {
  Rng rng(3, 1);
  std::vector<data::ModelFile> models;
  const auto elements = [](const friction::LawInfo& info) { return info.has_elements ? 4 : 0; };
  for (const friction::LawInfo& info : friction::law_table())
    models.push_back(model_of(std::string(info.name),
                              joints_with({{{std::string(info.name), elements(info), {}}}}), rng));
  for (const friction::LawInfo& info : friction::modifier_table())
    for (const char* law : {"coulomb_viscous", "lugre", "gms"}) {
      const int n = law == std::string("gms") ? 4 : 0;
      models.push_back(model_of(
          fmt::format("{}_on_{}", info.name, law),
          joints_with({{{law, n, {{std::string(info.name), info.has_elements ? 2 : 1}}}}}), rng));
    }
  models.push_back(model_of("sum",
                            joints_with({{{"gms", 3, {{"load", 1}, {"temperature", 1}}},
                                          {"lugre", 0, {{"backlash", 1}}},
                                          {"viscous_power", 0, {}}}}),
                            rng));
  for (const friction::LawInfo& info : friction::robot_law_table())
    models.push_back(
        model_of(std::string(info.name),
                 friction::RobotFriction(std::vector<friction::JointSpec>(kJoints),
                                         {std::string(info.name), info.has_elements ? 8 : 0}),
                 rng));
  return models;
}

std::vector<data::ModelFile> all_robots() {
  std::vector<data::ModelFile> models = all_models();
  for (data::ModelFile& model : models) {
    dynamics::RobotModel& robot = model.arm.robot;
    robot.name = "two flywheels";
    robot.gravity.setZero();
    robot.pi = Eigen::VectorXd::Zero(11 * robot.n());
    for (int j = 0; j < robot.n(); ++j) {
      dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
      joint.name = fmt::format("joint {}", j + 1);
      joint.link = fmt::format("link {}", j + 1);
      joint.continuous = true;
      joint.axis = Eigen::Vector3d::UnitZ();
      joint.parent = j - 1;
      robot.pi.segment<10>(10 * j) << 1, 0, 0, 0, 0.1, 0, 0.1, 0, 0, 0.1;
    }
  }
  return models;
}

data::ModelFile robot_with(const std::string& name) {
  for (const data::ModelFile& model : all_robots())
    if (model.name == name) return model;
  throw std::runtime_error("no model " + name);
}

std::vector<std::string> c_compilers() {
  std::vector<std::string> compilers;
  std::stringstream list(FRICID_C_COMPILERS);
  for (std::string compiler; std::getline(list, compiler, ',');) compilers.push_back(compiler);
  return compilers;
}

std::vector<double> header_errors(const std::vector<data::ModelFile>& models, const Inputs& motion,
                                  double dt, const std::string& compiler,
                                  const std::string& options, const std::filesystem::path& folder) {
  const int joints = models.front().arm.friction.model.joint_count();
  for (const data::ModelFile& model : models)
    write_binary(folder / (code_name(model) + "_friction.h"), c_header(model));
  write_binary(folder / "main.c",
               main_program(models, joints, static_cast<int>(motion.size()) / joints, dt));
  write_binary(folder / "motion", motion);
  run(fmt::format("\"{0}\" -std=c99 -O1 -Wall -Wextra -Wpedantic -Wconversion -Wvla -Werror {1} "
                  "\"{2}/main.c\" -o \"{2}/main\" -lm",
                  compiler, options, folder.string()),
      folder / "compiler.log");
  run(fmt::format("\"{0}/main\" \"{0}/motion\" \"{0}/tau\"", folder.string()), folder / "run.log");

  std::vector<double> said(models.size() * motion.size());
  std::ifstream file(folder / "tau", std::ios::binary);
  file.read(reinterpret_cast<char*>(said.data()),
            static_cast<std::streamsize>(said.size() * sizeof(double)));
  if (!file) throw std::runtime_error("torques are missing");
  std::vector<double> errors;
  for (std::size_t m = 0; m < models.size(); ++m) {
    const std::vector<double> truth = engine_torques(models[m], motion, dt);
    double largest = 0, worst = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double error = std::abs(said[m * truth.size() + i] - truth[i]);
      largest = std::max(largest, std::abs(truth[i]));
      worst =
          std::isfinite(error) ? std::max(worst, error) : std::numeric_limits<double>::infinity();
    }
    errors.push_back(largest > 0 ? worst / largest : worst);
  }
  return errors;
}

}  // namespace fricid::deploy::test
