#include "fricid/base/enum_names.hpp"

#include <gmock/gmock.h>

namespace fricid {
namespace {

enum class Gait { kWalk, kTrot, kGallop };
constexpr std::string_view names(Gait) { return "walk|trot|gallop"; }
enum class Nameless { kOne };

static_assert(NamedEnum<Gait>);
static_assert(!NamedEnum<Nameless>);
static_assert(!NamedEnum<int>);

TEST(EnumNames, NamesAndValuesAreInverse) {
  for (const Gait gait : {Gait::kWalk, Gait::kTrot, Gait::kGallop})
    EXPECT_EQ(value_named<Gait>(name_of(gait)), gait);
  EXPECT_EQ(name_of(Gait::kTrot), "trot");
  EXPECT_THAT(all_names<Gait>(), testing::ElementsAre("walk", "trot", "gallop"));
}

TEST(EnumNames, OtherTextsHaveNoValue) {
  for (const char* text : {"", "wal", "walk ", " walk", "walk|trot", "|", "Trot", "pace"})
    EXPECT_FALSE(value_named<Gait>(text)) << text;
  EXPECT_EQ(name_of(static_cast<Gait>(3)), "");
  EXPECT_EQ(name_of(static_cast<Gait>(-1)), "");
}

}  // namespace
}  // namespace fricid
