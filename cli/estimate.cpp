// fricid estimate: the online filter over a log.
#include <fmt/format.h>

#include "commands.hpp"
#include "fricid/data/estimate_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/estimate/online/online_log.hpp"
#include "fricid/workflow/check.hpp"
#include "outputs.hpp"
#include "terminal.hpp"

namespace fricid::cli {
namespace {

constexpr double kMostLost = 0.01;  // of the samples, beyond which a filter is not to be trusted

}  // namespace

Verdict estimate_log(const EstimateOptions& options, const CommonOptions& common) {
  require_not_input("-o", options.output, {options.model, options.log});
  const data::ModelFile model = data::load_model(options.model);
  require_like("-o", options.output, data::EstimateSignals::kFormat);
  const data::Dataset log = workflow::joints_of(data::load_dataset(options.log), model.arm.robot,
                                                "model " + model.name, options.log.string());
  const estimate::OnlineLog estimated = estimate::estimate_log(
      model, log, {.particles = options.particles, .step = {8, 4}, .seed = options.seed});
  say_doubts(model);
  data::save_signals<data::EstimateSignals>(estimated, options.output);

  const int T = log.length();
  const double log_likelihood = estimated.log_likelihood[T - 1];
  if (common.json) {
    const nlohmann::json result = {{"samples", T},
                                   {"log_likelihood", log_likelihood},
                                   {"lost", estimated.lost},
                                   {"output", options.output.string()}};
    print_json(result);
  } else {
    print(
        fmt::format("{}: {} samples, log-likelihood {:.6g}, lost and brought back to the measured "
                    "motion {} times\n",
                    options.output.string(), T, log_likelihood, estimated.lost));
  }
  return estimated.lost <= kMostLost * T ? Verdict::kDone : Verdict::kNo;
}

}  // namespace fricid::cli
