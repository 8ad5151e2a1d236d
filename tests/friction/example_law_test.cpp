// The worked example of docs/add_a_friction_law.md: the law it shows compiles, passes the suite,
// and is quoted as it stands here.
#include "example_law.hpp"

#include <fstream>
#include <sstream>

#include "gradient_checks.hpp"
#include "law_checks.hpp"
#include "source_dir.hpp"

namespace fricid::friction::test {

// [suite]
TEST(ExampleLaw, PassesTheSuite) {
  static_assert(FrictionLaw<ViscousBristle>);
  check_all(LawSubject(ViscousBristle{}));
}
// [suite]

namespace {

std::string read(const std::string& path) {
  std::ifstream file(source_dir() / path);
  EXPECT_TRUE(file) << path;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(ExampleLaw, IsQuotedInTheDocs) {
  const std::string docs = read("docs/add_a_friction_law.md");
  const std::string law = read("tests/friction/example_law.hpp");
  EXPECT_NE(docs.find("```cpp\n" + law + "```"), std::string::npos)
      << "docs/add_a_friction_law.md does not quote tests/friction/example_law.hpp";

  const std::string test = read("tests/friction/example_law_test.cpp");
  const std::string mark = "// [suite]\n";
  const auto begin = test.find(mark) + mark.size();
  const std::string suite = test.substr(begin, test.find(mark, begin) - begin);
  EXPECT_NE(docs.find("```cpp\n" + suite + "```"), std::string::npos)
      << "docs/add_a_friction_law.md does not quote the test of the example";
}

}  // namespace
}  // namespace fricid::friction::test
