// What exported friction costs: a step of MuJoCo with the plugin, a joint by the C header.
#include <benchmark/benchmark.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/files.hpp"
#include "fricid/deploy/c_header.hpp"
#include "fricid/deploy/export.hpp"
#include "fricid/friction/sum.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/plant.hpp"
#include "source_dir.hpp"
#include "temporary_folder.hpp"

namespace fricid {
namespace {

/// A law with 4 elements, if it has elements; "lvm": the sum of laws of that name, all its parts.
friction::JointSpec joint_with(std::string_view law) {
  if (law == friction::kLvm) return friction::lvm_sum({.temperature = true});
  const auto table = friction::law_table();
  const auto info = std::ranges::find(table, law, &friction::LawInfo::name);
  return {{{std::string(law), info->has_elements ? 4 : 0, {}}}};
}

/// The KR 6 with friction of typical parameters in every joint, or that of kr6_full.
data::ModelFile kr6_with(std::string_view law) {
  static const scene::Problem problem = scene::load_problem(source_dir() / "scenes/kr6_full.toml");
  data::ModelFile file;
  file.name = file.label = law;
  file.arm = {problem.robot, *problem.scene.friction};
  if (law == "kr6_full") return file;
  friction::RobotFriction model(
      std::vector<friction::JointSpec>(problem.robot.joints.size(), joint_with(law)));
  std::vector<double> theta = friction::default_theta(model);
  friction::initialise_weights(model, 1, theta);
  file.arm.friction = {std::move(model), std::move(theta)};
  return file;
}

// Items are physics steps.
void step_exported(benchmark::State& state, const char* format, const char* law) {
  sim::initialise_mujoco();
  [[maybe_unused]] static const bool loaded = (mj_loadPluginLibrary(FRICID_PLUGIN), true);
  const OwnFolder folder(std::filesystem::temp_directory_path());
  const deploy::Exported exported = deploy::export_model(kr6_with(law), format);
  deploy::save(exported, folder.path());
  const sim::MjModelPtr m(
      mj_loadXML((folder.path() / exported.files.back().name).c_str(), nullptr, nullptr, 0));
  m->opt.timestep = 5e-4;
  const sim::MjDataPtr data(mj_makeData(m.get()));
  constexpr double kHanging[]{0.2, -1.5, 0.3, 0.1, -0.4, 0.2};
  constexpr int kSteps = 1000;
  for (auto _ : state) {
    mj_resetData(m.get(), data.get());
    std::ranges::copy(kHanging, data->qpos);
    std::fill_n(data->qvel, m->nv, 0.5);
    for (int k = 0; k < kSteps; ++k) mj_step(m.get(), data.get());
    benchmark::DoNotOptimize(data->qpos);
  }
  state.SetItemsProcessed(state.iterations() * kSteps);
}
BENCHMARK_CAPTURE(step_exported, without_friction, "mjcf", "none");
BENCHMARK_CAPTURE(step_exported, kr6_full, "plugin", "kr6_full");
BENCHMARK_CAPTURE(step_exported, lugre, "plugin", "lugre");
BENCHMARK_CAPTURE(step_exported, gms, "plugin", "gms");
BENCHMARK_CAPTURE(step_exported, lvm, "plugin", "lvm");
BENCHMARK_CAPTURE(step_exported, lvm1, "plugin", "lvm1");
BENCHMARK_CAPTURE(step_exported, lvm_bristles, "plugin", "lvm_bristles");
BENCHMARK_CAPTURE(step_exported, lvm4, "plugin", "lvm4");

/// Torque and step of all joints along a motion by the header, compiled by the C compiler of this
/// machine as a controller would: -O2, for any processor.
class CompiledHeader {
 public:
  explicit CompiledHeader(const data::ModelFile& model) {
    const OwnFolder folder(std::filesystem::temp_directory_path());
    const std::string name = deploy::code_name(model);
    write_file_atomically(folder.path() / (name + "_friction.h"), deploy::c_header(model));
    write_file_atomically(
        folder.path() / "drive.c",
        fmt::format(
            "#include \"{0}_friction.h\"\n"
            "double drive(int steps, const double *x);\n"
            "double drive(int steps, const double *x) {{\n  {0}_state s;\n  double sum = 0;\n"
            "  int k, j;\n  {0}_init(&s);\n  for (k = 0; k < steps; ++k) {{\n"
            "    double q[{1}], v[{1}], load[{1}], temperature[{1}], tau[{1}];\n"
            "    for (j = 0; j < {1}; ++j, x += 4) {{\n      q[j] = x[0];\n      v[j] = x[1];\n"
            "      load[j] = x[2];\n      temperature[j] = x[3];\n    }}\n"
            "    {0}_torque(&s, q, v, load, temperature, tau);\n"
            "    {0}_step(&s, q, v, load, temperature, 1e-3);\n"
            "    for (j = 0; j < {1}; ++j) sum += tau[j];\n  }}\n  return sum;\n}}\n",
            name, model.arm.robot.n()));
    const std::string library = (folder.path() / "drive.so").string();
    if (std::system(fmt::format("cc -std=c99 -O2 -shared -fPIC \"{}\" -o \"{}\" -lm",
                                (folder.path() / "drive.c").string(), library)
                        .c_str()) != 0)
      throw std::runtime_error("the header does not compile");
    library_ = ::dlopen(library.c_str(), RTLD_NOW);
    drive = reinterpret_cast<double (*)(int, const double*)>(::dlsym(library_, "drive"));
  }
  ~CompiledHeader() { ::dlclose(library_); }
  CompiledHeader(const CompiledHeader&) = delete;
  CompiledHeader& operator=(const CompiledHeader&) = delete;

  /// @param motion  q, v, load and temperature of every joint, step by step
  double (*drive)(int steps, const double* motion);

 private:
  void* library_;
};

// Items are joints in a step, torque and step.
void header(benchmark::State& state, const char* law) {
  const data::ModelFile model = kr6_with(law);
  const int n = model.arm.robot.n();
  constexpr int kSteps = 1000;
  std::vector<double> motion;
  for (int k = 0; k < kSteps; ++k)
    for (int j = 0; j < n; ++j) {
      const double phase = 2 * M_PI * (static_cast<double>(k) / kSteps + 0.13 * j);
      motion.insert(motion.end(),
                    {0.3 * std::cos(phase), 0.5 * std::sin(phase), 30 * std::sin(2 * phase), 305});
    }
  const CompiledHeader compiled(model);
  for (auto _ : state) benchmark::DoNotOptimize(compiled.drive(kSteps, motion.data()));
  state.SetItemsProcessed(state.iterations() * kSteps * n);
}
BENCHMARK_CAPTURE(header, kr6_full, "kr6_full");
BENCHMARK_CAPTURE(header, lvm, "lvm");
BENCHMARK_CAPTURE(header, lvm_bristles, "lvm_bristles");
BENCHMARK_CAPTURE(header, lvm4, "lvm4");

}  // namespace
}  // namespace fricid
