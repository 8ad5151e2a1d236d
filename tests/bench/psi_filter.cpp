// How steady the twisted (psi) filter is on a robot, and how many of its particles' histories last:
// prints the tables of docs/inference.md, "At the truth of a robot". Models given by file are drawn
// from and filtered like the built-in ones.
//
//     fricid_psi_filter [MODEL.json ...]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "drawn_recording.hpp"
#include "fricid/base/error.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/statistical_twist.hpp"

namespace fricid {
namespace {

constexpr int kSamples = 1000, kParticles = 200, kRuns = 10;
constexpr StepOptions kStep{8, 4};
constexpr double kOff = 0.3;  // of wrong parameters

/// Over the runs on one recording.
struct Figures {
  double sd = 0;           ///< of the log-likelihood [nat]
  double over_ekf = 0;     ///< its mean above the Gaussian filter's [nat]
  double least_ess = 1;    ///< of all steps, per particle
  double least_roots = 1;  ///< of all runs, per particle
  double resampled = 0;    ///< times per run
  int failed = 0;          ///< runs whose weights vanished
};

/// The model along one recording with psi made.
struct Case {
  estimate::LatentFrictionModel model;
  smc::RowMatrix y;
  smc::GaussianPath path;
  smc::Twist twist;
  bool bent = false;

  Case(const Arm& arm, const signals::Recording& recording, const LatentNoise& noise,
       const smc::Gaussian& initial)
      : model(arm, recording, noise, initial, kStep), y(recording.log.q) {
    smc::gaussian_smoother(model, y, path, 2);
    bent = !path.failed && smc::make_bent_twist(model, y, model.parts(), path.smoothed, twist) &&
           run(0.25, 0.05).failed == 0;
    if (path.failed || bent) return;
    // as the E-step does
    smc::gaussian_smoother(model, y, path, 2);
    smc::make_twist(model, y, path, twist);
  }

  Figures run(double threshold, double renewed) {
    Figures out;
    if (path.failed) {
      out.failed = kRuns;
      return out;
    }
    smc::TwistedGuide<PackD> guide(model, twist);
    double sum = 0, squares = 0, count = 0;
    for (int k = 0; k < kRuns; ++k) {
      smc::FilterOptions options;
      options.particles = kParticles;
      options.ess_threshold = threshold;
      options.renewed = renewed;
      options.seed = static_cast<std::uint64_t>(k + 1);
      smc::ParticleFilter filter(model, guide, options);
      smc::Report report;
      filter.run(report);
      if (report.failed) {
        ++out.failed;
        continue;
      }
      const double x = report.log_likelihood - path.log_likelihood;
      sum += x;
      squares += x * x;
      count += 1;
      for (const double ess : report.ess) out.least_ess = std::min(out.least_ess, ess / kParticles);
      out.least_roots =
          std::min(out.least_roots, static_cast<double>(report.distinct_roots) / kParticles);
      out.resampled += static_cast<double>(report.resampled) / kRuns;
    }
    out.over_ekf = sum / count;
    out.sd = std::sqrt(std::max(0.0, squares - sum * sum / count) / (count - 1));
    return out;
  }
};

Arm arm_of(const std::string& law) { return {test::hanging_kr6(), test::kr6_friction(law)}; }

/// Every friction parameter 30 % too large or too small.
Arm wrong(Arm arm, std::uint64_t seed) {
  Rng rng(seed, 0);
  for (std::size_t p = 0; p < arm.friction.theta.size(); ++p) {
    const friction::ParameterInfo& info = arm.friction.model.parameters()[p].info;
    const double off = rng.uniform() < 0.5 ? 1 - kOff : 1 + kOff;
    arm.friction.theta[p] = std::clamp(off * arm.friction.theta[p], info.lower, info.upper);
  }
  return arm;
}

/// When to resample, over recordings of LuGre with the model at the truth.
void print_rules() {
  constexpr int kRecordings = 12;
  // ESS / N below which one resamples, share renewed
  constexpr double kRules[][2] = {{0.5, 1}, {0.25, 1}, {0.25, 0.05}, {0, 1}};
  std::vector<std::vector<Figures>> figures(std::size(kRules));
  const Arm arm = arm_of("lugre");
  for (std::uint64_t seed = 1; seed <= kRecordings; ++seed) {
    const test::Drawn drawn = test::draw(arm, kSamples, seed, kStep);
    Case at_truth(arm, drawn.recording, drawn.noise, drawn.initial);
    for (std::size_t i = 0; i < figures.size(); ++i)
      figures[i].push_back(at_truth.run(kRules[i][0], kRules[i][1]));
  }
  fmt::print(
      "| resample below ESS / N | renewed / N | sd, median and worst [nat] | recordings with "
      "0.9 N roots | fewest roots / N | least ESS / N |\n|--:|--:|--:|--:|--:|--:|\n");
  for (std::size_t i = 0; i < figures.size(); ++i) {
    std::vector<double> sd, roots, ess;
    for (const Figures& f : figures[i]) {
      sd.push_back(f.sd);
      roots.push_back(f.least_roots);
      ess.push_back(f.least_ess);
    }
    std::sort(sd.begin(), sd.end());
    fmt::print("| {:g} | {:g} | {:.3f}, {:.3f} | {} of {} | {:.2f} | {:.2f} |\n", kRules[i][0],
               kRules[i][1], sd[kRecordings / 2], sd.back(),
               std::count_if(roots.begin(), roots.end(), [](double x) { return x >= 0.9; }),
               kRecordings, std::ranges::min(roots), std::ranges::min(ess));
    std::fflush(stdout);
  }
}

void print_row(const std::string& name, std::uint64_t seed, Case& the_case) {
  const smc::NisFigure nis = smc::nis_figure(the_case.path.nis, the_case.path.present);
  const Figures f = the_case.run(0.25, 0.05);
  fmt::print("| {} | {} | {:.2g} | {} | {:.3g} | {:.3g} | {:.3f} | {:.2f} | {:g} | {} |\n", name,
             seed, nis.mean, the_case.bent ? "bent" : "plain", f.sd, f.over_ekf, f.least_ess,
             f.least_roots, f.resampled, f.failed);
  std::fflush(stdout);
}

/// Other laws at their truth, and wrong parameters of LuGre and GMS: under the noise of the truth
/// and under the larger one that EM starts with.
void print_cases(const std::vector<std::string>& files) {
  fmt::print(
      "\n| model | recording | NIS | psi | sd [nat] | above EKF [nat] | least ESS / N | "
      "fewest roots / N | resampled | failed |\n|---|--:|--:|---|--:|--:|--:|--:|--:|--:|\n");
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const auto at_truth = [&](const std::string& name, const Arm& arm) {
      const test::Drawn drawn = test::draw(arm, kSamples, seed, kStep);
      Case the_case(arm, drawn.recording, drawn.noise, drawn.initial);
      print_row(name, seed, the_case);
    };
    for (const char* law : {"lugre", "gms"}) at_truth(law, arm_of(law));
    for (const std::string& file : files) {
      const data::ModelFile model = data::load_model(file);
      at_truth(model.name, model.arm);
    }
    for (const char* law : {"lugre", "gms"}) {
      const Arm arm = arm_of(law), off = wrong(arm, seed);
      test::Drawn drawn = test::draw(arm, kSamples, seed, kStep);
      Case same_noise(off, drawn.recording, drawn.noise, drawn.initial);
      print_row(fmt::format("{}, 30 % off", law), seed, same_noise);
      const Eigen::Index n = arm.robot.n();
      drawn.recording.wide.q = drawn.x.leftCols(n);
      drawn.recording.wide.v = drawn.x.middleCols(n, n);
      const std::vector<signals::Recording> recordings{drawn.recording};
      const LatentNoise noise = estimate::initial_noise(off, recordings, {});
      Case more_noise(off, drawn.recording, noise, drawn.initial);
      print_row(fmt::format("{}, 30 % off, EM's noise", law), seed, more_noise);
    }
  }
}

}  // namespace
}  // namespace fricid

int main(int argc, char** argv) {
  try {
    fricid::print_rules();
    fricid::print_cases({argv + 1, argv + argc});
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return EXIT_FAILURE;
  }
}
