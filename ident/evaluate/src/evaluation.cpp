#include "fricid/evaluate/evaluation.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"

namespace fricid::evaluate {
namespace {

using Values = std::vector<double>;

struct NamedValues {
  std::string_view key;
  const Values* values;
};

/// What the lists of one evaluation have to agree in.
class Shape {
 public:
  Shape(std::string place, std::size_t horizons, std::size_t trajectories)
      : place_(std::move(place)), horizons_(horizons), trajectories_(trajectories) {}

  const std::string& place() const { return place_; }
  std::size_t trajectories() const { return trajectories_; }

  /// @param owner  "" or "summary of lugre: "
  void per_horizon(const std::string& owner, std::initializer_list<NamedValues> lists) const {
    for (const auto& [key, values] : lists) require(owner, key, values->size(), horizons_);
  }
  void per_horizon(const std::string& owner, std::string_view key, std::size_t size) const {
    require(owner, key, size, horizons_);
  }
  void per_trajectory(const std::string& owner, std::string_view key, std::size_t size) const {
    require(owner, key, size, trajectories_);
  }
  /// All lists per joint are of one length; one that is not known is empty.
  void per_joint(const std::string& owner, std::initializer_list<NamedValues> lists) {
    for (const auto& [key, values] : lists) {
      if (values->empty()) continue;
      if (joints_ == 0) joints_ = values->size();
      require(owner, key, values->size(), joints_);
    }
  }
  void per_horizon_and_joint(const std::string& owner, std::string_view key,
                             const std::vector<Values>& lists) {
    require(owner, key, lists.size(), horizons_);
    for (const Values& values : lists) per_joint(owner, {{key, &values}});
  }

 private:
  void require(const std::string& owner, std::string_view key, std::size_t found,
               std::size_t expected) const {
    if (found != expected)
      throw UserError("{}: {}{} has {} entries; allowed: {}", place_, owner, key, found, expected);
  }

  std::string place_;
  std::size_t horizons_, trajectories_;
  std::size_t joints_ = 0;  // 0: no list has told it yet
};

void check_regimes(const RegimeError& error, const std::string& owner, Shape& shape) {
  shape.per_joint(owner, {{"all", &error.all},
                          {"presliding", &error.presliding},
                          {"reversal", &error.reversal},
                          {"sliding", &error.sliding}});
}

void check_model(const ModelResult& model, Shape& shape) {
  const std::string& place = shape.place();
  require_written_name(Named::kModel, model.name, place);
  require_label(model.label, "label", place);
  require_label(model.budget, "budget", place);
  const std::string owner = fmt::format("{} seed {}: ", model.name, model.seed);
  for (const RolloutScore& score : model.scores) {
    if (score.trajectory < 0 || static_cast<std::size_t>(score.trajectory) >= shape.trajectories())
      throw UserError("{}: {}trajectory = {}; allowed: 0 to {}", place, owner, score.trajectory,
                      shape.trajectories() - 1);
    require_label(score.name, "name of a trajectory", place);
    const HorizonErrors& error = score.error;
    shape.per_horizon(owner, {{"q_mse", &error.q_mse},
                              {"q_mae", &error.q_mae},
                              {"v_mse", &error.v_mse},
                              {"v_mae", &error.v_mae}});
    shape.per_horizon_and_joint(owner, "q_mse_joint", error.q_mse_joint);
    shape.per_horizon_and_joint(owner, "q_mae_joint", error.q_mae_joint);
    shape.per_horizon_and_joint(owner, "v_mse_joint", error.v_mse_joint);
    shape.per_horizon_and_joint(owner, "v_mae_joint", error.v_mae_joint);
    check_regimes(score.friction, owner + "friction_rmse ", shape);
    check_regimes(score.friction_rollout, owner + "friction_rmse_rollout ", shape);
  }
  if (!model.torque.empty()) shape.per_trajectory(owner, "torque", model.torque.size());
  for (const TorquePrediction& torque : model.torque) {
    check_regimes(torque.rmse, owner + "torque rmse ", shape);
    shape.per_joint(owner + "torque ", {{"one_step", &torque.one_step},
                                        {"percent_of_rms", &torque.percent_of_rms},
                                        {"r2", &torque.r2},
                                        {"drift", &torque.drift},
                                        {"drift_error", &torque.drift_error}});
  }
  if (model.torque_error)
    shape.per_joint(owner + "torque_error ", {{"sd", &model.torque_error->sd}});
}

void check_summary(const Summary& summary, const Shape& shape) {
  const std::string& place = shape.place();
  require_written_name(Named::kModel, summary.name, place);
  require_label(summary.label, "label", place);
  require_label(summary.budget, "budget", place);
  const std::string owner = fmt::format("summary of {}: ", summary.name);
  shape.per_horizon(owner, "interval_90", summary.interval_90.size());
  shape.per_horizon(owner, {{"q_mse_geometric_mean", &summary.q_mse_geometric_mean},
                            {"q_mse_mean", &summary.q_mse_mean},
                            {"q_mse_median", &summary.q_mse_median},
                            {"v_mse_geometric_mean", &summary.v_mse_geometric_mean},
                            {"ratio_to_oracle", &summary.ratio_to_oracle},
                            {"headroom_closed", &summary.headroom_closed}});
  for (const NamedValues& list : {NamedValues{"ensemble_q_mse", &summary.ensemble_q_mse},
                                  NamedValues{"ensemble_coverage", &summary.ensemble_coverage},
                                  NamedValues{"band_coverage", &summary.band_coverage},
                                  NamedValues{"band_half_width", &summary.band_half_width}})
    if (!list.values->empty()) shape.per_horizon(owner, {list});
}

}  // namespace

bool Evaluation::meaningful() const {
  return std::ranges::all_of(meaningless, [](const std::string& why) { return why.empty(); });
}

bool Evaluation::trusted() const {
  return unexplained.empty() &&
         std::ranges::all_of(summary, [](const Summary& s) { return s.doubts.empty(); });
}

void Evaluation::check(const std::string& place) const {
  require_name(Named::kScene, scene, place);
  if (horizons_s.empty()) throw UserError("{}: horizons_s is empty", place);
  if (trajectories.empty()) throw UserError("{}: trajectories is empty", place);
  for (const std::string& name : trajectories) require_name(Named::kTrajectory, name, place);
  Shape shape(place, horizons_s.size(), trajectories.size());
  shape.per_trajectory("", "repeats", repeats.size());
  for (const Repeats& motion : repeats)
    shape.per_joint("repeats ", {{"q_sd", &motion.q_sd}, {"tau_sd", &motion.tau_sd}});
  for (const ModelResult& model : models) check_model(model, shape);
  for (const Summary& row : summary) check_summary(row, shape);
  shape.per_horizon("", {{"oracle", &oracle},
                         {"halving", &halving},
                         {"repeat", &repeat},
                         {"floor", &floor},
                         {"integration", &integration},
                         {"best_conventional", &best_conventional},
                         {"headroom", &headroom}});
  shape.per_horizon("", "meaningless", meaningless.size());
  for (const Unexplained& torque : unexplained) {
    require_label(torque.recording, "recording of unexplained", place);
    require_label(torque.joint, "joint of unexplained", place);
    require_label(torque.difference, "difference of unexplained", place);
  }
}

}  // namespace fricid::evaluate
