#include "fricid/film/arm_painter.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::film {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr std::array<double, 6> kPose{0.4, -1.1, 1, -0.4, -0.9, 0};
constexpr Paint kBlue{0, 0, 1, 1};

sim::MujocoArm kr6() {
  return sim::make_arm(scene::load_problem(source_dir() / "scenes/kr6_demo.toml"));
}

View front() { return {.target = {0.1, 0, 1.1}, .distance = 1.8, .azimuth_deg = 135}; }

/// Pixels with much more of one colour channel than of the others.
int pixels_of(const Image& image, std::size_t channel) {
  int count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const int here = image.rgb[i + channel];
    count += here > 60 + image.rgb[i + (channel + 1) % 3] &&
             here > 60 + image.rgb[i + (channel + 2) % 3];
  }
  return count;
}

double mean_column(const Image& image, std::size_t channel) {
  double sum = 0, count = 0;
  for (int x = 0; x < image.width; ++x) {
    Image column(1, image.height);
    for (int y = 0; y < image.height; ++y) std::copy_n(image.row(y) + 3 * x, 3, column.row(y));
    sum += x * pixels_of(column, channel);
    count += pixels_of(column, channel);
  }
  return sum / count;
}

TEST(ArmPainter, DrawsAnOrangeArm) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::draft(), context->functions());
  const std::array<PaintedArm, 1> arms{{{kPose}}};
  const Image image = painter.paint(front(), kWidth, kHeight, arms);
  EXPECT_GT(pixels_of(image, 0), 3000);
  EXPECT_EQ(pixels_of(image, 2), 0);
  EXPECT_EQ(painter.paint(front(), kWidth, kHeight, arms).rgb, image.rgb);
}

TEST(ArmPainter, AGhostStandsWhereItsJointsSay) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::draft(), context->functions());
  const auto blue_column = [&](double turn) {
    std::array<double, 6> other = kPose;
    other[0] += turn;
    const std::array<PaintedArm, 2> arms{{{kPose}, {other, kBlue}}};
    return mean_column(painter.paint(front(), kWidth, kHeight, arms), 2);
  };
  // a1 turns about the upward axis; at turn + 0.4 = 45 deg the arm points to the right of the
  // picture
  const double right = blue_column(0.385), ahead = blue_column(-1.185), left = blue_column(-2.755);
  EXPECT_GT(right, ahead + 20);
  EXPECT_GT(ahead, left + 20);
}

/// How much more a ghost changes the picture when it is twice as opaque.
double gain_of_opacity(const sim::MujocoArm& arm) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::draft(), context->functions());
  std::array<double, 6> other = kPose;
  other[0] -= 1;
  const View view{.target = painter.tip(kPose), .distance = 1.8, .azimuth_deg = 135};
  const auto picture = [&](float alpha) {
    const std::array<PaintedArm, 2> arms{{{kPose}, {other, Paint{0, 0, 1, alpha}}}};
    return painter.paint(view, kWidth, kHeight, arms);
  };
  const Image without = picture(0), faint = picture(0.2f), clear = picture(0.4f);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < without.rgb.size(); ++i)
    if (const int change = faint.rgb[i] - without.rgb[i]; std::abs(change) > 15)
      ratios.push_back(static_cast<double>(clear.rgb[i] - without.rgb[i]) / change);
  if (ratios.size() < 1000) return 0;
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2),
                   ratios.end());
  return ratios[ratios.size() / 2];
}

TEST(ArmPainter, AGhostIsAsTranslucentAsItsPaint) {
  EXPECT_NEAR(gain_of_opacity(kr6()), 2, 0.1);  // drawn twice, it would be 1.78
}

TEST(ArmPainter, AGhostWithoutMeshesIsAsTranslucentAsItsPaint) {
  scene::Problem capsules = scene::load_problem(source_dir() / "scenes/kr6_demo.toml");
  capsules.mjcf_path.clear();
  EXPECT_NEAR(gain_of_opacity(sim::make_arm(capsules)), 2, 0.1);
}

/// Share of the ghost's pixels that flicker while it trembles by less than one can see, about the
/// arm that it stands in.
double flicker_of_coincident_ghost(const sim::MujocoArm& arm) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::draft(), context->functions());
  constexpr Paint kGrey{0.8f, 0.8f, 0.8f, 1};
  const View view{.target = painter.tip(kPose), .distance = 1.8, .azimuth_deg = 135};
  const auto picture = [&](double off) {
    std::array<double, 6> ghost = kPose;
    for (double& q : ghost) q += off;
    const std::array<PaintedArm, 2> arms{{{kPose, kGrey}, {ghost, Paint{0, 0, 1, 0.5f}}}};
    return painter.paint(view, kWidth, kHeight, arms);
  };
  const Image one = picture(2e-4), other = picture(-2e-4);
  return share_differing(one, other, 40) * kWidth * kHeight / pixels_of(picture(0), 2);
}

TEST(ArmPainter, AGhostDoesNotFlickerWhereItsSurfacesMeetTheArms) {
  EXPECT_LT(flicker_of_coincident_ghost(kr6()), 0.02);
}

TEST(ArmPainter, AGhostWithoutMeshesDoesNotFlicker) {
  scene::Problem capsules = scene::load_problem(source_dir() / "scenes/kr6_demo.toml");
  capsules.mjcf_path.clear();
  EXPECT_LT(flicker_of_coincident_ghost(sim::make_arm(capsules)), 0.02);
}

// The floor's grid is not MuJoCo's.
TEST(ArmPainter, TheFloorIsAsMujocoDrawsIt) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::draft(), context->functions());
  const View view{
      .target = {0.1, 0, 1.1}, .distance = 2.6, .azimuth_deg = 135, .elevation_deg = -8};
  const std::array<PaintedArm, 1> arms{{{kPose}}};
  const Image image = painter.paint(view, kWidth, kHeight, arms);

  const sim::MjModelPtr model(mj_copyModel(nullptr, &arm.model()));
  model->vis.global.offwidth = kWidth;
  model->vis.global.offheight = kHeight;
  model->vis.quality.offsamples = 0;
  const sim::MjDataPtr data = arm.make_data();
  for (int j = 0; j < arm.n(); ++j) data->qpos[arm.qpos(j)] = kPose[static_cast<std::size_t>(j)];
  mj_kinematics(model.get(), data.get());
  mj_comPos(model.get(), data.get());
  mj_camlight(model.get(), data.get());
  mjvScene scene;
  mjv_defaultScene(&scene);
  mjv_makeScene(model.get(), &scene, 1000);
  scene.flags[mjRND_SHADOW] = 0;
  mjvOption option;
  mjv_defaultOption(&option);
  mjvPerturb nobody;
  mjv_defaultPerturb(&nobody);
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  Eigen::Vector3d::Map(camera.lookat) = view.target;
  camera.distance = view.distance;
  camera.azimuth = view.azimuth_deg;
  camera.elevation = view.elevation_deg;
  mjrContext mjr;
  mjr_defaultContext(&mjr);
  mjr_makeContext(model.get(), &mjr, mjFONTSCALE_100);
  mjr_setBuffer(mjFB_OFFSCREEN, &mjr);
  mjv_updateScene(model.get(), data.get(), &option, &nobody, &camera, mjCAT_ALL, &scene);
  mjr_render({0, 0, kWidth, kHeight}, &scene, &mjr);
  Image upside_down(kWidth, kHeight), expected(kWidth, kHeight);
  mjr_readPixels(upside_down.rgb.data(), nullptr, {0, 0, kWidth, kHeight}, &mjr);
  for (int y = 0; y < kHeight; ++y)
    std::copy_n(upside_down.row(kHeight - 1 - y), 3 * kWidth, expected.row(y));
  mjr_freeContext(&mjr);
  mjv_freeScene(&scene);
  EXPECT_LT(share_differing(image, expected, 1), 1e-3);
}

TEST(ArmPainter, APictureOnItsBackdropIsThePictureDrawnWhole) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  std::array<double, 6> other = kPose;
  other[0] += 0.3;
  Trail trail{{}, kBlue, 20};  // wide, and out of the picture and in again
  for (int i = -10; i <= 10; ++i) trail.points.emplace_back(0.3, 0.05 * i, i % 2 == 0 ? 0.8 : 1.8);
  for (const PaintQuality quality :
       {PaintQuality::draft(), PaintQuality::standard(), PaintQuality::final()})
    for (const std::optional<Paint> tint : {std::optional<Paint>{}, {{0.8f, 0.8f, 0.8f, 1}}}) {
      ArmPainter painter(arm, "flange", kWidth, kHeight, quality, context->functions());
      const std::array<PaintedArm, 2> arms{{{kPose, tint}, {other, Paint{0, 0, 1, 0.5f}}}};
      const auto picture = [&](const View& view) {
        return painter.paint(view, kWidth, kHeight, arms, {&trail, 1});
      };
      const Image whole = picture(front());
      painter.keep_backdrop(front(), kWidth, kHeight);
      View close = front();
      close.distance = 0.9;
      picture(close);
      EXPECT_LT(share_differing(picture(front()), whole, 1), 1e-3);
    }
}

TEST(ArmPainter, LargerPicturesThanExpectedAreDrawn) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  const std::array<PaintedArm, 1> arms{{{kPose}}};
  const auto picture = [&](int width, int height) {
    ArmPainter painter(arm, "flange", width, height, PaintQuality::standard(),
                       context->functions());
    painter.keep_backdrop(front(), width, height);
    return painter.paint(front(), kWidth, kHeight, arms);
  };
  EXPECT_EQ(share_differing(picture(kWidth, kHeight), picture(16, 16), 0), 0);
}

// What is out of sight is not drawn: the sights of these pictures cut through different links.
TEST(ArmPainter, ANarrowPictureIsTheMiddleOfAWideOne) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::final(), context->functions());
  std::array<double, 6> other = kPose;
  other[0] += 0.2;
  const std::array<PaintedArm, 2> arms{{{kPose}, {other, Paint{0, 0, 1, 0.5f}}}};
  View close{.target = painter.tip(kPose), .distance = 0.5};
  for (close.azimuth_deg = 0; close.azimuth_deg < 360; close.azimuth_deg += 40) {
    SCOPED_TRACE(close.azimuth_deg);
    const Image wide = painter.paint(close, kWidth, kHeight, arms);
    constexpr int kNarrow = 80;
    Image middle(kNarrow, kHeight);
    for (int y = 0; y < kHeight; ++y)
      std::copy_n(wide.row(y) + static_cast<std::ptrdiff_t>(3) * (kWidth - kNarrow) / 2,
                  3 * kNarrow, middle.row(y));
    EXPECT_LT(share_differing(painter.paint(close, kNarrow, kHeight, arms), middle, 4), 1e-3);
  }
}

TEST(ArmPainter, TrailsAreDrawn) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::draft(), context->functions());
  const std::array<PaintedArm, 1> arms{{{kPose}}};
  const std::array<Trail, 1> trails{{{{{0.3, -0.5, 0.8}, {0.3, 0.4, 0.8}}, kBlue, 8}}};
  EXPECT_GT(pixels_of(painter.paint(front(), kWidth, kHeight, arms, trails), 2), 200);
}

TEST(ArmPainter, LightAndShadowDoNotChangeATrailsColour) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  PaintQuality shadows = PaintQuality::final();
  shadows.samples = 0;  // smooth edges would mix colours
  ArmPainter painter(arm, "flange", kWidth, kHeight, shadows, context->functions());
  const std::array<PaintedArm, 1> arms{{{kPose}}};
  Trail loop{{}, {0.2f, 0.5f, 0.7f, 1}, 3};
  for (double angle = 0; angle < 6.3; angle += 0.1)
    loop.points.emplace_back(0.4 * std::cos(angle), 0.4 * std::sin(angle) - 0.4,
                             1.1 + 0.3 * std::sin(2 * angle));
  const Image without = painter.paint(front(), kWidth, kHeight, arms);
  const Image with = painter.paint(front(), kWidth, kHeight, arms, {&loop, 1});
  int drawn = 0;
  const std::array<int, 3> colour{51, 128, 179};
  for (std::size_t i = 0; i < with.rgb.size(); i += 3) {
    if (std::equal(&with.rgb[i], &with.rgb[i] + 3, &without.rgb[i])) continue;
    ++drawn;
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(with.rgb[i + c], colour[c], 4) << c;
  }
  EXPECT_GT(drawn, 200);
}

TEST(ArmPainter, ATrailLiesOverThoseBeforeIt) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  ArmPainter painter(arm, "flange", kWidth, kHeight, PaintQuality::draft(), context->functions());
  const std::array<PaintedArm, 1> arms{{{kPose}}};
  // steps of different length on the same line: neither is nearer all along
  Trail red{{}, {1, 0, 0, 1}, 4}, blue{{}, kBlue, 4};
  for (int i = 0; i <= 10; ++i) red.points.emplace_back(0.3, -0.5 + 0.09 * i, 0.8);
  for (int i = 0; i <= 9; ++i) blue.points.emplace_back(0.3, -0.5 + 0.1 * i, 0.8);
  const auto visible = [&](const Trail& below, const Trail& above, std::size_t channel) {
    const std::array<Trail, 2> trails{below, above};
    const std::array<Trail, 1> alone{above};
    return pixels_of(painter.paint(front(), kWidth, kHeight, arms, trails), channel) /
           static_cast<double>(
               pixels_of(painter.paint(front(), kWidth, kHeight, arms, alone), channel));
  };
  EXPECT_NEAR(visible(red, blue, 2), 1, 0.01);
  EXPECT_NEAR(visible(blue, red, 0), 1, 0.01);
}

TEST(ArmPainter, TheFloorDoesNotShadeItself) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  const std::array<PaintedArm, 1> arms{{{kPose}}};
  const auto floor = [&](int shadow_pixels) {
    ArmPainter painter(arm, "flange", kWidth, kHeight, {0, shadow_pixels}, context->functions());
    return painter.paint({{2.6, -1.5, 0}, 1.5, 330, -20}, kWidth, kHeight, arms);
  };
  EXPECT_LT(share_differing(floor(2048), floor(0), 24), 1e-3);  // sunny, far from the arm
}

TEST(ArmPainter, TipIsTheFlange) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  ArmPainter painter(arm, "flange", 16, 16, PaintQuality::draft(), context->functions());
  // hanging from 1.6 m; stretched: 400 down, 25 + 315 + 365 + 80 along, 35 up
  const std::array<double, 6> stretched{};
  const Eigen::Vector3d tip = painter.tip(stretched);
  EXPECT_NEAR((tip - Eigen::Vector3d(0.785, 0, 1.6 - 0.435)).norm(), 0, 1e-9) << tip.transpose();
  EXPECT_EQ(painter.joints(stretched).size(), 8u);
}

TEST(ArmPainter, SurroundingsHide) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = kr6();
  ArmPainter painter(arm, "flange", 16, 16, PaintQuality::draft(), context->functions());
  painter.tip(kPose);
  // along +y; a post of the portal stands at x = 0, y = -1
  const View along_y{{0, 0, 1}, 3, 90, 0};
  const std::array<Eigen::Vector3d, 2> points{{{0, 0, 1}, {0.3, 0, 1}}};
  EXPECT_EQ(painter.hidden_share(along_y, points), 0.5);
  EXPECT_EQ(painter.hidden_share(front(), points), 0);
}

}  // namespace
}  // namespace fricid::film
