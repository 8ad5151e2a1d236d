// A folder that lives as long as a test. Its name is drawn: tests run beside each other.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

namespace fricid {

/// A new, empty folder under `parent`; removed with the object.
class OwnFolder {
 public:
  explicit OwnFolder(const std::filesystem::path& parent = ::testing::TempDir()) {
    std::string pattern = (parent / "fricid_XXXXXX").string();
    if (!::mkdtemp(pattern.data()))
      throw std::system_error(errno, std::generic_category(), "mkdtemp " + pattern);
    path_ = pattern;
  }
  ~OwnFolder() { std::filesystem::remove_all(path_); }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

class TemporaryFolder : public ::testing::Test {
 protected:
  explicit TemporaryFolder(const std::filesystem::path& parent = ::testing::TempDir())
      : own_(parent), folder(own_.path()) {}

 private:
  OwnFolder own_;

 protected:
  const std::filesystem::path folder;
};

}  // namespace fricid
