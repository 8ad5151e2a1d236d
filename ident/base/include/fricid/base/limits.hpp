// Upper limits on the sizes of files and the values of options. docs/limits.md shows this table.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace fricid {

struct Limit {
  std::string_view what;  ///< the limited quantity, in the words of messages and documentation
  std::uint64_t most;
};

namespace limits {

inline constexpr Limit kTextBytes{"bytes of a scene, contract, URDF or JSON file", 268'435'456};
inline constexpr Limit kJsonLevels{"levels of lists and objects in a JSON file", 32};
inline constexpr Limit kTomlLevels{"levels of one key or one value in a TOML file", 32};
inline constexpr Limit kSceneFiles{"files read for one scene, by extends", 64};
inline constexpr Limit kLinks{"links of a URDF", 1000};
inline constexpr Limit kJoints{"joints of a model", 1000};
inline constexpr Limit kNameBytes{"bytes of a name", 100};
inline constexpr Limit kLabelBytes{"bytes of a label or a description", 1000};
inline constexpr Limit kTables{"tables of an HDF5 or MAT file", 10'000};
inline constexpr Limit kColumns{"columns in all tables of an HDF5 or MAT file", 100'000};
inline constexpr Limit kHdf5AttributeValues{"values of an attribute of an HDF5 file", 100'000};
inline constexpr Limit kMatLevels{"levels of structures in a MAT file", 32};
inline constexpr Limit kChunkBytes{"bytes in one chunk of an MCAP file", 1'073'741'824};
inline constexpr Limit kMcapBytes{"bytes in all chunks of an MCAP file", 17'179'869'184};
inline constexpr Limit kBagMessageBytes{"bytes in one message of a bag (.db3)", 16'777'216};
inline constexpr Limit kFilledSamples{"samples of a log after its gaps are filled", 50'000'000};
inline constexpr Limit kSeed{"the seed of a scene or a filter", 9'000'000'000'000'000};
inline constexpr Limit kFitSeed{"the seed of a fit", 1'000'000'000};
inline constexpr Limit kFitSeeds{"seeds in one --seeds", 1000};

}  // namespace limits

/// All limits, in the order of the documentation.
std::span<const Limit> all_limits();

/// @throws UserError "WHERE: FOUND WHAT; allowed: up to MOST"
void require_within(const Limit& limit, std::uint64_t found, std::string_view where);

/// Bytes that one task may use: half of the free memory. Free memory is the smallest of what the
/// machine, the control group and the address-space limit of the process leave.
double memory_budget();

/// Check before the task starts. @param bytes  estimated peak memory of the task
/// @throws UserError "WHERE: WHAT would take 37.2 GB of memory; allowed: 10.4 GB, half of what is
/// free" if that is more than memory_budget()
void require_memory(double bytes, std::string_view where, std::string_view what);

}  // namespace fricid
