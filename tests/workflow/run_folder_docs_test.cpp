// docs/run_folder.md shows the structs as they are. To write it anew: build the target
// run_folder_docs.
#include <gtest/gtest.h>

#include "fricid/base/files.hpp"
#include "run_folder_docs.hpp"
#include "source_dir.hpp"

namespace fricid {
namespace {

TEST(RunFolderDocs, AreThoseOfTheStructs) {
  EXPECT_EQ(read_file(source_dir() / kRunFolderPage), run_folder_page());
}

}  // namespace
}  // namespace fricid
