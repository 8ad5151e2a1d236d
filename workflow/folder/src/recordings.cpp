#include "fricid/workflow/recordings.hpp"

namespace fricid::workflow {

bool is_there(const std::filesystem::path& file) {
  return !file.empty() && std::filesystem::exists(file);
}

std::vector<data::Dataset> load_recordings(const RunFolder& folder, std::string (*name)(int)) {
  std::vector<data::Dataset> sets;
  for (int i = 0; is_there(folder.recording(name(i))); ++i)
    sets.push_back(data::load_dataset(folder.recording(name(i))));
  return sets;
}

}  // namespace fricid::workflow
