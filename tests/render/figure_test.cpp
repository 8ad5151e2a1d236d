#include "fricid/render/figure.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "temporary_folder.hpp"

namespace fricid::render {
namespace {

using ::testing::HasSubstr;

Figure two_panels() {
  const Series line{.label = "it's 5 %", .colour = "#123456", .x = {0, 1, 2}, .y = {1, NAN, 3}};
  Figure figure{.name = "pair", .columns = 2};
  figure.panels = {{.title = "left", .series = {line}},
                   {.title = "right", .log_y = true, .series = {line}}};
  return figure;
}

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++found;
  return found;
}

using WriteFigure = TemporaryFolder;

TEST_F(WriteFigure, DrawsPdfSvgAndPng) {
  write_figure(two_panels(), folder);
  EXPECT_EQ(read_file(folder / "pair.pdf").substr(0, 5), "%PDF-");
  EXPECT_THAT(read_file(folder / "pair.svg"), HasSubstr("</svg>"));
  EXPECT_EQ(read_file(folder / "pair.png").substr(1, 3), "PNG");
}

TEST_F(WriteFigure, ScriptHoldsTheDataAndOneLegend) {
  write_figure(two_panels(), folder);
  const std::string script = read_file(folder / "pair.gp");
  EXPECT_EQ(count(script, "0 1\n\n2 3\nEOD"), 2);  // what is not a number breaks the line
  EXPECT_EQ(count(script, "title 'it s 5 %'"), 1);
  EXPECT_EQ(count(script, "\nset logscale y"), 1);
  EXPECT_EQ(count(script, "lc rgb '#123456'"), 3);
}

TEST_F(WriteFigure, WithoutGnuplotTheScriptIsThereAllTheSame) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.c_str(), 1);
  EXPECT_THROW(write_figure(two_panels(), folder), UserError);
  setenv("PATH", path.c_str(), 1);
  EXPECT_TRUE(std::filesystem::exists(folder / "pair.gp"));
  EXPECT_FALSE(std::filesystem::exists(folder / "pair.pdf"));
}

TEST(ColourOf, SameModelSameColour) {
  EXPECT_EQ(colour_of("lugre", 0), colour_of("lugre", 7));
  EXPECT_NE(colour_of("lugre", 0), colour_of("gms", 0));
  EXPECT_NE(colour_of("mine", 1), colour_of("yours", 2));
}

}  // namespace
}  // namespace fricid::render
