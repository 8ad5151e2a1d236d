#include "fitted_model.hpp"

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"

namespace fricid::workflow {

data::ModelFile load_fitted(const RunFolder& folder, const FitId& id,
                            const std::vector<std::string>& joints) {
  const std::string file = folder.model(id).string();
  data::ModelFile model = data::load_model(file);
  if (model.is_oracle || model.name != id.model || model.seed != id.seed)
    throw UserError("{}: found the model {}, seed {}{}; allowed: {}, seed {}", file,
                    printable(model.name), model.seed, model.is_oracle ? ", an oracle" : "",
                    id.model, id.seed);
  const std::vector<std::string> found = model.arm.robot.joint_names();
  if (found != joints)
    throw UserError("{}: found the joints {}; allowed: those of the robot, {}", file,
                    fmt::join(found, ", "), fmt::join(joints, ", "));
  return model;
}

}  // namespace fricid::workflow
