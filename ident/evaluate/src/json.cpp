#include <cmath>
#include <nlohmann/json.hpp>

#include "fricid/evaluate/evaluate.hpp"
#include "json.hpp"

namespace fricid::evaluate {
namespace {

void put_friction(Json& json, const RegimeError& error, const std::string& prefix) {
  if (error.all.empty()) return;
  json[prefix] = numbers(error.all);
  json[prefix + "_presliding"] = numbers(error.presliding);
  json[prefix + "_reversal"] = numbers(error.reversal);
  json[prefix + "_sliding"] = numbers(error.sliding);
}

Json score_json(const RolloutScore& score, const EvaluationReport& report) {
  Json json;
  json["name"] = report.trajectories[static_cast<std::size_t>(score.trajectory)];
  json["start_s"] = score.start_s;
  json["diverged"] = score.diverged;
  const auto per_horizon = [&](const char* key, double HorizonError::*member) {
    json[key] = list(score.horizons, [&](const HorizonError& e) { return number(e.*member); });
  };
  const auto per_joint = [&](const char* key, std::vector<double> HorizonError::*member) {
    json[key] = list(score.horizons, [&](const HorizonError& e) { return numbers(e.*member); });
  };
  per_horizon("q_mse", &HorizonError::q_mse);
  per_horizon("q_mae", &HorizonError::q_mae);
  per_horizon("v_mse", &HorizonError::v_mse);
  per_horizon("v_mae", &HorizonError::v_mae);
  per_joint("q_mse_joint", &HorizonError::q_mse_joint);
  per_joint("q_mae_joint", &HorizonError::q_mae_joint);
  per_joint("v_mse_joint", &HorizonError::v_mse_joint);
  per_joint("v_mae_joint", &HorizonError::v_mae_joint);
  put_friction(json, score.friction, "friction_rmse");
  put_friction(json, score.friction_rollout, "friction_rmse_rollout");
  return json;
}

Json torque_json(const TorquePrediction& torque) {
  return {{"rmse", numbers(torque.rmse.all)},
          {"rmse_presliding", numbers(torque.rmse.presliding)},
          {"rmse_reversal", numbers(torque.rmse.reversal)},
          {"rmse_sliding", numbers(torque.rmse.sliding)},
          {"one_step", numbers(torque.one_step)},
          {"percent_of_rms", numbers(torque.percent_of_rms)},
          {"r2", numbers(torque.r2)},
          {"drift", numbers(torque.drift)},
          {"drift_error", numbers(torque.drift_error)}};
}

Json repeats_json(const Repeats& repeats) {
  if (repeats.period_s == 0) return nullptr;
  return {{"period_s", repeats.period_s},
          {"q_sd", numbers(repeats.q_sd)},
          {"tau_sd", numbers(repeats.tau_sd)}};
}

Json torque_error_json(const std::optional<TorqueError>& error) {
  if (!error) return nullptr;
  return {{"time_s", error->time}, {"sd", numbers(error->sd)}, {"slow_gain", error->slow_gain}};
}

Json model_json(const ModelResult& model, const EvaluationReport& report) {
  return {
      {"name", model.name},
      {"label", model.label},
      {"seed", model.seed},
      {"parameters", model.parameters},
      {"fit_seconds", model.fit_seconds},
      {"budget", model.budget},
      {"is_oracle", model.is_oracle},
      {"is_conventional", model.is_conventional},
      {"friction_states", model.friction_states},
      {"trajectories",
       list(model.scores, [&](const RolloutScore& score) { return score_json(score, report); })},
      {"torque", list(model.torque, torque_json)},
      {"torque_error", torque_error_json(model.torque_error)}};
}

Json summary_json(const Summary& summary) {
  return {{"name", summary.name},
          {"label", summary.label},
          {"is_oracle", summary.is_oracle},
          {"is_conventional", summary.is_conventional},
          {"seeds", summary.seeds},
          {"parameters", summary.parameters},
          {"fit_seconds", summary.fit_seconds},
          {"budget", summary.budget},
          {"q_mse_geometric_mean", numbers(summary.q_mse_geometric_mean)},
          {"q_mse_median", numbers(summary.q_mse_median)},
          {"q_mse_mean", numbers(summary.q_mse_mean)},
          {"v_mse_geometric_mean", numbers(summary.v_mse_geometric_mean)},
          {"interval_90", intervals(summary.interval_90)},
          {"interval_over", summary.interval_over},
          {"ratio_to_oracle", numbers(summary.ratio_to_oracle)},
          {"headroom_closed", numbers(summary.headroom_closed)},
          {"diverged", summary.diverged},
          {"rollouts", summary.rollouts},
          {"friction", number(summary.friction)},
          {"friction_presliding", number(summary.friction_presliding)},
          {"friction_reversal", number(summary.friction_reversal)},
          {"friction_sliding", number(summary.friction_sliding)},
          {"friction_rollout", number(summary.friction_rollout)},
          {"ensemble_q_mse", numbers(summary.ensemble_q_mse)},
          {"ensemble_coverage", numbers(summary.ensemble_coverage)},
          {"band_coverage", numbers(summary.band_coverage)},
          {"band_half_width", numbers(summary.band_half_width)}};
}

}  // namespace

std::string to_json(const EvaluationReport& report) {
  Json json;
  json["format"] = "fricid.evaluation/1";
  json["scene"] = report.scene;
  json["horizons_s"] = numbers(report.horizons_s);
  json["trajectories"] = report.trajectories;
  json["repeats"] = list(report.repeats, repeats_json);
  json["models"] =
      list(report.models, [&](const ModelResult& model) { return model_json(model, report); });
  json["summary"] = list(report.summary, summary_json);
  json["headroom"] = numbers(report.headroom);
  json["oracle"] = numbers(report.oracle);
  json["halving"] = numbers(report.halving);
  json["repeat"] = numbers(report.repeat);
  json["floor"] = numbers(report.floor);
  json["integration"] = numbers(report.integration);
  json["best_conventional"] = numbers(report.best_conventional);
  json["meaningful"] = report.meaningful();
  json["meaningless"] = list(report.verdict, [](const HorizonVerdict& verdict) {
    return verdict.meaningless ? Json(verdict.reason) : Json(nullptr);
  });
  return json.dump(1) + "\n";
}

}  // namespace fricid::evaluate
