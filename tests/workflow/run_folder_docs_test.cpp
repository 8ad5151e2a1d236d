// docs/run_folder.md shows the structs as they are. To write it anew: build the target
// run_folder_docs.
#include <gtest/gtest.h>

#include "fricid/base/files.hpp"
#include "run_folder_docs.hpp"

namespace fricid {
namespace {

TEST(RunFolderDocs, AreThoseOfTheStructs) {
  EXPECT_EQ(read_file(std::string(FRICID_SOURCE_DIR) + "/" + kRunFolderPage), run_folder_page());
}

}  // namespace
}  // namespace fricid
