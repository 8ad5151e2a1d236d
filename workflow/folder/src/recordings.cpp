#include "fricid/workflow/recordings.hpp"

#include <algorithm>

#include "fricid/base/error.hpp"
#include "fricid/data/log_part.hpp"

namespace fricid::workflow {

bool is_there(const std::filesystem::path& file) {
  return !file.empty() && std::filesystem::exists(file);
}

std::vector<data::Dataset> load_recordings(const RunFolder& folder, std::string (*name)(int),
                                           const std::vector<std::string>& joints) {
  std::vector<data::Dataset> sets;
  for (int i = 0; is_there(folder.recording(name(i))); ++i) {
    const std::filesystem::path file = folder.recording(name(i));
    const data::Dataset& set = sets.emplace_back(data::load_dataset(file));
    if (!joints.empty() && set.joint_names != joints)
      throw UserError("{}: found the joints {}; allowed: those of the robot, {}", file.string(),
                      fmt::join(set.joint_names, ", "), fmt::join(joints, ", "));
  }
  return sets;
}

std::vector<data::Dataset> first_seconds(std::vector<data::Dataset> recordings, double seconds) {
  if (seconds == 0) return recordings;
  std::vector<data::Dataset> first;
  for (data::Dataset& recording : recordings) {
    const double length = recording.length() * recording.dt();
    if (seconds < 2 * recording.dt() && !first.empty()) break;
    first.push_back(data::cut(recording, {"", 0, std::min(seconds, length)}, recording.name));
    seconds -= length;
  }
  return first;
}

}  // namespace fricid::workflow
