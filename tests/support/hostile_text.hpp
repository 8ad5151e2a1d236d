// Texts that try to become code, a path or markup. Each names the file it would make, "marker".
#pragma once

#include <string>
#include <vector>

namespace fricid {

inline std::vector<std::string> hostile_texts() {
  using namespace std::string_literals;
  std::vector<std::string> texts{"a\nsystem('touch marker')\n#",
                                 "a\r\nset print '| touch marker'",
                                 "'; system('touch marker'); '",
                                 "\"; system('touch marker'); \"",
                                 "''\"\"'",
                                 "`touch marker`",
                                 "$(touch marker)",
                                 "| touch marker",
                                 "< touch marker",
                                 "@ARG0 @marker",
                                 "100 %d %s %n",
                                 "../../marker",
                                 "/marker",
                                 "..",
                                 ".",
                                 "-x",
                                 "--marker",
                                 "EOD",
                                 "\nEOD\nsystem('touch marker')",
                                 "ends with \\",
                                 "{/Bold x} ^2 _3",
                                 "<b>&amp;</b>",
                                 "</script><script>alert(1)</script>",
                                 "]]>",
                                 "a | b ` [c](d) <i>",
                                 "\x1b]0;title\x07\x1b[31mred",
                                 "tab\tbell\a",
                                 "\xc2\x9b"
                                 "31m",              // a control sequence in one character
                                 "\xe2\x80\xaegnp",  // turns the direction of writing
                                 "bad \xff\xfe bytes \xc3",
                                 "\xed\xa0\x80",  // a surrogate
                                 "\xc0\xaf",      // an overlong /
                                 "zero \0 byte"s,
                                 std::string(300, 'x')};
  return texts;
}

}  // namespace fricid
