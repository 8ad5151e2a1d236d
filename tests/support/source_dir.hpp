// Where the sources are. A function, so that the object code of a test is the same in every
// checkout.
#pragma once

#include <filesystem>

namespace fricid {

std::filesystem::path source_dir();

}  // namespace fricid
