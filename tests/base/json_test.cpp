#include "fricid/base/json.hpp"

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"

namespace fricid {
namespace {

std::string error_of(std::string_view text) {
  try {
    parse_json(text, "bad.json");
  } catch (const UserError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Json, ReadsWhatItShould) {
  EXPECT_EQ(parse_json(R"({"a": [1, null, "b"]})", "good.json")["a"].size(), 3u);
  EXPECT_EQ(parse_json<nlohmann::ordered_json>(R"({"b": 1, "a": 2})", "good.json").dump(),
            R"({"b":1,"a":2})");
}

TEST(Json, SaysFileLineAndReason) {
  EXPECT_EQ(error_of(""), "bad.json:1: not JSON, or torn: unexpected end of input");
  EXPECT_EQ(error_of("{\n\"a\":\n nope}"), "bad.json:3: not JSON, or torn: invalid literal nope");
  EXPECT_EQ(error_of("[NaN]"), "bad.json:1: not JSON, or torn: invalid literal NaN");
  EXPECT_EQ(error_of("[-Infinity]").find("bad.json:1: not JSON, or torn: invalid number"), 0);
  EXPECT_EQ(error_of("[n\x1b"), "bad.json:1: not JSON, or torn: invalid literal n");
  EXPECT_EQ(error_of("{} {}"), "bad.json:1: not JSON, or torn: unexpected '{'");
}

TEST(Json, RefusesNumbersThatADoubleDoesNotHold) {
  EXPECT_EQ(error_of("[1e400]"), "bad.json: not JSON: number overflow parsing '1e400'");
}

// Deeper trees would overflow the stack of whatever walks them.
TEST(Json, RefusesDeepNesting) {
  const auto nested = [](std::size_t levels) {
    return std::string(levels, '[') + std::string(levels, ']');
  };
  EXPECT_EQ(error_of(nested(32)), "accepted");
  for (const std::size_t levels : {33, 1'000'000})
    EXPECT_EQ(error_of(nested(levels)),
              "bad.json: 33 levels of lists and objects in a JSON file; allowed: up to 32");
}

}  // namespace
}  // namespace fricid
