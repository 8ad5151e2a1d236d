// A folder that lives as long as a test.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace fricid {

class TemporaryFolder : public ::testing::Test {
 protected:
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) /
      (std::string("fricid_") +
       ::testing::UnitTest::GetInstance()->current_test_info()->test_suite_name() + "_" +
       ::testing::UnitTest::GetInstance()->current_test_info()->name());
  void SetUp() override { std::filesystem::remove_all(folder); }
  void TearDown() override { std::filesystem::remove_all(folder); }
};

}  // namespace fricid
