// The films of closed loops: friction fed forward, and pushes that observers find. Of a run made by
// formulas.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "contact_film.hpp"
#include "film_fixture.hpp"
#include "fricid/data/contact_file.hpp"
#include "fricid/data/loop_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/evaluate/compensation.hpp"
#include "fricid/evaluate/contact.hpp"
#include "fricid/film/comparison.hpp"
#include "fricid/film/frame_writer.hpp"
#include "fricid/film/run_film.hpp"
#include "fricid/film/video.hpp"
#include "fricid/sim/simulate.hpp"
#include "output_of.hpp"

namespace fricid::film {
namespace {

/// A part of a picture between two columns.
Image columns(const Image& image, int begin, int end) {
  Image part(end - begin, image.height);
  for (int y = 0; y < image.height; ++y)
    std::copy_n(image.row(y) + std::ptrdiff_t{3} * begin, 3 * part.width, part.row(y));
  return part;
}

int red_pixels(const Image& image) {
  int count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3)
    count += image.rgb[i] > image.rgb[i + 1] + 80 && image.rgb[i] > image.rgb[i + 2] + 80;
  return count;
}

class LoopFilms : public FilmFolder {
 protected:
  static constexpr int kShort = 76;  // rows of 0.3 s
  static constexpr double kPushed_Nm = 9;

  /// A loop that is `drift` rad off after one second, pushed at joint 1 in its last half.
  void save_loop(const std::filesystem::path& file, double drift, bool pushed = false) const {
    data::LoopSignals loop;
    loop.joint_names = trajectory.data.joint_names;
    loop.t = trajectory.data.t;
    loop.q_desired = motion(0, false);
    loop.v_desired = motion(0, true);
    loop.q = loop.q_measured = motion(drift, false);
    loop.v = motion(drift, true);
    loop.tau = loop.tau_feedback = loop.tau_forward = loop.tau_f = friction(10 * drift);
    if (pushed) loop.tau_ext = external_torque(kPushed_Nm);
    loop.keep(kShort);
    if (pushed) loop.t.array() += evaluate::kContactWarmUp;
    data::save_signals(loop, file);
  }

  static data::RowMatrix external_torque(double size) {
    data::RowMatrix tau_ext = data::RowMatrix::Zero(kRows, kJoints);
    tau_ext.col(1).segment(kShort / 2, kShort / 2).setConstant(size);
    return tau_ext;
  }

  void add_compensation() const {
    evaluate::CompensationFile file{.drive = "reference", .path_s = 0.2, .loops = {}};
    for (const auto& [model, drift] :
         {std::pair("none", 0.2), {"simple", 0.1}, {"lugre", 0.02}, {"truth", 0.0}}) {
      const std::vector<double> error(kJoints, drift);
      file.loops.push_back({.model = model,
                            .label = model,
                            .gain = 1,
                            .bandwidth_hz = 2,
                            .size = 1,
                            .reversal_rad = error,
                            .sliding_rad = error,
                            .limit_cycles = {}});
      save_loop(run.loop(model, 0, 0), drift);
    }
    data::save(file, run.compensation());
  }

  void add_contact() const {
    evaluate::ContactFile file{
        .hours = 1, .bandwidth_hz = 5, .joint_names = trajectory.data.joint_names, .models = {}};
    for (const auto& [model, threshold] : {std::pair("simple", 20.0), {"lugre", 2.0}}) {
      const std::vector<double> torque(kJoints, threshold);
      file.models.push_back({.model = model,
                             .label = model,
                             .method = evaluate::kObserver,
                             .sd_Nm = torque,
                             .threshold_sd = 1,
                             .threshold_Nm = torque,
                             .rmse_Nm = torque,
                             .rmse_reversal_Nm = torque,
                             .rmse_sliding_Nm = torque,
                             .forces = {{.force_N = 20, .pushes = 1}}});
      data::ContactSignals seen{
          .joint_names = trajectory.data.joint_names,
          .model = model,
          .log = "pushes",
          .t = trajectory.data.t.head(kShort).array() + evaluate::kContactWarmUp,
          .tau_ext = external_torque(0.9 * kPushed_Nm).topRows(kShort),
          .tau_f = friction(0).topRows(kShort)};
      data::save_signals(seen, run.external_torque(model));
    }
    data::save(file, run.contact());
    save_loop(run.pushed_loop(), 0, true);
  }
};

class LoopFrames : public LoopFilms {
 protected:
  // of the two arms in a frame
  static constexpr int kLeftEnd = kFilmWidth / 2 - 2, kRightBegin = kFilmWidth / 2 + 2;

  std::unique_ptr<GlContext> context = make_gl_context(GlBackend::kOsmesa);
  const sim::MujocoArm arm = sim::make_arm(problem());
  ArmPainter painter{
      arm, "flange", kFilmWidth, kFilmHeight, PaintQuality::draft(), context->functions()};
};

TEST_F(LoopFilms, WithoutLoopsThereAreNone) {
  EXPECT_FALSE(read_compensation_film(run, problem()));
  EXPECT_FALSE(read_contact_film(run, problem()));
}

TEST_F(LoopFrames, TheArmsSideBySideAreThoseOfTheLoops) {
  add_compensation();
  RunFilm film = read_compensation_film(run, problem()).value();
  ASSERT_EQ(film.models.size(), 2u);
  EXPECT_EQ(film.models[0].q, motion(0.2, false).topRows(kShort));
  EXPECT_EQ(film.models[1].q, motion(0.02, false).topRows(kShort)) << "errs least";
  EXPECT_EQ(film.q, motion(0, false).topRows(kShort));
  EXPECT_EQ(film.models[1].label, "lugre fed forward");

  // in one look, the left arm is the right one when the loops change places
  for (FilmModel& model : film.models) model.label = model.colour = film.models[0].colour;
  const int last = frames_of(film) - 1;
  EXPECT_EQ(last, 8);
  const Image frame = Comparison(film, problem(), painter).frame(last);
  std::swap(film.models[0], film.models[1]);
  const Image swapped = Comparison(film, problem(), painter).frame(last);
  const Image left = columns(frame, 0, kLeftEnd), right = columns(frame, kRightBegin, kFilmWidth);
  constexpr int kStrips = 470, kHeader = 44;  // what is above and below differs in the halves
  const auto arms = [](Image half) {
    Image picture(half.width, kStrips - kHeader);
    std::copy_n(half.row(kHeader), picture.rgb.size(), picture.rgb.data());
    return picture;
  };
  EXPECT_EQ(share_differing(arms(left), arms(columns(swapped, kRightBegin, kFilmWidth)), 0), 0);
  EXPECT_GT(share_differing(arms(left), arms(right), 40), 0.005);
}

TEST_F(LoopFrames, AnArmIsRedWhileItsObserverFeelsAPush) {
  add_contact();
  const ContactFilm film = read_contact_film(run, problem()).value();
  ASSERT_EQ(film.observers.size(), 2u);
  EXPECT_EQ(film.joint, 1);
  EXPECT_EQ(film.force_N, 20);
  ContactFrames frames(film, painter);
  const Image before = frames.frame(0), during = frames.frame(frames_of(film) - 1);
  constexpr int kArm = 3000;
  EXPECT_LT(red_pixels(before), kArm);
  EXPECT_LT(red_pixels(columns(during, 0, kLeftEnd)), kArm) << "too little for its threshold";
  EXPECT_GT(red_pixels(columns(during, kRightBegin, kFilmWidth)), kArm);
}

TEST_F(LoopFilms, AreMadeWithTheOthers) {
  if (!ffmpeg_found()) GTEST_SKIP() << "needs ffmpeg";
  save_rollout("gms", 0.02, friction(0), kShort);  // a short film of the open loops
  add_compensation();
  add_contact();
  scene.render.card_s = 0;
  scene.render.quality = Quality::kDraft;
  const auto files = render_video(run, run, problem(), {"osmesa", 0.2});
  ASSERT_EQ(files.size(), 4u);
  for (const char* name : {"compensation", "contact"})
    EXPECT_EQ(output_of("ffprobe -v error -select_streams v -show_entries "
                        "stream=codec_name,width,height,nb_frames -of csv=p=0 " +
                        run.video(name).string()),
              "h264,1280,720,9\n")
        << name;
}

}  // namespace
}  // namespace fricid::film
