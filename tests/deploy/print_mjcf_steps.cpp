// Prints how far the MJCF of a Maxwell slip bank and of a gms model is from the exact law in 4 s,
// by step and by size of the torque: the table of docs/exports.md.
#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <utility>

#include "law_errors.hpp"
#include "mjcf_apart.hpp"

int main() {
  using namespace fricid::deploy::test;
  constexpr double kExact = 1e-5;  // step of the exact law [s]
  constexpr double kSteps[] = {2e-3, 1e-3, 5e-4, 2.5e-4, 1e-4};
  std::cout << "| law | torque up to [N m] | range [rad] |";
  for (const double step : kSteps) std::cout << fmt::format(" {:g} ms |", 1e3 * step);
  std::cout << " from the law in steps of 1 ms |\n|---|---|---|---|---|---|---|---|---|\n";
  const std::pair<const char*, fricid::data::ModelFile> models[] = {
      {"maxwell_slip", robot_with("maxwell_slip")},
      {"gms, Fs = Fc", gms_without_stribeck()},
      {"gms", robot_with("gms")}};
  for (const auto& [name, model] : models)
    for (const double share : {0.25, 0.5, 1.0, 2.0}) {
      std::string errors;
      double range = 0, own = 0;
      for (const double step : kSteps) {
        const int substeps = static_cast<int>(std::lround(step / kExact));
        const Apart exact = apart(model, {.step = step, .substeps = substeps, .share = share});
        errors += fmt::format(" {:.1e} |", exact.rms);
        range = exact.range;
        // what is left between MJCF and the law in the same steps
        if (step == 1e-3) own = apart(model, {.step = step, .share = share}).rms;
      }
      std::cout << fmt::format("| {} | {:g} | {:.2g} |{} {:.0e} |\n", name, 10 * share, range,
                               errors, own);
    }
}
