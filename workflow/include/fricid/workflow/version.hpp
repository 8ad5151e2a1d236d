#pragma once

namespace fricid {

/// Version of the project, as 1.2.3.
extern const char* const kVersion;

/// Commit of the sources, with "-dirty" where they differ from it; "unknown" outside of a checkout.
extern const char* const kCommit;

}  // namespace fricid
