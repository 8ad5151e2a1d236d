#include "fricid/data/fit_file.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"

namespace fricid::data {
namespace {

/// All lists per joint are of one length, or empty where nothing is known.
void check_joints(const FitFile& fit, const std::string& place) {
  const FittedRigidBody& body = fit.rigid_body;
  const FittedLoadGrowth growth = body.load_growth.value_or(FittedLoadGrowth());
  const std::array<std::pair<std::string_view, std::ptrdiff_t>, 14> lists{
      {{"joints", std::ssize(fit.joints)},
       {"rows_used", std::ssize(body.rows)},
       {"rows_total", std::ssize(body.rows_total)},
       {"equations", std::ssize(body.equations)},
       {"residual_sd_Nm", body.sigma.size()},
       {"coulomb_Nm", body.Fc.size()},
       {"viscous_Nms_rad", body.Fv.size()},
       {"offset_Nm", body.offset.size()},
       {"coulomb_se_Nm", body.Fc_se.size()},
       {"viscous_se_Nms_rad", body.Fv_se.size()},
       {"offset_se_Nm", body.offset_se.size()},
       {"law_factor", body.law_factor.size()},
       {"load_growth.coefficient", growth.coefficient.size()},
       {"load_growth.standard_error", growth.standard_error.size()}}};
  std::ptrdiff_t joints = 0;
  for (const auto& [key, size] : lists) {
    if (size == 0) continue;
    if (joints == 0) joints = size;
    if (size != joints)
      throw UserError("{}: {} has {} entries; allowed: {}, one per joint", place, key, size,
                      joints);
  }
}

void check_training(const FittedTraining& training, std::string_view key,
                    const std::string& place) {
  const std::ptrdiff_t looks = std::ssize(training.checked);
  if (std::ssize(training.held_out) != looks)
    throw UserError("{}: {}.held_out has {} entries; allowed: {}, as checked", place, key,
                    training.held_out.size(), looks);
  if (training.chosen < 0 || training.chosen > std::max<std::ptrdiff_t>(looks - 1, 0))
    throw UserError("{}: {}.chosen = {}; allowed: one of {} looks", place, key, training.chosen,
                    looks);
}

}  // namespace

std::string in_words(const FittedTo& part) {
  return fmt::format("{:.0f} of {:.0f} s, {} pieces drawn over all of it", part.seconds,
                     part.of_seconds, part.pieces);
}

void FitFile::check(const std::string& place) const {
  require_name(Named::kModel, name, place);
  require_label(label, "label", place);
  check_joints(*this, place);
  for (const FittedJoint& joint : joints) {
    require_name(Named::kJoint, joint.joint, place);
    const auto size = static_cast<Eigen::Index>(joint.parameters.size());
    if (joint.correlation.size() > 0 &&
        (joint.correlation.rows() != size || joint.correlation.cols() != size))
      throw UserError("{}: correlation of {} is {} x {}; allowed: {} x {}", place, joint.joint,
                      joint.correlation.rows(), joint.correlation.cols(), size, size);
  }
  if (draws && draws->pi.rows() != draws->theta.rows())
    throw UserError("{}: draws.rigid_body has {} rows, draws.friction {}; allowed: as many", place,
                    draws->pi.rows(), draws->theta.rows());
  if (torque) check_training(*torque, "torque", place);
  if (multi_step) check_training(*multi_step, "multi_step", place);
}

const FittedParameter* fitted_parameter(const FitFile& fit, const friction::RobotFriction& friction,
                                        int i) {
  const friction::ParameterRef& parameter = friction.parameters()[static_cast<std::size_t>(i)];
  if (parameter.joint < 0 || parameter.joint >= std::ssize(fit.joints)) return nullptr;
  const auto& found = fit.joints[static_cast<std::size_t>(parameter.joint)].parameters;
  const int place = i - friction.parameter_begin(parameter.joint);
  if (place >= std::ssize(found)) return nullptr;
  const FittedParameter& own = found[static_cast<std::size_t>(place)];
  return own.symbol == parameter.symbol ? &own : nullptr;
}

}  // namespace fricid::data
