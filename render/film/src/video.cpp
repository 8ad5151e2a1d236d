#include "fricid/film/video.hpp"

#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <utility>

#include "contact_film.hpp"
#include "drawing_processes.hpp"
#include "fricid/base/attempts.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/film/comparison.hpp"
#include "fricid/film/frame_writer.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::film {
namespace {

namespace fs = std::filesystem;
using workflow::RunFolder;

using DrawFrame = std::function<Image(int)>;

PaintQuality quality_of(const FilmOptions& config) {
  if (config.quality == Quality::kFinal) return PaintQuality::final();
  return config.quality == Quality::kDraft ? PaintQuality::draft() : PaintQuality::standard();
}

/// Frames as PNG files; for a machine without ffmpeg.
std::vector<fs::path> write_pictures(const fs::path& folder, const std::string& name, int count,
                                     DrawingProcesses& frames) {
  std::fprintf(stderr,
               "video: ffmpeg is missing, the frames go to %s as PNG; install ffmpeg for %s.mp4\n",
               printable(folder.string()).c_str(), name.c_str());
  std::vector<fs::path> files;
  Progress progress(name, count);
  for (int k = 0; k < count; ++k) {
    throw_if_stopped();
    files.push_back(folder / fmt::format("{:05}.png", k + 1));
    Image picture(kFilmWidth, kFilmHeight);
    picture.rgb = frames.next();
    save_png(picture, files.back());
    progress.advance(1);
  }
  return files;
}

std::vector<fs::path> write_video(const RunFolder& folder, const std::string& name, int count,
                                  const FilmOptions& config, int jobs,
                                  const std::function<DrawFrame()>& open) {
  const bool encode = ffmpeg_found();
  DrawingProcesses frames(count, jobs, [&] {
    return [draw = open(), encode](int k) {
      Image frame = draw(k);
      return encode ? yuv420_of(frame) : std::move(frame.rgb);
    };
  });
  if (!encode) return write_pictures(folder.videos() / name, name, count, frames);
  const fs::path file = folder.video(name);
  FrameWriter writer(file, kFilmWidth, kFilmHeight, kFilmRate, config.quality == Quality::kDraft);
  Progress progress(name, count);
  for (int k = 0; k < count; ++k) {
    throw_if_stopped();
    writer.write(frames.next());
    progress.advance(1);
  }
  writer.finish();
  return {file};
}

/// Drawing resources of a process.
struct Studio {
  std::unique_ptr<GlContext> context;
  ArmPainter painter;

  Studio(const sim::MujocoArm& arm, const scene::Problem& problem, PaintQuality quality,
         const std::string& renderer)
      : context(make_gl_context(renderer)),
        painter(arm, problem.scene.robot.payload_frame, kFilmWidth, kFilmHeight, quality,
                context->functions()) {}
};

/// A comparison and its cards.
struct ComparisonStudio {
  Studio studio;
  Comparison comparison;
  int card;  ///< frames of each card
  Image opening, closing;

  ComparisonStudio(const RunFilm& film, const sim::MujocoArm& arm, const scene::Problem& problem,
                   const std::string& renderer, int card_frames)
      : studio(arm, problem, quality_of(problem.scene.render), renderer),
        comparison(film, problem, studio.painter),
        card(card_frames) {
    if (card == 0) return;
    opening = comparison.opening_card();
    closing = comparison.closing_card();
  }

  Image frame(int k, int motion) {
    return k < card ? opening : k < card + motion ? comparison.frame(k - card) : closing;
  }
};

std::vector<fs::path> make_comparison(const RunFolder& folder, const RunFilm& film,
                                      const sim::MujocoArm& arm, const scene::Problem& problem,
                                      const DrawingOptions& options, const std::string& name,
                                      double card_s) {
  const int card = static_cast<int>(std::lround(card_s * kFilmRate));
  const int motion = frames_of(film);
  return write_video(folder, name, motion + 2 * card, problem.scene.render, options.jobs, [&] {
    const auto studio =
        std::make_shared<ComparisonStudio>(film, arm, problem, options.renderer, card);
    return [studio, motion](int k) { return studio->frame(k, motion); };
  });
}

/// Pushes, and what observers make of them.
std::vector<fs::path> make_contact_film(const RunFolder& folder, const ContactFilm& film,
                                        const sim::MujocoArm& arm, const scene::Problem& problem,
                                        const DrawingOptions& options) {
  return write_video(folder, "contact", frames_of(film), problem.scene.render, options.jobs, [&] {
    const auto studio =
        std::make_shared<Studio>(arm, problem, quality_of(problem.scene.render), options.renderer);
    const auto frames = std::make_shared<ContactFrames>(film, studio->painter);
    return [studio, frames](int k) { return frames->frame(k); };
  });
}

/// The arm moves on while the camera turns once.
Image orbit_frame(const RunFilm& film, ArmPainter& painter, View view, int k, int count) {
  const double middle = film.t[film.t.size() - 1] / 2;
  const int row = film.row(middle + static_cast<double>(k) / kFilmRate);
  view.azimuth_deg += 360.0 * k / count;
  const std::vector<PaintedArm> arms{
      {{film.q.data() + row * film.q.cols(), static_cast<std::size_t>(film.q.cols())}}};
  return painter.paint(view, kFilmWidth, kFilmHeight, arms);
}

std::vector<fs::path> make_orbit(const RunFolder& folder, const RunFilm& film,
                                 const sim::MujocoArm& arm, const scene::Problem& problem,
                                 const DrawingOptions& options) {
  const int count = static_cast<int>(std::lround(options.orbit_s * kFilmRate));
  return write_video(folder, "orbit", count, problem.scene.render, options.jobs, [&] {
    const auto studio =
        std::make_shared<Studio>(arm, problem, quality_of(problem.scene.render), options.renderer);
    constexpr double kAspect = static_cast<double>(kFilmWidth) / kFilmHeight;
    View view = telling_view(paths_of(film, studio->painter), studio->painter, kAspect);
    view.distance *= 1.15;
    return [studio, view, &film, count](int k) {
      return orbit_frame(film, studio->painter, view, k, count);
    };
  });
}

}  // namespace

std::vector<fs::path> render_video(const RunFolder& visible, const RunFolder& out,
                                   const scene::Problem& problem, const DrawingOptions& options) {
  const RunFilm film = read_film(visible, problem);
  const sim::MujocoArm arm = sim::make_arm(problem);
  std::vector<fs::path> files;
  Attempts attempts;
  const auto add = [&](const std::vector<fs::path>& made) {
    files.insert(files.end(), made.begin(), made.end());
  };
  attempts.try_to([&] {
    add(make_comparison(out, film, arm, problem, options, "comparison",
                        problem.scene.render.card_s));
  });
  attempts.try_to([&] { add(make_orbit(out, film, arm, problem, options)); });
  attempts.try_to([&] {
    if (const auto loops = read_compensation_film(visible, problem))
      add(make_comparison(out, *loops, arm, problem, options, "compensation", 0));
  });
  attempts.try_to([&] {
    if (const auto pushes = read_contact_film(visible, problem))
      add(make_contact_film(out, *pushes, arm, problem, options));
  });
  attempts.finish();
  return files;
}

void render_still(const RunFolder& folder, const scene::Problem& problem, std::optional<double> at,
                  const fs::path& picture, const DrawingOptions& options) {
  const RunFilm film = read_film(folder, problem);
  const double end = film.t[film.t.size() - 1], time = at.value_or(end / 2);
  if (!(time >= 0 && time <= end))
    throw UserError("a still at {:g} s; allowed: 0 to {:.4g} s, the film of the run", time, end);
  const auto context = make_gl_context(options.renderer);
  const sim::MujocoArm arm = sim::make_arm(problem);
  ArmPainter painter(arm, problem.scene.robot.payload_frame, kFilmWidth, kFilmHeight,
                     PaintQuality::final(), context->functions());
  Comparison comparison(film, problem, painter);
  save_png(comparison.still(film.row(time)), picture);
}

}  // namespace fricid::film
