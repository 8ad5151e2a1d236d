// What may be called how, and how hostile text is shown, quoted and turned into file names.
#include "fricid/base/names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "fricid/base/error.hpp"
#include "hostile_text.hpp"

namespace fricid {
namespace {

std::string refusal(Named kind, const std::string& name) {
  try {
    require_name(kind, name, "f.toml:3");
  } catch (const UserError& error) {
    return error.what();
  }
  return "allowed";
}

TEST(Names, OfRealRobotsAreAllowed) {
  for (const char* name : {"shoulder_pan_joint", "A1", "joint a1", "iiwa/joint_1", "fr3:joint1",
                           "Link1-1", "J1 (base)", "m/s", "Gelenk_ä", "関節1"})
    EXPECT_EQ(refusal(Named::kJoint, name), "allowed") << name;
  for (const char* name : {"kr6_full", "two joints", "Run 3 (cold)", "v1.2", "_x"})
    EXPECT_EQ(refusal(Named::kScene, name), "allowed") << name;
  for (const char* name : {"lugre", "gms_windows", "sysid-1.0", "oracles"})
    EXPECT_EQ(refusal(Named::kModel, name), "allowed") << name;
  for (const char* name : {"train_0", "validation_0", "log, warm [3]", "20°C"})
    EXPECT_EQ(refusal(Named::kTrajectory, name), "allowed") << name;
}

TEST(Names, ThatBecomeFilesStayInTheirFolder) {
  for (const char* name : {"", ".", "..", ".hidden", "-x", "../x", "/x", "a/b", " x"})
    for (const Named kind : {Named::kScene, Named::kModel, Named::kTrajectory})
      EXPECT_NE(refusal(kind, name), "allowed") << name;
}

TEST(Names, OfTheTruthAreReserved) {
  for (const char* name : {"oracle", "simulator"}) {
    EXPECT_THAT(refusal(Named::kModel, name), ::testing::HasSubstr("stands for the truth"));
    EXPECT_NO_THROW(require_written_name(Named::kModel, name, "f"));
  }
}

TEST(Names, RefusalIsOneLineThatShowsTheText) {
  EXPECT_EQ(
      refusal(Named::kJoint, "a\n\x1b[1m"),
      "f.toml:3: name of a joint = \"a\\n\\x1b[1m\"; allowed: 1 to 100 letters, digits, space "
      "and _ - . ( ) / :, no space at the ends");
  for (const std::string& text : hostile_texts())
    for (const Named kind : {Named::kJoint, Named::kScene, Named::kModel, Named::kTrajectory}) {
      const std::string said = refusal(kind, text);
      EXPECT_EQ(said, printable(said));
      EXPECT_LT(said.size(), 600u);
    }
}

TEST(Names, HostileJointsAndModelsAreRefused) {
  const std::set<std::string> harmless{
      "..",  ".",       "-x",          "--marker",
      "EOD", "/marker", "../../marker"};  // words, where they are no path
  for (const std::string& text : hostile_texts()) {
    if (!harmless.contains(text)) {
      EXPECT_NE(refusal(Named::kJoint, text), "allowed") << text;
    }
    if (text != "EOD") {
      EXPECT_NE(refusal(Named::kModel, text), "allowed") << text;
    }
    if (text != "EOD") {
      EXPECT_NE(refusal(Named::kScene, text), "allowed") << text;
    }
  }
}

TEST(Labels, MayBeAnyTextThatShows) {
  EXPECT_NO_THROW(require_label("5 % \"faster\" | <b>größer</b> `x`", "label", "f"));
  EXPECT_NO_THROW(require_label("", "label", "f"));
  for (const char* label : {"a\nb", "\x1b[31m", "\xff", "\xc2\x9b", "\xe2\x80\xae", "\x7f"})
    EXPECT_THROW(require_label(label, "label", "f"), UserError) << printable(label);
  EXPECT_THROW(require_label(std::string(1001, 'x'), "label", "f"), UserError);
}

TEST(Printable, ShowsEverythingInOneLineAndIsIdempotent) {
  EXPECT_EQ(printable("a\n\t\r\x1b\x7f\xff"), "a\\n\\t\\r\\x1b\\x7f\\xff");
  EXPECT_EQ(printable("\xe2\x80\xae größer 日本 \\"), "\\u{202e} größer 日本 \\");
  EXPECT_EQ(printable("\xc2\x9b\xed\xa0\x80"), "\\u{009b}\\xed\\xa0\\x80");
  for (const std::string& text : hostile_texts()) {
    const std::string shown = printable(text);
    EXPECT_EQ(printable(shown), shown);
    for (const char c : shown) EXPECT_GE(static_cast<unsigned char>(c), 0x20u);
  }
}

TEST(UserErrors, AreOneLineThatShowsWhateverIsInThem) {
  EXPECT_STREQ(UserError("{}: {}", "a\nb", "\x1b]0;t\x07").what(), "a\\nb: \\x1b]0;t\\x07");
}

TEST(FileStem, IsSafeAndDifferentForDifferentNames) {
  EXPECT_EQ(file_stem("friction_joint_a1"), "friction_joint_a1");
  EXPECT_EQ(file_stem("friction_iiwa/joint_1"), "friction_iiwa~2fjoint_1");
  std::vector<std::string> texts = hostile_texts();
  for (const char* name : {"a/b", "a~2fb", "a_b", "a b", "..a", ".a"}) texts.emplace_back(name);
  std::set<std::string> stems;
  for (const std::string& text : texts) {
    const std::string stem = file_stem(text);
    EXPECT_EQ(
        stem.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                               "_-.~"),
        std::string::npos);
    EXPECT_NE(stem.front(), '-');
    EXPECT_NE(stem.front(), '.');
    EXPECT_TRUE(stems.insert(stem).second) << stem;
  }
}

}  // namespace
}  // namespace fricid
