#include "outputs.hpp"

#include "fricid/base/error.hpp"

namespace fricid::cli {

namespace fs = std::filesystem;

void require_not_input(std::string_view option, const fs::path& output,
                       const std::vector<fs::path>& inputs) {
  if (output.empty()) return;
  for (const fs::path& input : inputs)
    if (!input.empty() && fs::weakly_canonical(output) == fs::weakly_canonical(input))
      throw UserError("{} {}: would replace {}; allowed: another name", option, output.string(),
                      input.string());
}

}  // namespace fricid::cli
