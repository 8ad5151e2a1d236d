#include "fricid/optimise/checkpoint.hpp"

#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "fricid/base/files.hpp"

namespace fricid::optimise {
namespace {

constexpr std::string_view kFormat = "fricid.checkpoint/2";

}  // namespace

Checkpoint::Checkpoint(std::filesystem::path path, std::string key)
    : path_(std::move(path)), key_(std::move(key)) {}

std::optional<Record> Checkpoint::read() const {
  if (path_.empty() || !std::filesystem::exists(path_)) return {};
  const auto root = nlohmann::json::parse(read_file(path_), nullptr, false);
  if (root.is_discarded() || root.value("format", "") != kFormat || root.value("key", "") != key_)
    return {};
  try {
    return Record{root.at("numbers"), root.at("texts")};
  } catch (const nlohmann::json::exception&) {  // a number that was not finite
    return {};
  }
}

void Checkpoint::write(const Record& record) const {
  const nlohmann::json root{
      {"format", kFormat}, {"key", key_}, {"numbers", record.numbers}, {"texts", record.texts}};
  write_file_atomically(path_, root.dump() + "\n");
}

void Checkpoint::remove() const {
  if (path_.empty()) return;
  std::error_code kept;  // what others have put there stays
  std::filesystem::remove(path_, kept);
  std::filesystem::remove(path_.parent_path(), kept);
}

}  // namespace fricid::optimise
