// Zip archives, uncompressed.
#pragma once

#include <span>
#include <string>

#include "fricid/deploy/export.hpp"

namespace fricid::deploy {

/// The files as a zip archive: stored as they are, dated 1980-01-01, so that equal files give equal
/// bytes. @see PKWARE, .ZIP File Format Specification 6.3.10
std::string zip(std::span<const TextFile> files);

}  // namespace fricid::deploy
