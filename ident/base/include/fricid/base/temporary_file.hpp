#pragma once

#include <filesystem>

namespace fricid {

/// Where to write a file that is to become `path`: ".NAME.PID.COUNT.fricid.tmp" beside it, another
/// at every call. What a killed writer leaves is found by remove_left_temporaries (files.hpp).
std::filesystem::path temporary_beside(const std::filesystem::path& path);

}  // namespace fricid
