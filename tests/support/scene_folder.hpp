// A folder per test, a small robot, and messages without the folder's name.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>

#include "fricid/base/error.hpp"
#include "temporary_folder.hpp"

namespace fricid {

/// Two revolute joints in a vertical plane, and a fixed tool frame.
inline constexpr char kArmUrdf[] = R"(<?xml version="1.0"?>
<robot name="two_link">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.2 0 0"/>
      <mass value="4"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.06"/>
    </inertial>
  </link>
  <link name="lower">
    <inertial>
      <origin xyz="0.15 0 0"/>
      <mass value="2"/>
      <inertia ixx="0.005" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>
    </inertial>
  </link>
  <link name="flange"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="4" effort="80"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-2.5" upper="2.5" velocity="5" effort="40"/>
  </joint>
  <joint name="flange_joint" type="fixed">
    <parent link="lower"/><child link="flange"/><origin xyz="0.3 0 0"/>
  </joint>
</robot>
)";

/// The shortest scene for it.
inline constexpr char kScene[] = R"(
[robot]
urdf = "arm.urdf"
mjcf = "arm.xml"

[friction]
[[friction.law]]
law = "coulomb_viscous"
Fc = 3
Fv = [1.0, 0.5]
v0 = 0.01
)";

/// A folder that is removed with the test. Holds arm.urdf and an empty arm.xml.
class FolderTest : public TemporaryFolder {
 protected:
  // Thousands of small files: in memory where the system offers it.
  FolderTest()
      : TemporaryFolder(std::filesystem::is_directory("/dev/shm") ? "/dev/shm"
                                                                  : testing::TempDir()) {
    write("arm.urdf", kArmUrdf);
    write("arm.xml", "<mujoco/>");
  }

  std::filesystem::path path(const std::string& name) const { return folder / name; }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(path(name).parent_path());
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
  }

  std::string read(const std::string& name) const {
    std::stringstream text;
    text << std::ifstream(path(name), std::ios::binary).rdbuf();
    return text.str();
  }

  /// Message of the UserError that `body` throws, with the folder's name cut out.
  std::string message_of(const std::function<void()>& body) const {
    try {
      body();
    } catch (const UserError& error) {
      std::string message = error.what();
      for (const std::string& name : {folder.string() + "/", folder.string()})
        for (std::size_t at; (at = message.find(name)) != std::string::npos;)
          message.erase(at, name.size());
      return message;
    }
    return "no error";
  }
};

/// `text` with the first `from` replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace fricid
