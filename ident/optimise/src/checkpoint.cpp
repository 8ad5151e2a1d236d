#include "fricid/optimise/checkpoint.hpp"

#include <string_view>
#include <system_error>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/json.hpp"

namespace fricid::optimise {
namespace {

constexpr std::string_view kFormat = "fricid.checkpoint/2";

}  // namespace

Checkpoint::Checkpoint(std::filesystem::path path, std::string key)
    : path_(std::move(path)), key_(std::move(key)) {}

std::optional<Record> Checkpoint::read() const {
  if (path_.empty() || !std::filesystem::exists(path_)) return {};
  const std::string text = read_file(path_);
  try {
    const auto root = parse_json(text, path_.string());
    if (root.at("format") != kFormat || root.at("key") != key_) return {};
    return Record{root.at("numbers"), root.at("texts")};
  } catch (const UserError&) {
    return {};
  } catch (const nlohmann::json::exception&) {  // of other types, or a number that was not finite
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
  std::error_code kept;  // a folder with other files stays
  std::filesystem::remove(path_, kept);
  std::filesystem::remove(path_.parent_path(), kept);
}

}  // namespace fricid::optimise
