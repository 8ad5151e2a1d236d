// The archives that write and read artefacts, on an artefact with a field of every type.
#include "fricid/data/artefact.hpp"

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "fricid/base/files.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/data/diagnosis_file.hpp"
#include "fricid/data/fit_file.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

static_assert(name_of(Outcome::kFailed) == "failed");
static_assert(name_of(Severity::kDamage) == "damage");

enum class Colour { kRed, kDarkBlue };
constexpr std::string_view names(Colour) { return "red|dark blue"; }

struct Range {
  double low, high;
};

struct Part {
  double x = 0;
  std::vector<double> list;

  template <class Archive>
  void visit(Archive& archive) {
    archive("x", x, number("m", -1e300, 1e300, "a length"));
    archive("list", list, number("m", -1e300, 1e300, "lengths"));
  }
};

struct Sample {
  static constexpr std::string_view kFormat = "fricid.sample/1";

  double real = 0;
  int whole = 0;
  std::uint64_t large = 0;
  bool yes = false;
  std::string words, word = "left";
  Colour colour = Colour::kRed;
  std::vector<double> reals;
  std::vector<int> wholes;
  std::vector<std::string> texts;
  std::vector<std::vector<double>> lists;
  Eigen::VectorXd vector;
  Eigen::MatrixXd matrix;
  std::vector<Range> ranges;
  Part part;
  std::optional<Part> maybe;
  std::vector<Part> parts;
  double sure = 1;
  std::vector<double> sures;
  int count = 1;
  Eigen::Vector3d three = Eigen::Vector3d::Zero();
  Eigen::Matrix3d nine = Eigen::Matrix3d::Identity();
  std::optional<int> number_or_none;
  std::vector<std::vector<Part>> groups;
  std::vector<std::pair<std::string, Part>> by_name;

  double twice() const { return 2 * real; }
  void check(const std::string& place) const {
    if (whole == 13) throw UserError("{}: whole = 13; allowed: another number", place);
  }

  template <class Archive>
  void visit(Archive& archive) {
    const Field field = number("1", -1e300, 1e300, "a number");
    archive("real", real, field);
    archive("whole", whole, field);
    archive("large", large, field);
    archive("yes", yes, flag("or no"));
    archive("words", words, text("any"));
    archive("word", word, choice("left|right", "a side"));
    archive("colour", colour, choice("of two"));
    archive("reals", reals, field);
    archive("wholes", wholes, field);
    archive("texts", texts, text("several"));
    archive("lists", lists, field);
    archive("vector", vector, field);
    archive("matrix", matrix, field);
    archive.pairs("ranges", ranges, field);
    archive.section("part", part, "one");
    archive.section("maybe", maybe, "one or none");
    archive.sections("parts", parts, "several");
    archive("sure", sure, required(number("kg", 0, 10, "always there")));
    archive("sures", sures, required(number("kg", 0, 10, "always there")));
    archive("count", count, required(number("", 1, 3, "few")));
    archive("three", three, field);
    archive("nine", nine, field);
    archive("number_or_none", number_or_none, field);
    archive.lists("groups", groups, "several of several");
    archive.named("by_name", "NAME", by_name, "several with names");
    archive.derived("twice", twice(), field);
  }
};

/// Numbers that a careless writer loses.
const std::vector<double> kHard{0.1,
                                1.0 / 3,
                                -0.0,
                                5e-324,
                                std::numeric_limits<double>::max(),
                                -123456789.123456789,
                                std::nextafter(1.0, 2.0)};

Sample full() {
  Sample sample;
  sample.real = 1.0 / 7;
  sample.whole = -7;
  sample.large = 9'007'199'254'740'993;  // beyond what a double holds
  sample.yes = true;
  sample.words = "Äll \"kinds\" of\nwords \\";
  sample.word = "right";
  sample.colour = Colour::kDarkBlue;
  sample.reals = kHard;
  sample.wholes = {std::numeric_limits<int>::min(), std::numeric_limits<int>::max()};
  sample.texts = {"", "b"};
  sample.lists = {{}, {1, 2}};
  sample.vector = Eigen::VectorXd::Map(kHard.data(), std::ssize(kHard));
  sample.matrix = Eigen::MatrixXd::Constant(2, 3, 0.1);
  sample.matrix(1, 0) = 1.0 / 3;
  sample.ranges = {{-1, 2}, {kNan, kNan}};
  sample.part = {0.3, {4}};
  sample.maybe = Part{0.7, {}};
  sample.parts = {{1, {}}, {2, {0.1}}};
  sample.sure = 0.1;
  sample.sures = {0, 10, 1.0 / 3};
  sample.count = 3;
  sample.three = {0.1, -0.0, 3};
  sample.nine(0, 2) = 1.0 / 3;
  sample.number_or_none = 4;
  sample.groups = {{}, {{5, {}}, {6, {0.5}}}};
  sample.by_name = {{"z", {7, {}}}, {"a", {8, {}}}};
  return sample;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return std::ranges::equal(a, b, [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

class ArtefactTest : public FolderTest {
 protected:
  const std::filesystem::path file = path("a.json");

  ArtefactTest() { save(full(), file); }

  Sample loaded() const { return load<Sample>(file); }
  Json json() const { return Json::parse(read("a.json")); }
  /// What is said of the sample with another value at a place; "no error" when nothing is.
  std::string said_of(const std::string& pointer, const Json& value) const {
    Json changed = json();
    changed[Json::json_pointer(pointer)] = value;
    return said_of_text(changed.dump());
  }
  std::string said_of_text(const std::string& text) const {
    write("b.json", text);
    return message_of([&] { load<Sample>(path("b.json")); });
  }
};

TEST_F(ArtefactTest, ComesBackToTheLastBit) {
  const Sample before = full(), after = loaded();
  EXPECT_EQ(after.real, before.real);
  EXPECT_EQ(after.whole, before.whole);
  EXPECT_EQ(after.large, before.large);
  EXPECT_EQ(after.yes, before.yes);
  EXPECT_EQ(after.words, before.words);
  EXPECT_EQ(after.word, before.word);
  EXPECT_EQ(after.colour, before.colour);
  EXPECT_TRUE(same_bits(after.reals, before.reals));
  EXPECT_EQ(after.wholes, before.wholes);
  EXPECT_EQ(after.texts, before.texts);
  EXPECT_EQ(after.lists, before.lists);
  EXPECT_EQ(after.vector, before.vector);
  EXPECT_EQ(after.matrix, before.matrix);
  ASSERT_EQ(after.ranges.size(), 2u);
  EXPECT_EQ(after.ranges[0].low, -1);
  EXPECT_EQ(after.ranges[0].high, 2);
  EXPECT_EQ(after.part.x, 0.3);
  EXPECT_EQ(after.part.list, (std::vector<double>{4}));
  ASSERT_TRUE(after.maybe);
  EXPECT_EQ(after.maybe->x, 0.7);
  ASSERT_EQ(after.parts.size(), 2u);
  EXPECT_EQ(after.parts[1].list, (std::vector<double>{0.1}));
  EXPECT_EQ(after.sure, 0.1);
  EXPECT_TRUE(same_bits(after.sures, before.sures));
  EXPECT_EQ(after.count, 3);
  EXPECT_EQ(after.three, before.three);
  EXPECT_EQ(after.nine, before.nine);
  EXPECT_EQ(after.number_or_none, 4);
  ASSERT_EQ(after.groups.size(), 2u);
  EXPECT_TRUE(after.groups[0].empty());
  EXPECT_EQ(after.groups[1][1].list, (std::vector<double>{0.5}));
  ASSERT_EQ(after.by_name.size(), 2u);  // in the order of the file
  EXPECT_EQ(after.by_name[0].first, "z");
  EXPECT_EQ(after.by_name[1].second.x, 8);
  // and is written the same again
  EXPECT_EQ(to_json(after), read("a.json"));
  EXPECT_EQ(to_json(before), read("a.json"));
}

TEST_F(ArtefactTest, NamesItsFormatFirst) {
  EXPECT_THAT(read("a.json"), StartsWith("{\n \"format\": \"fricid.sample/1\",\n \"real\":"));
  EXPECT_EQ(format_of(file), "fricid.sample/1");
  EXPECT_EQ(json().at("twice"), 2.0 / 7);
}

TEST_F(ArtefactTest, WhatIsNotFiniteIsNullAndComesBackAsNaN) {
  Sample sample = full();
  sample.real = kNan;
  sample.reals = {INFINITY, 1, -INFINITY};
  sample.vector = Eigen::VectorXd::Constant(1, kNan);
  sample.matrix(0, 1) = kNan;
  save(sample, file);
  EXPECT_TRUE(json().at("real").is_null());
  EXPECT_EQ(json().at("reals"), Json::parse("[null, 1.0, null]"));
  const Sample after = loaded();
  EXPECT_TRUE(std::isnan(after.real));
  EXPECT_TRUE(std::isnan(after.reals[0]) && std::isnan(after.reals[2]));
  EXPECT_EQ(after.reals[1], 1);
  EXPECT_TRUE(std::isnan(after.vector[0]));
  EXPECT_TRUE(std::isnan(after.matrix(0, 1)));
  EXPECT_TRUE(std::isnan(after.ranges[1].low));
}

TEST_F(ArtefactTest, APartThatIsNotThereIsLeftOut) {
  Sample sample = full();
  sample.maybe.reset();
  save(sample, file);
  EXPECT_FALSE(json().contains("maybe"));
  EXPECT_FALSE(loaded().maybe);
}

TEST_F(ArtefactTest, ANumberThatIsNotThereIsLeftOut) {
  Sample sample = full();
  sample.number_or_none.reset();
  save(sample, file);
  EXPECT_FALSE(json().contains("number_or_none"));
  EXPECT_FALSE(loaded().number_or_none);
}

TEST_F(ArtefactTest, RequiredNumbersAreFiniteAndWithinTheirBounds) {
  for (const double wrong : {kNan, std::numeric_limits<double>::infinity()}) {
    Sample sample = full();
    sample.sures[1] = wrong;
    EXPECT_EQ(message_of([&] { save(sample, path("c.json")); }),
              fmt::format("c.json: sures: found {}; allowed: finite", wrong));
    EXPECT_FALSE(std::filesystem::exists(path("c.json")));
  }
  EXPECT_EQ(said_of("/sure", nullptr), "b.json: sure: found null; allowed: a number");
  EXPECT_EQ(said_of("/sure", -0.5), "b.json: sure: found -0.5; allowed: 0 to 10");
  EXPECT_EQ(said_of("/sures/2", 10.5), "b.json: sures: found 10.5; allowed: 0 to 10");
  EXPECT_THAT(said_of("/sures/2", nullptr), HasSubstr("allowed: a number"));
  EXPECT_EQ(said_of("/count", 4), "b.json: count: found 4; allowed: 1 to 3");
  EXPECT_EQ(said_of("/real", -1e301), "no error");  // bounds of the others are documentation
}

TEST_F(ArtefactTest, ListsOfListsAndNamedPartsSayWhereTheyAre) {
  EXPECT_EQ(said_of("/groups/1/1/x", "long"),
            "b.json: groups[1][1].x: found \"long\"; allowed: a number or null");
  EXPECT_EQ(said_of("/groups/1/1", 3), "b.json: groups: found a list; allowed: lists of objects");
  EXPECT_EQ(said_of("/groups/0", 3), "b.json: groups: found a list; allowed: lists of objects");
  EXPECT_EQ(said_of("/by_name/a/x", "long"),
            "b.json: by_name.a.x: found \"long\"; allowed: a number or null");
  EXPECT_EQ(said_of("/by_name/a", 3),
            "b.json: by_name: found an object; allowed: an object of objects");
}

TEST_F(ArtefactTest, FixedSizesAreKept) {
  EXPECT_EQ(said_of("/three", {1, 2}), "b.json: three: found a list; allowed: 3 numbers");
  EXPECT_EQ(said_of("/nine", {{1, 2, 3}, {4, 5, 6}}),
            "b.json: nine: found a list; allowed: 3 rows of 3 numbers");
}

TEST_F(ArtefactTest, EmptyListsAndMatricesComeBackEmpty) {
  save(Sample(), file);
  const Sample after = loaded();
  EXPECT_TRUE(after.reals.empty() && after.texts.empty() && after.parts.empty());
  EXPECT_EQ(after.vector.size(), 0);
  EXPECT_EQ(after.matrix.size(), 0);
}

TEST_F(ArtefactTest, UnknownKeysArePassedOver) {
  EXPECT_EQ(said_of("/of_a_later_version", {1, "x"}), "no error");
  EXPECT_EQ(said_of("/parts/0/of_a_later_version", nullptr), "no error");
  // what follows from other fields is not read
  EXPECT_EQ(said_of("/twice", "nonsense"), "no error");
}

TEST_F(ArtefactTest, EveryFieldMustBeThere) {
  const Json whole = json();
  for (const auto& [key, value] : whole.items()) {
    if (key == "format" || key == "maybe" || key == "twice" || key == "number_or_none") continue;
    Json without = whole;
    without.erase(key);
    EXPECT_EQ(said_of_text(without.dump()), "b.json: found no " + key);
  }
  Json without = whole;
  without["parts"][1].erase("x");
  EXPECT_EQ(said_of_text(without.dump()), "b.json: found no parts[1].x");
}

TEST_F(ArtefactTest, EveryFieldMustBeOfItsType) {
  const Json whole = json();
  for (const auto& [key, value] : whole.items()) {
    if (key == "format" || key == "twice") continue;
    for (const Json& wrong : {Json("text"), Json(true), Json(1.5), Json::object(), Json{1, "a"}}) {
      if (wrong.type() == value.type()) continue;
      EXPECT_THAT(said_of("/" + key, wrong), StartsWith("b.json: " + key + ": found "))
          << wrong.dump();
    }
  }
  EXPECT_EQ(said_of("/real", "much"), "b.json: real: found \"much\"; allowed: a number or null");
  EXPECT_EQ(said_of("/yes", 1), "b.json: yes: found 1; allowed: true or false");
  EXPECT_EQ(said_of("/words", {1}), "b.json: words: found a list; allowed: text");
  EXPECT_EQ(said_of("/texts/1", 4), "b.json: texts: found a list; allowed: a list of texts");
  EXPECT_EQ(said_of("/reals/2", "x"),
            "b.json: reals: found a list; allowed: a list of numbers or nulls");
  EXPECT_EQ(said_of("/part", nullptr), "b.json: part: found null; allowed: an object");
  EXPECT_EQ(said_of("/parts/1", 2), "b.json: parts: found a list; allowed: a list of objects");
  EXPECT_EQ(said_of("/parts/1/x", "long"),
            "b.json: parts[1].x: found \"long\"; allowed: a number or null");
  EXPECT_EQ(said_of("/maybe/list", 3),
            "b.json: maybe.list: found 3; allowed: a list of numbers or nulls");
}

TEST_F(ArtefactTest, WholeNumbersAreWholeAndFit) {
  for (const Json& wrong : {Json(1.5), Json(2'147'483'648), Json(-2'147'483'649), Json(nullptr)})
    EXPECT_THAT(said_of("/whole", wrong), HasSubstr("allowed: a whole number")) << wrong.dump();
  for (const Json& wrong : {Json(-1), Json(0.5)})
    EXPECT_THAT(said_of("/large", wrong), HasSubstr("allowed: a whole number")) << wrong.dump();
  EXPECT_THAT(said_of("/wholes/0", 0.5), HasSubstr("b.json: wholes: "));
}

TEST_F(ArtefactTest, ChoicesAreAmongTheirWords) {
  EXPECT_EQ(said_of("/word", "up"), "b.json: word: found \"up\"; allowed: left, right");
  for (const char* wrong : {"", " ", "left|right", "left, right", "righ"})
    EXPECT_THAT(said_of("/word", wrong), HasSubstr("allowed: left, right")) << wrong;
  EXPECT_EQ(said_of("/colour", "blue"), "b.json: colour: found \"blue\"; allowed: red, dark blue");
}

TEST_F(ArtefactTest, PairsAreTwoAndRowsOfOneLength) {
  EXPECT_EQ(said_of("/ranges/0", {1}), "b.json: ranges: found a list; allowed: pairs of numbers");
  EXPECT_EQ(said_of("/matrix/1", {1}), "b.json: matrix: found a list; allowed: rows of one length");
}

TEST_F(ArtefactTest, OtherFormatsAreRefused) {
  EXPECT_EQ(
      said_of("/format", "fricid.sample/2"),
      "b.json: format fricid.sample/2 is newer than fricid.sample/1, which this program reads");
  for (const char* other :
       {"fricid.sample/0", "fricid.sample/", "fricid.simple/2", "fricid.sample"})
    EXPECT_EQ(said_of("/format", other),
              fmt::format("b.json: found \"{}\"; allowed: \"format\": \"fricid.sample/1\"", other));
  EXPECT_EQ(said_of("/format", 1), "b.json: found 1; allowed: \"format\": \"fricid.sample/1\"");
  for (const char* none : {"{}", "[1]", "3", "null"})
    EXPECT_EQ(said_of_text(none),
              "b.json: found no format; allowed: \"format\": \"fricid.sample/1\"");
  EXPECT_EQ(said_of_text(""), "b.json: an empty file");
  for (const char* torn : {" ", "{\"format\": \"fricid.sample/1\"", "\xff\xfe", "{} {}"})
    EXPECT_THAT(said_of_text(torn), StartsWith("b.json:1: not JSON, or torn: "));
  EXPECT_THAT(message_of([&] { load<Sample>(path("absent.json")); }), StartsWith("absent.json: "));
}

TEST_F(ArtefactTest, PartsMustAgree) {
  EXPECT_EQ(said_of("/whole", 13), "b.json: whole = 13; allowed: another number");
}

TEST_F(ArtefactTest, DepthIsNoDanger) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  const std::string text = to_json(full());
  for (const std::string& damaged :
       {deep, replaced(text, "\"real\": ", "\"real\": " + deep + ", \"was\": "),
        replaced(text, "\"lists\": ", "\"later\": " + deep + ", \"lists\": ")})
    EXPECT_EQ(said_of_text(damaged),
              "b.json: 33 levels of lists and objects in a JSON file; allowed: up to 32");
  const std::string flat = std::string(31, '[') + std::string(31, ']');
  EXPECT_EQ(said_of_text(replaced(text, "\"lists\": ", "\"later\": " + flat + ", \"lists\": ")),
            "no error");
}

TEST_F(ArtefactTest, MessagesAreOneLineThatShows) {
  const std::string said = said_of("/real", "a\nb\x1b[31m" + std::string(300, 'x'));
  EXPECT_THAT(said, Not(HasSubstr("\n")));
  EXPECT_THAT(said, Not(HasSubstr("\x1b")));
  EXPECT_LT(said.size(), 150u);
}

TEST_F(ArtefactTest, TextThatIsNoUtf8IsStillWritten) {
  Sample sample = full();
  sample.words = "bad \xff byte";
  save(sample, file);
  EXPECT_THAT(loaded().words, StartsWith("bad "));
}

}  // namespace
}  // namespace fricid::data
