// What a fitted model and its noise say of held-out logs: likelihood, and friction torque smoothed
// with its 90 % band, against the truth, with all positions and with a fifth of the rows missing.
//
//     fricid_smoothed_bands RUN_FOLDER MODEL_FILE ...
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "fricid/base/rng.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/estimate/em/e_step.hpp"
#include "fricid/estimate/em/em.hpp"
#include "fricid/estimate/wash_out.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/constant_friction.hpp"
#include "fricid/scene/problem.hpp"

namespace fricid {
namespace {

constexpr int kPaths = 39;
constexpr double kMissing = 0.2;  // share of the rows, at random
constexpr StepOptions kStep{8, 4};

/// Sums over recordings.
struct Sums {
  double log_likelihood = 0, nis = 0, samples = 0;
  double inside = 0, count = 0;         ///< samples and joints
  Eigen::ArrayXd error, truth, spread;  ///< squares per joint [N m ^2], spread: half widths
  double q_error = 0, missing = 0;      ///< squares of q where it is missing [rad^2]
};

/// Friction torque along smoothed paths, (T, n) each [N m].
std::vector<RowMatrix> friction_of(estimate::LatentFrictionModel& model,
                                   const estimate::Paths& paths,
                                   const Eigen::RowVectorXd& constant) {
  std::vector<RowMatrix> tau_f;
  for (const smc::RowMatrix& path : paths) {
    RowMatrix& torque = tau_f.emplace_back(path.rows(), constant.size());
    for (int t = 0; t < path.rows(); ++t)
      model.friction_torque<double>(
          t, {path.row(t).data(), static_cast<std::size_t>(path.cols())},
          {torque.row(t).data(), static_cast<std::size_t>(constant.size())});
    torque.rowwise() += constant;
  }
  return tau_f;
}

void add_recording(const data::ModelFile& file, const dynamics::RobotModel& known,
                   signals::Recording recording, const std::filesystem::path& truth, double missing,
                   std::uint64_t index, Sums& sums) {
  const auto n = static_cast<Eigen::Index>(file.arm.robot.n());
  const data::H5Reader reader(truth, "fricid.truth/1");
  const RowMatrix q = reader.matrix("/q"), tau_f = reader.matrix("/tau_f");
  Rng rng(1, index);
  std::vector<int> lost;
  for (int k = 1; k < recording.length(); ++k)
    if (rng.uniform() < missing) {
      lost.push_back(k);
      recording.log.q.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  const auto z = estimate::wash_out(file.arm, {&recording, 1}, 1);
  estimate::LatentFrictionModel model(
      file.arm, recording, *file.noise,
      estimate::initial_state(recording, z[0].row(0), estimate::latent_sizes(z), *file.noise),
      kStep);
  const estimate::EStepResult smoothed =
      smooth(model, recording, recording.length(), {.paths = kPaths});
  if (smoothed.failed) {
    fmt::print(stderr, "{}: the smoother failed on {}\n", file.name, recording.log.name);
    return;
  }
  sums.log_likelihood += smoothed.log_likelihood;
  sums.nis += smoothed.nis * recording.length();
  sums.samples += recording.length();

  const std::vector<RowMatrix> draws =
      friction_of(model, smoothed.paths, evaluate::constant_friction(file.arm.robot, known));
  const evaluate::Band band = evaluate::band_of(draws);
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index k = 0; k < band.low.rows(); ++k) {
      const double wanted = tau_f(k, j);
      double mean = 0;
      for (const RowMatrix& draw : draws) mean += draw(k, j) / kPaths;
      sums.inside += band.low(k, j) <= wanted && wanted <= band.high(k, j);
      sums.count += 1;
      sums.error[j] += (mean - wanted) * (mean - wanted);
      sums.truth[j] += wanted * wanted;
      sums.spread[j] += std::pow((band.high(k, j) - band.low(k, j)) / 2, 2);
    }
  for (const int k : lost)
    for (Eigen::Index j = 0; j < n; ++j) {
      double mean = 0;
      for (const smc::RowMatrix& path : smoothed.paths) mean += path(k, j) / kPaths;
      sums.q_error += std::pow(mean - q(k, j), 2);
      sums.missing += 1;
    }
}

/// Mean over joints of the root of a / b [%].
double percent(const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
  double sum = 0;
  for (Eigen::Index j = 0; j < a.size(); ++j)
    sum += 100 * std::sqrt(a[j] / b[j]) / static_cast<double>(a.size());
  return sum;
}

void print(const data::ModelFile& file, const scene::Problem& problem,
           const std::filesystem::path& run) {
  for (const double missing : {0.0, kMissing}) {
    const auto n = static_cast<Eigen::Index>(file.arm.robot.n());
    Sums sums;
    sums.error = sums.truth = sums.spread = Eigen::ArrayXd::Zero(n);
    for (int i = 0;; ++i) {
      const std::string name = fmt::format("validation_{}.h5", i);
      if (!std::filesystem::exists(run / "data" / name)) break;
      const data::Dataset dataset = data::load_dataset(run / "data" / name);
      const double cutoff = problem.scene.identify.cutoff_hz;
      add_recording(file, problem.robot, signals::make_recording(dataset, cutoff),
                    run / "truth" / name, missing, static_cast<std::uint64_t>(i), sums);
    }
    fmt::print("| {} | {:.0f} |", file.label, 100 * missing);
    for (Eigen::Index j = 0; j < n; ++j) fmt::print(" {:.2g}", 1e3 * std::sqrt(file.noise->v[j]));
    fmt::print(
        " | {:.2f} | {:.2f} | {:.0f} | {:.2g} | {:.2g} | {} |\n",
        sums.log_likelihood / sums.samples, sums.nis / sums.samples, 100 * sums.inside / sums.count,
        percent(sums.spread, sums.truth), percent(sums.error, sums.truth),
        sums.missing > 0 ? fmt::format("{:.2g}", std::sqrt(sums.q_error / sums.missing)) : "");
    std::fflush(stdout);
  }
}

int run(const std::vector<std::string>& arguments) {
  const std::filesystem::path folder = arguments.at(0);
  const scene::Problem problem = scene::load_problem(folder / "scene.toml");
  fmt::print(
      "| model | missing % | sd of v per sample, joint by joint [mrad/s] | log-likelihood per "
      "sample | NIS | tau_f inside % | half width % | tau_f error % | missing q [rad] |\n"
      "|---|--:|---|--:|--:|--:|--:|--:|--:|\n");
  for (std::size_t i = 1; i < arguments.size(); ++i)
    print(data::load_model(arguments[i]), problem, folder);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace fricid

int main(int argc, char** argv) {
  try {
    return fricid::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return EXIT_FAILURE;
  }
}
