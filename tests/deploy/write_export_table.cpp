// Prints every law and modifier with the largest error of its exported header, as Markdown.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "law_errors.hpp"

int main() {
  using namespace fricid::deploy::test;
  const auto models = all_models();
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("fricid_export_{}", getpid());
  const std::string compiler = c_compilers().front();
  const auto as_double = header_errors(models, compiler, "", folder);
  const auto as_float = header_errors(models, compiler, "-DFRICID_FLOAT", folder);
  std::filesystem::remove_all(folder);
  fmt::print(
      "| law or modifier | parameters | states | c, double | c, float |\n|---|---|---|---|---|\n");
  for (std::size_t i = 0; i < models.size(); ++i)
    fmt::print("| {} | {} | {} | {:.1e} | {:.1e} |\n", models[i].name,
               models[i].arm.friction.model.parameter_count(),
               models[i].arm.friction.model.state_size(), as_double[i], as_float[i]);
}
