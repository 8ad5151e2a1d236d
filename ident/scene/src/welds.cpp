#include "welds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/upper_median.hpp"
#include "fricid/config/paths.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_part.hpp"

namespace fricid::scene {
namespace {

double median(const Eigen::VectorXd& x) {
  std::vector<double> values;
  for (const double value : x)
    if (std::isfinite(value)) values.push_back(value);
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return upper_median(std::move(values));
}

}  // namespace

dynamics::Welds welds_of(const Scene& scene) {
  const std::string key = scene.robot.fix.empty() ? "robot.hold" : "robot.fix";
  dynamics::Welds welds{scene.robot.fix, scene.origin.place(key) + ": " + key};
  for (const std::string& joint : scene.robot.hold)
    welds.at.emplace(joint, std::numeric_limits<double>::quiet_NaN());
  return welds;
}

void fix_held_joints(Scene& scene, const std::filesystem::path& contract_path,
                     const std::filesystem::path& folder) {
  RobotSection& robot = scene.robot;
  std::vector<std::string> open;
  for (const std::string& joint : robot.hold)
    if (!robot.fix.contains(joint)) open.push_back(joint);
  if (open.empty()) return;
  const std::string place = scene.origin.place("robot.hold");
  if (scene.simulates() || scene.data.train.empty())
    throw UserError("{}: robot.hold = \"{}\" without logs; allowed: robot.fix = {{{} = POSITION}}",
                    place, open[0], open[0]);
  const std::string& log = scene.data.train.front();
  const data::LogPart part = data::log_part(log);
  const std::filesystem::path file = config::find_file(part.file, folder);
  const data::Dataset d =
      data::cut(contract_path.empty() ? data::load_dataset(file)
                                      : data::read_log(file, data::load_contract(contract_path)),
                part, log);
  for (const std::string& joint : open) {
    const auto found = std::ranges::find(d.joint_names, joint);
    if (found == d.joint_names.end())
      throw UserError(
          "{}: robot.hold = \"{}\"; allowed: joints of the log, {}; or "
          "robot.fix = {{{} = POSITION}}",
          place, joint, fmt::join(d.joint_names, ", "), joint);
    const double position = median(d.q.col(found - d.joint_names.begin()));
    if (!std::isfinite(position))
      throw UserError("{}: robot.hold = \"{}\": {} has no position of it", place, joint, log);
    robot.fix[joint] = position;
  }
}

}  // namespace fricid::scene
