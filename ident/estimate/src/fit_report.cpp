#include <nlohmann/json.hpp>

#include "fricid/base/files.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {
namespace {

using Json = nlohmann::ordered_json;

Json vector_of(const Eigen::VectorXd& x) {
  return std::vector<double>(x.data(), x.data() + x.size());
}

// The standard error, or nothing where the data do not tell the parameter.
Json confidence(double standard_error, double size) {
  return judge(standard_error, size) == Verdict::kNot ? Json() : Json(standard_error);
}

Json rigid_body_json(const RigidBodyFit& fit, const std::vector<std::string>& joints) {
  Json base = Json::array();
  for (Eigen::Index i = 0; i < fit.base.size(); ++i)
    base.push_back({{"name", fit.base_names[static_cast<std::size_t>(i)]},
                    {"value", fit.base[i]},
                    {"verdict", to_string(judge(fit.base_se[i], fit.base_size[i]))},
                    {"standard_error", confidence(fit.base_se[i], fit.base_size[i])},
                    {"physical", fit.base_physical[i]}});
  return {{"outcome", to_string(fit.outcome)},
          {"message", fit.message},
          {"condition", fit.condition},
          {"joints", joints},
          {"rows_used", fit.rows},
          {"rows_total", fit.rows_total},
          {"equations", fit.equations},
          {"residual_sd_Nm", vector_of(fit.sigma)},
          {"coulomb_Nm", vector_of(fit.Fc)},
          {"viscous_Nms_rad", vector_of(fit.Fv)},
          {"offset_Nm", vector_of(fit.offset)},
          {"coulomb_se_Nm", vector_of(fit.Fc_se)},
          {"viscous_se_Nms_rad", vector_of(fit.Fv_se)},
          {"offset_se_Nm", vector_of(fit.offset_se)},
          {"base_parameters", base},
          {"seconds", fit.seconds}};
}

Json torque_json(const TorqueReport& report) {
  return {{"outcome", to_string(report.outcome)},
          {"message", report.message},
          {"loss", report.loss},
          {"checked", report.checked},
          {"held_out_share", report.held_out},
          {"chosen", report.best},
          {"skipped", report.skipped},
          {"seconds", report.seconds}};
}

Json multi_step_json(const MultiStepReport& report) {
  return {{"outcome", to_string(report.outcome)},
          {"message", report.message},
          {"loss", report.loss},
          {"checked", report.checked},
          {"held_out_q_mse", report.held_out},
          {"chosen", report.best},
          {"skipped", report.skipped},
          {"returns", report.returns},
          {"leap", report.leap},
          {"seconds", report.seconds}};
}

Json em_json(const EmReport& report) {
  Json iterations = Json::array();
  for (const EmIteration& i : report.iterations)
    iterations.push_back({{"log_likelihood", i.log_likelihood},
                          {"nis", i.nis},
                          {"least_roots", i.least_roots},
                          {"least_backward_ess", i.least_backward_ess},
                          {"objective", i.objective},
                          {"held_out_q_mse", i.held_out}});
  return {{"outcome", to_string(report.outcome)},
          {"message", report.message},
          {"held_out_q_mse_start", report.held_out_start},
          {"iterations", iterations},
          {"chosen", report.best},
          {"warnings", report.warnings},
          {"variance_q", vector_of(report.noise.q)},
          {"variance_v", vector_of(report.noise.v)},
          {"variance_z", vector_of(report.noise.z)},
          {"variance_observation", vector_of(report.noise.R)},
          {"seconds", report.seconds}};
}

}  // namespace

void save_fit_report(const FitReport& report, const std::filesystem::path& path) {
  std::vector<std::string> names;
  for (const auto& joint : report.model.arm.robot.joints) names.push_back(joint.name);

  const friction::RobotFriction& friction = report.model.arm.friction.model;
  Json joints = Json::array();
  for (std::size_t j = 0; j < report.joints.size(); ++j) {
    const JointFrictionFit& fit = report.joints[j];
    Json parameters = Json::object(), standard_errors = Json::object(), matrix = Json::array(),
         symbols = Json::array();
    const auto begin = static_cast<std::size_t>(friction.parameter_begin(static_cast<int>(j)));
    for (std::size_t i = 0; i < fit.theta.size(); ++i) {
      const std::string& symbol = friction.parameters()[begin + i].symbol;
      symbols.push_back(symbol);
      parameters[symbol] = fit.theta[i];
      if (i < fit.standard_error.size()) standard_errors[symbol] = fit.standard_error[i];
    }
    for (const auto& row : fit.correlation.rowwise()) matrix.push_back(vector_of(row.transpose()));
    joints.push_back({{"joint", names[j]},
                      {"outcome", to_string(fit.outcome)},
                      {"message", fit.message},
                      {"offset_Nm", fit.offset},
                      {"rms_Nm", fit.rms},
                      {"explained", fit.explained},
                      {"residual_rms_Nm", report.residual_rms[j]},
                      {"r2", report.r2[j]},
                      {"start_rms_Nm", fit.start_rms},
                      {"at_bound", fit.at_bound},
                      {"evaluations", fit.evaluations},
                      {"parameters", parameters},
                      {"standard_errors", standard_errors},
                      {"correlation", {{"parameters", symbols}, {"matrix", matrix}}}});
  }
  Json out = {{"format", "fricid.fit/1"},
              {"name", report.model.name},
              {"label", report.model.label},
              {"seed", report.model.seed},
              {"method", report.method},
              {"outcome", to_string(report.outcome)},
              {"usable", report.usable()},
              {"message", report.message},
              {"objective", report.objective},
              {"parameters", report.model.free_parameters},
              {"seconds", report.seconds},
              {"rigid_body", rigid_body_json(report.rigid_body, names)},
              {"joints", joints}};
  if (report.torque) out["torque"] = torque_json(*report.torque);
  if (report.multi_step) out["multi_step"] = multi_step_json(*report.multi_step);
  if (report.em) out["em"] = em_json(*report.em);
  write_file_atomically(path, out.dump(2) + "\n");
}

}  // namespace fricid::estimate
