#include "run.hpp"

#include "fricid/evaluate/evaluation_file.hpp"
#include "json_files.hpp"

namespace fricid::render {

namespace fs = std::filesystem;

std::vector<RunModel> Run::fitted() const {
  std::vector<RunModel> fitted;
  for (const RunModel& model : models)
    if (!model.is_oracle) fitted.push_back(model);
  return fitted;
}

fs::path Run::file(const std::string& kind, const RunModel& model) const {
  const fs::path path =
      folder / kind / fmt::format("{}_s{}_{}.h5", model.name, model.seeds.front(), trajectory);
  return fs::exists(path) ? path : fs::path();
}

friction::Friction friction_of_truth(const data::H5Reader& file, const fs::path& path) {
  std::vector<friction::JointSpec> joints;
  std::vector<double> theta;
  try {
    const auto root = nlohmann::json::parse(file.text_attribute("friction"));
    for (const auto& joint : root.at("joints")) {
      friction::JointSpec& spec = joints.emplace_back();
      for (const auto& law : joint.at("laws")) {
        friction::LawSpec& law_spec = spec.laws.emplace_back();
        law_spec.law = law.at("law").get<std::string>();
        law_spec.elements = law.at("elements").get<int>();
        for (const auto& modifier : law.at("modifiers"))
          law_spec.modifiers.push_back(
              {modifier.at("name").get<std::string>(), modifier.at("order").get<int>()});
        for (const auto& parameter : law.at("parameters"))
          theta.push_back(parameter.at("value").get<double>());
      }
    }
  } catch (const nlohmann::json::exception& error) {
    throw UserError("{}: attribute friction: {}", path.string(), error.what());
  }
  friction::Friction friction{friction::RobotFriction(std::move(joints)), std::move(theta)};
  if (friction.model.parameter_count() != static_cast<int>(friction.theta.size()))
    throw UserError("{}: attribute friction does not fit its own parameters", path.string());
  return friction;
}

Run read_run(const fs::path& folder) {
  Run run;
  run.folder = folder;
  run.evaluation = evaluate::load_evaluation(folder);
  run.models = models_of_run(folder);
  run.trajectory = run.evaluation.at("trajectories").at(0).get<std::string>();
  run.measured = data::load_dataset(folder / "data" / (run.trajectory + ".h5"));
  const fs::path truth = folder / "truth" / (run.trajectory + ".h5");
  if (fs::exists(truth)) {
    const data::H5Reader file(truth, "fricid.truth/1");
    run.truth = {file.vector("/t"), file.matrix("/v"), file.matrix("/tau_f"), file.matrix("/z"),
                 friction_of_truth(file, truth)};
  }
  return run;
}

std::vector<double> to_vector(const Eigen::Ref<const Eigen::VectorXd>& x) {
  return {x.data(), x.data() + x.size()};
}

Series curve(const RunModel& model, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y) {
  Series series = curve(model.label, model.look.colour, x, y);
  series.dash = model.look.dash;
  return series;
}

Series curve(const std::string& label, const std::string& colour, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y, double width) {
  return {.label = label, .colour = colour, .x = to_vector(x), .y = to_vector(y), .width = width};
}

}  // namespace fricid::render
