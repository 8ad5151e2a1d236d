#include "source_dir.hpp"

namespace fricid {

std::filesystem::path source_dir() { return FRICID_SOURCE_DIR; }

}  // namespace fricid
