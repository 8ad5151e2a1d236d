// Prints how far the MJCF of a Maxwell slip bank and of a gms model is from the exact law in 4 s,
// by step, size of the torque and integrator: the tables of docs/exports.md.
#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <utility>

#include "law_errors.hpp"
#include "mjcf_apart.hpp"

namespace {

using namespace fricid::deploy::test;
constexpr double kExact = 1e-5;  // step of the exact law [s]

Apart from_exact(const fricid::data::ModelFile& model, Drive drive) {
  drive.substeps = static_cast<int>(std::lround(drive.step / kExact));
  return apart(model, drive);
}

}  // namespace

int main() {
  const std::pair<const char*, fricid::data::ModelFile> models[] = {
      {"maxwell_slip", robot_with("maxwell_slip")},
      {"gms, Fs = Fc", gms_without_stribeck()},
      {"gms", robot_with("gms")}};
  constexpr double kSteps[] = {2e-3, 1e-3, 5e-4, 2.5e-4, 1e-4};
  std::cout << "| law | torque up to [N m] | range [rad] |";
  for (const double step : kSteps) std::cout << fmt::format(" {:g} ms |", 1e3 * step);
  std::cout << " the law, 1 ms | half a step of 1 ms | MJCF from the law, both 1 ms |\n"
               "|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [name, model] : models)
    for (const double share : {0.25, 0.5, 1.0, 2.0}) {
      std::string errors;
      Apart at_1_ms;
      for (const double step : kSteps) {
        const Apart exact = from_exact(model, {.step = step, .share = share});
        errors += fmt::format(" {:.1e} |", exact.rms);
        if (step == 1e-3) at_1_ms = exact;
      }
      std::cout << fmt::format("| {} | {:g} | {:.2g} |{} {:.1e} | {:.1e} | {:.0e} |\n", name,
                               10 * share, at_1_ms.range, errors, at_1_ms.law_rms,
                               at_1_ms.half_step, apart(model, {.step = 1e-3, .share = share}).rms);
    }

  const std::pair<const char*, mjtIntegrator> integrators[] = {{"Euler", mjINT_EULER},
                                                               {"implicit", mjINT_IMPLICIT},
                                                               {"implicitfast", mjINT_IMPLICITFAST},
                                                               {"RK4", mjINT_RK4},
                                                               {"discrete", mjINT_DISCRETE}};
  std::cout << "\n| law | step [ms] |";
  for (const auto& [name, integrator] : integrators) std::cout << fmt::format(" {} |", name);
  std::cout << "\n|---|---|---|---|---|---|---|\n";
  for (const auto& [name, model] : {models[0], models[1]})
    for (const double step : {1e-3, 1e-4}) {
      std::cout << fmt::format("| {} | {:g} |", name, 1e3 * step);
      for (const auto& [_, integrator] : integrators)
        std::cout << fmt::format(" {:.1e} |",
                                 from_exact(model, {.step = step, .integrator = integrator}).rms);
      std::cout << "\n";
    }
}
