#include "fricid/render/figure.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "../../render/src/letters.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/render/palette.hpp"
#include "hostile_text.hpp"
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
  EXPECT_EQ(count(script, "title \"it\\047s 5 \\045\""), 1);
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

/// A figure that says `text` everywhere it can.
Figure saying(const std::string& text) {
  Figure figure = two_panels();
  figure.caption = text;
  Panel& panel = figure.panels[0];
  panel.title = panel.x_label = panel.y_label = panel.series[0].label = text;
  panel.x_tics = {{0, text}, {1, "one"}};
  panel.y_tics = {{1, text}};
  return figure;
}

/// Works in a folder for as long as it lives.
class WorkingFolder {
 public:
  explicit WorkingFolder(const std::filesystem::path& folder)
      : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder);
  }
  ~WorkingFolder() { std::filesystem::current_path(before_); }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  std::filesystem::path before_;
};

/// Runs a command by the shell. @return its exit status
int shell(const std::string& command) { return std::system(command.c_str()); }

TEST_F(WriteFigure, TextIsDrawnAndNeverRun) {
  const WorkingFolder here(folder);
  int files = 0;
  for (const std::string& text : hostile_texts()) {
    SCOPED_TRACE(text);
    write_figure(saying(text), folder);
    std::filesystem::rename("pair.svg", fmt::format("{}.svg", files++));
    EXPECT_FALSE(std::filesystem::is_regular_file("marker"));
  }
  EXPECT_EQ(shell("python3 -c 'import glob, xml.dom.minidom as x; "
                  "[x.parse(f) for f in glob.glob(\"*.svg\")]'"),
            0);
}

TEST_F(WriteFigure, TheScriptBesideAPictureIsRunnableAndRunsNothingElse) {
  const WorkingFolder here(folder);
  for (const std::string& text : hostile_texts()) {
    SCOPED_TRACE(text);
    write_file_atomically("pair.gp", script_of(saying(text)));
    EXPECT_EQ(shell("gnuplot -e \"set terminal svg; set output 'own.svg'\" pair.gp 2>/dev/null"),
              0);
    EXPECT_FALSE(std::filesystem::is_regular_file("marker"));
  }
}

TEST_F(WriteFigure, FoldersOfAnyNameAreFolders) {
  const WorkingFolder here(folder);
  for (std::string name : hostile_texts()) {
    std::erase(name, '/');  // no part of a name
    std::erase(name, '\0');
    if (name.empty() || name.size() > 200 || name.starts_with('.')) continue;
    SCOPED_TRACE(name);
    write_figure(two_panels(), name);
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(name) / "pair.png"));
    EXPECT_FALSE(std::filesystem::is_regular_file("marker"));
  }
}

// A panel without a number to draw is an empty frame, on any axis.
TEST_F(WriteFigure, PanelsWithoutNumbersAreEmpty) {
  Figure figure = two_panels();
  figure.panels[0].series.clear();
  figure.panels[1].series[0].y = {NAN, NAN, NAN};
  write_figure(figure, folder);
  EXPECT_EQ(count(read_file(folder / "pair.gp"), "\nplot NaN notitle"), 2);
  EXPECT_TRUE(std::filesystem::exists(folder / "pair.pdf"));
}

TEST_F(WriteFigure, SaysWhichLineGnuplotRefused) {
  Figure broken = two_panels();
  broken.panels[0].series[0].colour = "no colour";
  try {
    write_figure(broken, folder);
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("pair.gp: gnuplot refused the script: line "));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "pair.pdf"));
}

/// A program called gnuplot, first in the PATH for as long as this lives.
class FakeGnuplot {
 public:
  FakeGnuplot(const std::filesystem::path& folder, const std::string& script)
      : path_(std::getenv("PATH")) {
    const auto program = folder / "bin/gnuplot";
    write_file_atomically(program, "#!/bin/sh\n" + script);
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("PATH", (program.parent_path().string() + ":" + path_).c_str(), 1);
  }
  ~FakeGnuplot() { setenv("PATH", path_.c_str(), 1); }

 private:
  std::string path_;
};

TEST_F(WriteFigure, KilledGnuplotIsSaid) {
  const FakeGnuplot gnuplot(folder, "kill -9 $$\n");
  try {
    write_figure(two_panels(), folder);
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("killed by signal 9"));
  }
}

TEST_F(WriteFigure, TornPictureIsRefused) {
  // What a full disk leaves: gnuplot ends well, the end of its file is missing.
  const FakeGnuplot gnuplot(folder,
                            "for f in $(echo \"$3\" | tr ';' '\\n' | sed -n 's/.*set output "
                            "\"\\(.*\\)\"/\\1/p'); do echo torn > $f; done\n");
  try {
    write_figure(two_panels(), folder);
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("could not write all of it"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "pair.png"));
}

TEST_F(WriteFigure, PathsMayHoldQuotesAndSpaces) {
  write_figure(two_panels(), folder / "o'brien & $HOME \"x\"");
  EXPECT_TRUE(std::filesystem::exists(folder / "o'brien & $HOME \"x\"/pair.png"));
}

TEST(Script, LinesAreThinnedToWhatShows) {
  Series straight, corner;
  for (int i = 0; i <= 1000; ++i) {
    straight.x.push_back(i);
    straight.y.push_back(2 * i);
    corner.x.push_back(i);
    corner.y.push_back(i < 500 ? 0 : i);
  }
  Figure figure{.name = "thin"};
  figure.panels = {{.series = {straight, corner}}};
  EXPECT_THAT(script_of(figure), HasSubstr("$d0_0 << EOD\n0 0\n1000 2000\nEOD"));
  EXPECT_THAT(script_of(figure), HasSubstr("$d0_1 << EOD\n0 0\n499 0\n500 500\n1000 1000\nEOD"));
}

TEST(Script, NamedTicsStandUpWhereTheyWouldOverlap) {
  Figure figure{.name = "names"};
  Panel panel;
  panel.series.push_back({.x = {0, 1}, .y = {0, 1}});
  for (int i = 0; i < 3; ++i) panel.x_tics.emplace_back(i, "Fc");
  figure.panels = {panel, panel, panel};
  EXPECT_THAT(script_of(figure), HasSubstr("set xtics norotate autojustify noenhanced ('Fc' 0"));
  for (int i = 3; i < 13; ++i) figure.panels[0].x_tics.emplace_back(i, "alpha4");
  EXPECT_THAT(script_of(figure), HasSubstr("set xtics rotate by 90 right noenhanced ('Fc' 0"));
}

TEST(Script, TilesAreSquaresColouredByTheirValue) {
  Figure figure{.name = "tiles"};
  figure.panels = {{.series = {{.x = {0}, .y = {1}, .mark = Mark::kTiles, .low = {-0.5}}}}};
  const std::string script = script_of(figure);
  EXPECT_THAT(script, HasSubstr("0 1 -0.5 \n"));
  EXPECT_THAT(script, HasSubstr("using 1:2:(0.5):(0.5):3 with boxxyerror"));
}

TEST(Script, TicsLeaveRoomForTheirNumbers) {
  Figure figure{.name = "tics"};
  figure.panels = {{.series = {{.x = {0, 2}, .y = {0, 1}}}}};
  EXPECT_THAT(script_of(figure), HasSubstr("\nset xtics norotate 0.5\n"));
  figure.panels[0].series[0].x = {-1571, 1571};
  EXPECT_THAT(script_of(figure), HasSubstr("\nset xtics norotate 1000\n"));
}

TEST(Script, AnAxisOfTimeEndsWithItsData) {
  Figure figure{.name = "time"};
  figure.panels = {{.series = {{.x = {0, 31.4}, .y = {0, 1}}}}};
  EXPECT_THAT(script_of(figure), HasSubstr("\nset xrange [*:*] noreverse\n"));
  figure.panels[0].fit_x = true;
  EXPECT_THAT(script_of(figure), HasSubstr("\nset xrange [0:31.4] noreverse\n"));
  figure.panels[0].x_range = {0, 5};
  EXPECT_THAT(script_of(figure), HasSubstr("\nset xrange [0:5] noreverse\n"));
}

TEST(Script, FewPanelsShareTheWholeWidth) {
  Figure figure{.name = "few", .columns = 3, .width_cm = 18, .left_cm = 1.8};
  figure.panels = {{.series = {{.x = {0, 1}, .y = {0, 1}}}}};
  EXPECT_THAT(script_of(figure),
              HasSubstr("set lmargin at screen 0.10000\nset rmargin at screen 0.98"));
  figure.panels.push_back(figure.panels[0]);
  EXPECT_THAT(script_of(figure), HasSubstr("set lmargin at screen 0.60000\n"));
}

TEST(Script, BarsHaveTheirEnds) {
  Figure figure{.name = "bars"};
  figure.panels = {
      {.series = {
           {.x = {1, 2}, .y = {3, 4}, .mark = Mark::kBars, .low = {2, NAN}, .high = {5, NAN}}}}};
  EXPECT_THAT(script_of(figure), HasSubstr("$d0_0 << EOD\n1 3 2 5 \n\nEOD"));
}

// No font has the last character of all: Pango would draw its number.
TEST(Letters, ThatNoFontHasAreBoxes) {
  EXPECT_EQ(with_known_letters("q₁ [rad²], Gelenk \u00fc \u0416 µ"),
            "q₁ [rad²], Gelenk \u00fc \u0416 µ");
  EXPECT_EQ(with_known_letters("a\U0010fffdb"), "a\u25a1b");
}

TEST(Letters, LongNamesKeepBothEnds) {
  EXPECT_EQ(shortened("left arm/axis 1 (base)", 22), "left arm/axis 1 (base)");
  EXPECT_EQ(shortened("left arm/axis 1 (base)", 9), "left\u2026ase)");
  EXPECT_EQ(shortened("Gelenk_\u00c43", 8), "Gele\u2026_\u00c43");
}

TEST(LookOfLaw, SameLawSameHueOtherShade) {
  EXPECT_EQ(look_of_law("lugre").colour, "#009E73");
  EXPECT_EQ(look_of_law("lugre", 1).colour, "#66C5AB");  // 40 % towards white
  EXPECT_EQ(look_of_law("lugre", 2).colour, "#00573F");  // 45 % towards black
  EXPECT_NE(look_of_law("lugre", 1).dash, look_of_law("lugre").dash);
  EXPECT_EQ(look_of_law("lugre", 1).marker, look_of_law("lugre").marker);
}

}  // namespace
}  // namespace fricid::render
