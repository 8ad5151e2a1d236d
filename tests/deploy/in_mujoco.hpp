// Exported MJCF, loaded by MuJoCo.
#pragma once

#include <array>

#include "fricid/base/error.hpp"
#include "fricid/deploy/export.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "temporary_folder.hpp"

namespace fricid::deploy::test {

/// Writes the export and loads the last of its files, the MJCF.
inline sim::MjModelPtr in_mujoco(const Exported& exported) {
  sim::initialise_mujoco();
  const OwnFolder folder;
  save(exported, folder.path());
  std::array<char, 1000> error{};
  sim::MjModelPtr m(mj_loadXML((folder.path() / exported.files.back().name).c_str(), nullptr,
                               error.data(), static_cast<int>(error.size())));
  if (!m) throw UserError("{}", error.data());
  return m;
}

}  // namespace fricid::deploy::test
