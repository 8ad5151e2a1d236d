#include "outputs.hpp"

#include "fricid/base/error.hpp"
#include "fricid/data/log_part.hpp"

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

}  // namespace fricid::cli
