#include "fricid/estimate/checkpoint.hpp"

#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "fricid/base/files.hpp"

namespace fricid::estimate {
namespace {

constexpr std::string_view kFormat = "fricid.checkpoint/1";

}  // namespace

Checkpoint::Checkpoint(std::filesystem::path path, std::string key)
    : path_(std::move(path)), key_(std::move(key)) {}

std::optional<FitState> Checkpoint::load() const {
  if (path_.empty() || !std::filesystem::exists(path_)) return {};
  const auto root = nlohmann::json::parse(read_file(path_), nullptr, false);
  if (root.is_discarded() || root.value("format", "") != kFormat || root.value("key", "") != key_)
    return {};
  try {
    return FitState{root.at("iteration"), root.at("numbers"), root.at("warnings")};
  } catch (const nlohmann::json::exception&) {  // a number that was not finite
    return {};
  }
}

void Checkpoint::save(const FitState& state) const {
  if (path_.empty()) return;
  const nlohmann::json root{{"format", kFormat},
                            {"key", key_},
                            {"iteration", state.iteration},
                            {"numbers", state.numbers},
                            {"warnings", state.warnings}};
  write_file_atomically(path_, root.dump() + "\n");
}

void Checkpoint::remove() const {
  if (path_.empty()) return;
  std::error_code kept;  // what others have put there stays
  std::filesystem::remove(path_, kept);
  std::filesystem::remove(path_.parent_path(), kept);
}

}  // namespace fricid::estimate
