// A folder per test with a small robot, and messages without the folder's name.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>

#include "fricid/base/error.hpp"
#include "temporary_folder.hpp"
#include "two_link_arm.hpp"

namespace fricid {

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
