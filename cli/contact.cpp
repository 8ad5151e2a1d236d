// fricid contact: external torque along a log.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "commands.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/data/contact_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/estimate/contact/contact_log.hpp"
#include "fricid/workflow/check.hpp"
#include "outputs.hpp"
#include "terminal.hpp"

namespace fricid::cli {
namespace {

/// Samples [begin, end).
struct Span {
  Eigen::Index begin = 0, end = 0;
};

/// Where the torque of a joint is not known.
std::vector<Span> spans_left_out(const RowMatrix& tau_ext) {
  std::vector<Span> spans;
  for (Eigen::Index k = 0; k < tau_ext.rows(); ++k) {
    if (tau_ext.row(k).allFinite()) continue;
    if (spans.empty() || spans.back().end != k) spans.push_back({k, k});
    spans.back().end = k + 1;
  }
  return spans;
}

std::string words_of(const std::vector<Span>& spans, const Eigen::VectorXd& t) {
  constexpr std::size_t kShown = 5;
  if (spans.empty()) return {};
  Eigen::Index samples = 0;
  std::vector<std::string> shown;
  for (const Span& span : spans) {
    samples += span.end - span.begin;
    if (shown.size() < kShown)
      shown.push_back(fmt::format("{:.3f} to {:.3f} s", t[span.begin], t[span.end - 1]));
  }
  return fmt::format(
      "left out: {} of {} samples, until the observer has settled at the begin of the log and "
      "behind missing samples: {}{}\n",
      samples, t.size(), fmt::join(shown, ", "),
      spans.size() > kShown ? fmt::format(" and {} more", spans.size() - kShown) : "");
}

}  // namespace

Verdict find_contact(const ContactOptions& options, const CommonOptions& common) {
  require_not_input("-o", options.output, {options.model, options.log});
  const data::ModelFile model = data::load_model(options.model);
  require_like("-o", options.output, data::ContactSignals::kFormat);
  const data::Dataset log = workflow::joints_of(data::load_dataset(options.log), model.arm.robot,
                                                "model " + model.name, options.log.string());
  const data::ContactSignals found = estimate::observe_log(
      model, log,
      {.bandwidth_hz = options.bandwidth_hz, .particles = options.particles, .seed = options.seed});
  say_doubts(model);
  data::save_signals(found, options.output);

  nlohmann::json joints = nlohmann::json::array();
  std::string text = fmt::format("{:<16}{:>12}{:>14}{:>6}{:>10}\n", "external torque", "RMS",
                                 "largest", "", "at [s]");
  for (Eigen::Index j = 0; j < found.tau_ext.cols(); ++j) {
    Eigen::Index at = -1, known = 0;
    double largest = kNan, squares = 0;
    for (Eigen::Index k = 0; k < found.t.size(); ++k) {
      const double torque = std::abs(found.tau_ext(k, j));
      if (!std::isfinite(torque)) continue;
      ++known;
      squares += torque * torque;
      if (at >= 0 && torque <= largest) continue;
      largest = torque;
      at = k;
    }
    const double rms = std::sqrt(squares / static_cast<double>(known)),
                 at_s = at >= 0 ? found.t[at] : kNan;
    const std::string& name = found.joint_names[static_cast<std::size_t>(j)];
    joints.push_back({{"joint", name}, {"rms_Nm", rms}, {"largest_Nm", largest}, {"at_s", at_s}});
    const dynamics::Joint& joint = model.arm.robot.joints[static_cast<std::size_t>(j)];
    text += fmt::format("{:<16}{:>12.3g}{:>14.3g}{:>6}{:>10.3f}\n", name, rms, largest,
                        unit_of_joint("N m", slides(joint)), at_s);
  }
  const std::vector<Span> spans = spans_left_out(found.tau_ext);
  if (common.json) {
    nlohmann::json left_out = nlohmann::json::array();
    for (const Span& span : spans)
      left_out.push_back({{"from_s", found.t[span.begin]},
                          {"to_s", found.t[span.end - 1]},
                          {"samples", span.end - span.begin}});
    print_json(nlohmann::json{
        {"joints", joints}, {"left_out", left_out}, {"output", options.output.string()}});
  } else {
    print(text + words_of(spans, found.t) + fmt::format("\n{}\n", options.output.string()));
  }
  return Verdict::kDone;
}

}  // namespace fricid::cli
