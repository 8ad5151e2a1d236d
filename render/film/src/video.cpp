#include "fricid/film/video.hpp"

#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>

#include "fricid/base/error.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/film/comparison.hpp"
#include "fricid/film/frame_writer.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::film {
namespace {

namespace fs = std::filesystem;

PaintQuality quality_of(const data::RenderConfig& config) {
  if (config.quality == "final") return PaintQuality::final();
  return config.quality == "draft" ? PaintQuality::draft() : PaintQuality::standard();
}

/// Frames as PNG files; for a machine without ffmpeg.
std::vector<std::string> write_pictures(const fs::path& folder, const std::string& name, int count,
                                        const std::function<Image(int)>& frame) {
  std::fprintf(stderr,
               "video: ffmpeg is missing, the frames go to %s as PNG; install ffmpeg for %s.mp4\n",
               (folder / "video" / name).c_str(), name.c_str());
  std::vector<std::string> files;
  Progress progress(name, count);
  for (int k = 0; k < count; ++k) {
    throw_if_stopped();
    files.push_back(fmt::format("video/{}/{:05}.png", name, k + 1));
    save_png(frame(k), folder / files.back());
    progress.advance(1);
  }
  return files;
}

std::vector<std::string> write_video(const fs::path& folder, const std::string& name, int count,
                                     const data::RenderConfig& config,
                                     const std::function<Image(int)>& frame) {
  if (!ffmpeg_found()) return write_pictures(folder, name, count, frame);
  const std::string file = "video/" + name + ".mp4";
  FrameWriter writer(folder / file, kFilmWidth, kFilmHeight, kFilmRate, config.quality == "draft");
  Progress progress(name, count);
  for (int k = 0; k < count; ++k) {
    throw_if_stopped();
    writer.write(frame(k));
    progress.advance(1);
  }
  writer.finish();
  return {file};
}

std::vector<std::string> make_comparison(const fs::path& folder, const RunFilm& film,
                                         const data::Experiment& experiment, ArmPainter& painter) {
  Comparison comparison(film, experiment, painter);
  const int card = static_cast<int>(std::lround(experiment.render.card_s * kFilmRate));
  const int motion = comparison.frames();
  Image opening, closing;
  if (card > 0) {
    opening = comparison.opening_card();
    closing = comparison.closing_card();
  }
  return write_video(folder, "comparison", motion + 2 * card, experiment.render, [&](int k) {
    return k < card ? opening : k < card + motion ? comparison.frame(k - card) : closing;
  });
}

std::vector<std::string> make_orbit(const fs::path& folder, const RunFilm& film,
                                    const data::Experiment& experiment, ArmPainter& painter,
                                    double seconds) {
  const int count = static_cast<int>(std::lround(seconds * kFilmRate));
  const FilmPaths paths = paths_of(film, painter);
  constexpr double kAspect = static_cast<double>(kFilmWidth) / kFilmHeight;
  const double middle = film.t[film.t.size() - 1] / 2;
  View view = telling_view(paths, painter, kAspect);
  view.distance *= 1.15;
  const double first = view.azimuth_deg;
  return write_video(folder, "orbit", count, experiment.render, [&](int k) {
    // the arm moves on while the camera turns once
    const int row = film.row(middle + static_cast<double>(k) / kFilmRate);
    view.azimuth_deg = first + 360.0 * k / count;
    const std::vector<PaintedArm> arms{
        {{film.q.data() + row * film.q.cols(), static_cast<std::size_t>(film.q.cols())}}};
    return painter.paint(view, kFilmWidth, kFilmHeight, arms);
  });
}

}  // namespace

std::vector<std::string> render_video(const fs::path& folder, const data::Experiment& experiment,
                                      const FilmOptions& options) {
  const RunFilm film = read_film(folder, experiment);
  const auto context = make_gl_context(options.renderer);
  const sim::MujocoArm arm = sim::make_arm(experiment);
  ArmPainter painter(arm, experiment.robot.payload_frame, kFilmWidth, kFilmHeight,
                     quality_of(experiment.render));
  std::vector<std::string> files = make_comparison(folder, film, experiment, painter);
  const auto orbit = make_orbit(folder, film, experiment, painter, options.orbit_s);
  files.insert(files.end(), orbit.begin(), orbit.end());
  return files;
}

void render_still(const fs::path& folder, const data::Experiment& experiment,
                  std::optional<double> at, const fs::path& picture, const FilmOptions& options) {
  const RunFilm film = read_film(folder, experiment);
  const auto context = make_gl_context(options.renderer);
  const sim::MujocoArm arm = sim::make_arm(experiment);
  ArmPainter painter(arm, experiment.robot.payload_frame, kFilmWidth, kFilmHeight,
                     PaintQuality::final());
  Comparison comparison(film, experiment, painter);
  save_png(comparison.still(film.row(at.value_or(film.t[film.t.size() - 1] / 2))), picture);
}

}  // namespace fricid::film
