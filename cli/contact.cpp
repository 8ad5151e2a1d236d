// fricid contact: external torque along a log.
#include <fmt/format.h>

#include "commands.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/estimate/contact/contact_log.hpp"
#include "fricid/workflow/check.hpp"
#include "outputs.hpp"
#include "terminal.hpp"

namespace fricid::cli {

Verdict find_contact(const ContactOptions& options, const CommonOptions& common) {
  require_not_input("-o", options.output, {options.model, options.log});
  const data::ModelFile model = data::load_model(options.model);
  const data::Dataset log = workflow::joints_of(data::load_dataset(options.log), model.arm.robot,
                                                "model " + model.name, options.log.string());
  const data::ContactSignals found = estimate::observe_log(
      model, log,
      {.bandwidth_hz = options.bandwidth_hz, .particles = options.particles, .seed = options.seed});
  data::save_signals(found, options.output);

  nlohmann::json joints = nlohmann::json::array();
  std::string text = fmt::format("{:<16}{:>12}{:>14}{:>10}\n", "external torque", "RMS [N m]",
                                 "largest [N m]", "at [s]");
  for (Eigen::Index j = 0; j < found.tau_ext.cols(); ++j) {
    Eigen::Index at = 0;
    const double largest = found.tau_ext.col(j).cwiseAbs().maxCoeff(&at);
    const double rms =
        std::sqrt(found.tau_ext.col(j).squaredNorm() / static_cast<double>(found.t.size()));
    const std::string& name = found.joint_names[static_cast<std::size_t>(j)];
    joints.push_back(
        {{"joint", name}, {"rms_Nm", rms}, {"largest_Nm", largest}, {"at_s", found.t[at]}});
    text += fmt::format("{:<16}{:>12.3g}{:>14.3g}{:>10.3f}\n", name, rms, largest, found.t[at]);
  }
  if (common.json)
    print_json(nlohmann::json{{"joints", joints}, {"output", options.output.string()}});
  else
    print(text + fmt::format("\n{}\n", options.output.string()));
  return Verdict::kDone;
}

}  // namespace fricid::cli
