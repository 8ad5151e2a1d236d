// docs/friction_laws.md shows the table of laws as it is. To write it anew: build the target
// law_docs.
#include "law_docs.hpp"
#include "source_dir.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace fricid::friction::test {
namespace {

TEST(LawDocs, PageEqualsTheTable) {
  std::ifstream file(source_dir() / kLawDocsPage);
  ASSERT_TRUE(file) << kLawDocsPage;
  std::ostringstream page;
  page << file.rdbuf();
  EXPECT_NE(page.str().find(law_docs()), std::string::npos)
      << "build the target law_docs to write the page anew";
}

TEST(LawDocs, ReplaceWhatStandsBetweenTheMarks) {
  const std::string begin = "<!-- from the table: begin -->\n",
                    end = "<!-- from the table: end -->";
  EXPECT_EQ(with_law_docs("a\n" + begin + "old" + end + "\nb"),
            "a\n" + begin + law_docs() + end + "\nb");
  EXPECT_EQ(with_law_docs("no marks"), "no marks");
}

}  // namespace
}  // namespace fricid::friction::test
