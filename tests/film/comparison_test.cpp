// The film of a run made by formulas. Pictures of before are in golden/, a quarter of the size; to
// make them anew: FRICID_WRITE_GOLDEN=1 film_gl_test
#include "fricid/film/comparison.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "film_fixture.hpp"
#include "fricid/base/error.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::film {
namespace {

/// Mean of 4 x 4 pixels.
Image quartered(const Image& image) {
  Image small(image.width / 4, image.height / 4);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int dy = 0; dy < 4; ++dy)
          for (int dx = 0; dx < 4; ++dx) sum += image.row(4 * y + dy)[3 * (4 * x + dx) + c];
        small.row(y)[3 * x + c] = static_cast<std::uint8_t>(sum / 16);
      }
  return small;
}

class ComparisonTest : public FilmFolder {
 protected:
  std::unique_ptr<GlContext> context = make_gl_context(GlBackend::kOsmesa);
  std::optional<sim::MujocoArm> arm;
  std::optional<RunFilm> film;
  std::optional<ArmPainter> painter;

  Comparison comparison() {
    film.emplace(read_film(run, problem()));
    if (!arm) arm.emplace(sim::make_arm(problem()));
    if (!painter)
      painter.emplace(*arm, "flange", kFilmWidth, kFilmHeight, PaintQuality::draft(),
                      context->functions());
    return {*film, problem(), *painter};
  }

  /// Letters differ by a pixel between versions of the fonts, edges between drivers.
  static void expect_golden(const Image& picture, const std::string& name) {
    const std::string file = source_dir() / "tests/film/golden/" / name;
    const Image small = quartered(picture);
    if (std::getenv("FRICID_WRITE_GOLDEN")) save_png(small, file);
    EXPECT_LT(share_differing(small, load_png(file), 24), 0.01) << name;
  }
};

TEST_F(ComparisonTest, FirstAndLastFrameAreAsBefore) {
  Comparison ghosts = comparison();
  EXPECT_EQ(frames_of(*film), 60);
  expect_golden(ghosts.frame(0), "first.png");
  expect_golden(ghosts.frame(59), "last.png");
}

TEST_F(ComparisonTest, CardsAreAsBefore) {
  Comparison ghosts = comparison();
  expect_golden(ghosts.opening_card(), "opening.png");
  expect_golden(ghosts.closing_card(), "closing.png");
}

TEST_F(ComparisonTest, SideBySideIsAsBefore) {
  scene.render.layout = Layout::kSideBySide;
  expect_golden(comparison().frame(59), "side_by_side.png");
}

TEST_F(ComparisonTest, AFrameDependsOnItsIndexAlone) {
  Comparison ghosts = comparison();
  const Image before = ghosts.frame(30);
  EXPECT_GT(share_differing(before, ghosts.frame(31), 8), 0.001);
  EXPECT_EQ(share_differing(before, ghosts.frame(30), 0), 0);
}

TEST_F(ComparisonTest, ModelsOfTheSameMotionLeaveOneColourLess) {
  const Image apart = comparison().still(kRows - 1);
  save_rollout("simple", 0, friction(0));
  const Image together = comparison().still(kRows - 1);
  EXPECT_GT(share_differing(apart, together, 40), 0.005);
}

TEST_F(ComparisonTest, UnknownJointsAreRefused) {
  scene.render.joint = "joint_a9";
  EXPECT_THROW(comparison(), UserError);
}

TEST(ViewOf, HoldsThePoints) {
  // a square of 2 m seen from the front, 90 degrees of view: at least 1 m away
  const std::vector<Eigen::Vector3d> square{{0, -1, -1}, {0, 1, 1}, {0, -1, 1}, {0, 1, -1}};
  const double right_angle = std::acos(0.0);
  const View view = view_of(square, 0, 0, right_angle, 1);
  EXPECT_NEAR(view.distance, 1, 1e-12);
  EXPECT_NEAR(view.target.norm(), 0, 1e-12);
  EXPECT_NEAR(view_of(square, 0, 0, right_angle, 0.5).distance, 2, 1e-12);
  EXPECT_NEAR(view_of(square, 0, 0, right_angle, 2).distance, 1, 1e-12);
}

TEST_F(ComparisonTest, TheViewShowsTheErrorFromTheSide) {
  // only a1 drifts: the tip errs along y where it points along x, seen best along x
  const sim::MujocoArm kr6 = sim::make_arm(problem());
  ArmPainter painter16(kr6, "flange", 16, 16, PaintQuality::draft(), context->functions());
  FilmPaths paths;
  for (int k = 0; k < 100; ++k) {
    paths.truth.push_back({0.5, 0, 1});
    paths.outline.push_back({0.5, 0, 1 + 0.001 * k});
  }
  paths.models = {paths.truth};
  for (Eigen::Vector3d& tip : paths.models[0]) tip.y() += 0.1;
  const double azimuth = telling_view(paths, painter16, 1.5).azimuth_deg;
  EXPECT_TRUE(azimuth == 0 || azimuth == 180) << azimuth;
}

}  // namespace
}  // namespace fricid::film
