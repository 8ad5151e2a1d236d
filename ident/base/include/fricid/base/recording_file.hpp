#pragma once

#include <filesystem>
#include <string>

namespace fricid {

/// Whole content of a recording of up to memory_budget() bytes. @throws UserError as read_file
std::string read_recording(const std::filesystem::path& path);

}  // namespace fricid
