// What reaches a terminal shows: it moves no cursor, and changes no colour and no direction.
#include "terminal.hpp"

#include <gtest/gtest.h>

namespace fricid::cli {
namespace {

TEST(Terminal, LinesStayAndControlCharactersAreSeen) {
  for (const char* plain : {"", "a\n", "a\tb\n\nc", "größer – 日本\n"})
    EXPECT_EQ(visible_lines(plain), plain);
  EXPECT_EQ(visible_lines("a\x1b[31m\nb\r\n\xc2\x9b\xff\x7f"),
            "a\\x1b[31m\nb\\r\n\\u{009b}\\xff\\x7f");
  EXPECT_EQ(visible_lines("\xe2\x80\xae\n"), "\\u{202e}\n");
}

TEST(Terminal, JsonStaysJson) {
  EXPECT_EQ(visible_json("{\"a\": \"größer\"}\n"), "{\"a\": \"größer\"}\n");
  const std::string hostile = "{\"b\": \"ä\xe2\x80\xae\x7f\xc2\x9b\", \"a\": 0.1}";
  const std::string shown = visible_json(hostile);
  EXPECT_EQ(visible_lines(shown), shown);
  EXPECT_EQ(nlohmann::json::parse(shown), nlohmann::json::parse(hostile));
  EXPECT_LT(shown.find("\"b\""), shown.find("\"a\""));
}

}  // namespace
}  // namespace fricid::cli
