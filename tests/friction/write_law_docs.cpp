// write_law_docs PAGE: writes the tables of laws and modifiers into the page.
#include <cstdio>
#include <fstream>
#include <sstream>

#include "law_docs.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: write_law_docs PAGE\n", stderr);
    return 2;
  }
  std::ostringstream page;
  std::ifstream in(argv[1]);
  page << in.rdbuf();
  std::ofstream out(argv[1]);
  out << fricid::friction::test::with_law_docs(page.str());
  return in && out.flush() ? 0 : 1;
}
