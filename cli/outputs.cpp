#include "outputs.hpp"

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/log_part.hpp"
#include "terminal.hpp"

namespace fricid::cli {

namespace fs = std::filesystem;

void require_not_input(std::string_view option, const fs::path& output,
                       const std::vector<fs::path>& inputs) {
  if (output.empty()) return;
  for (const fs::path& input : inputs)
    for (const fs::path& file : {input, fs::path(data::log_part(input.string()).file)})
      if (!file.empty() && fs::weakly_canonical(output) == fs::weakly_canonical(file))
        throw UserError("{} {}: would replace {}; allowed: another name", option, output.string(),
                        file.string());
}

void require_like(std::string_view option, const fs::path& output, std::string_view format) {
  const auto kind_of = [](std::string_view of) { return of.substr(0, of.find('/')); };
  if (output.empty() || !fs::is_regular_file(output) || fs::file_size(output) == 0) return;
  for (const auto& read : {data::format_of, data::hdf5_format}) try {
      if (kind_of(read(output)) == kind_of(format)) return;
    } catch (const UserError&) {  // not such a file
    }
  throw UserError("{} {}: would replace a file that is no {}; allowed: another name", option,
                  output.string(), kind_of(format));
}

void require_no_robot(const workflow::RobotOfLog& robot, const fs::path& run) {
  const workflow::RobotOfLog none;
  if (!robot.urdf.empty() || robot.mount != none.mount || robot.mend_inertia != none.mend_inertia)
    throw UserError("{}: a run with --robot, --mount or --mend-inertia; allowed: its own robot",
                    run.string());
}

void say_doubts(const data::ModelFile& model) {
  for (const std::string& doubt : model.doubts)
    print(fmt::format("model {} is not to be trusted: {}\n", model.name, doubt), stderr);
}

}  // namespace fricid::cli
