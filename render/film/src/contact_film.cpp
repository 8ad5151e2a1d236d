#include "contact_film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "film_style.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/contact_file.hpp"
#include "fricid/data/loop_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/evaluate/compensation.hpp"
#include "fricid/evaluate/contact.hpp"
#include "fricid/film/chart.hpp"
#include "fricid/film/comparison.hpp"
#include "fricid/film/viewpoint.hpp"
#include "fricid/render/palette.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::film {
namespace {

constexpr double kAlarmShown = 0.3;  // [s] for which an arm stays red
constexpr double kAzimuth = 135;     // [deg]
constexpr Paint kAlarm{0.84f, 0.15f, 0.12f, 1};

}  // namespace

double FilmObserver::level(int row) const {
  double level = 0;
  for (std::size_t j = 0; j < threshold_Nm.size(); ++j)
    level = std::max(level, std::abs(tau_ext(row, static_cast<Eigen::Index>(j))) / threshold_Nm[j]);
  return level;
}

bool ContactFilm::pushed(int row) const {
  return std::ranges::any_of(row_of(tau_ext, row), [](double torque) { return torque != 0; });
}

int ContactFilm::row(double at) const {
  const auto* found = std::lower_bound(t.data(), t.data() + t.size(), at - 1e-9);
  return static_cast<int>(std::min<std::ptrdiff_t>(found - t.data(), t.size() - 1));
}

std::optional<ContactFilm> read_contact_film(const workflow::RunFolder& folder,
                                             const scene::Problem& problem) {
  const auto file = workflow::if_there(folder.contact(), data::load<evaluate::ContactFile>);
  auto loop = workflow::if_there(folder.pushed_loop(), [](const std::filesystem::path& path) {
    return data::load_signals<data::LoopSignals>(path);
  });
  if (!file || !loop) return {};
  std::vector<const evaluate::ContactScore*> fitted;
  for (const evaluate::ContactScore& score : file->models)
    if (score.model != evaluate::kTruthModel && score.method == evaluate::kObserver)
      fitted.push_back(&score);
  if (fitted.empty()) return {};
  const auto* best = *std::ranges::min_element(
      fitted, {}, [](const auto* score) { return evaluate::mean_threshold(*score); });

  ContactFilm film;
  film.scene = problem.scene.name;
  film.joint_names = loop->joint_names;
  film.force_N = file->first_force();
  const auto counted = [&](const RowMatrix& values) -> RowMatrix {
    const auto warm_up = (loop->t.array() < evaluate::kContactWarmUp).count();
    return values.bottomRows(values.rows() - warm_up);
  };
  film.t = counted(loop->t).array() - evaluate::kContactWarmUp;
  if (film.t.size() == 0) return {};
  film.q = counted(loop->q);
  film.tau_ext = counted(loop->tau_ext);
  double largest = -1;
  for (int j = 0; j < static_cast<int>(film.tau_ext.cols()); ++j)
    if (const double load = film.tau_ext.col(j).squaredNorm(); load > largest) {
      largest = load;
      film.joint = j;
    }
  const auto evaluation = data::load<evaluate::Evaluation>(folder.evaluation());
  const auto models = render::models_of_run(evaluation, folder);
  std::vector<const evaluate::ContactScore*> shown{fitted.front()};
  if (best != shown.front()) shown.push_back(best);
  for (const evaluate::ContactScore* score : shown) {
    const auto model = std::ranges::find(models, score->model, &render::RunModel::name);
    film.observers.push_back(
        {score->label, model == models.end() ? "#000000" : model->look.colour,
         counted(data::load_signals<data::ContactSignals>(folder.external_torque(score->model))
                     .tau_ext),
         score->threshold_Nm});
  }
  return film;
}

ContactFrames::ContactFrames(const ContactFilm& film, ArmPainter& painter)
    : film_(film), painter_(painter) {
  std::vector<Eigen::Vector3d> outline;
  constexpr int kStride = 50;
  for (int row = 0; row < static_cast<int>(film.t.size()); row += kStride) {
    const auto joints = painter.joints(row_of(film.q, row));
    outline.insert(outline.end(), joints.begin(), joints.end());
  }
  const double aspect =
      kFilmWidth / (kStripsTop - kHeader) / static_cast<double>(film.observers.size());
  view_ = view_of(outline, kAzimuth, kFrontElevation, painter.field_of_view(), aspect);
  view_.distance *= 1.1;
  std::vector<double> torques(film.tau_ext.col(film.joint).begin(),
                              film.tau_ext.col(film.joint).end());
  for (const FilmObserver& observer : film.observers)
    torques.insert(torques.end(), observer.tau_ext.col(film.joint).begin(),
                   observer.tau_ext.col(film.joint).end());
  range_ = range_of(torques, 0.06);
}

int frames_of(const ContactFilm& film) {
  return std::max(1, static_cast<int>(std::lround(film.t[film.t.size() - 1] * kFilmRate)));
}

void ContactFrames::draw_arm(Canvas& canvas, const FilmObserver& observer, const Box& box,
                             int row) {
  bool alarm = false;
  for (int k = film_.row(film_.t[row] - kAlarmShown); k <= row; ++k)
    alarm = alarm || observer.level(k) > 1;
  const std::vector<PaintedArm> arms{{row_of(film_.q, row), alarm ? kAlarm : kPlainArm}};
  painter_.keep_backdrop(view_, static_cast<int>(box.width), static_cast<int>(box.height));
  canvas.picture(
      painter_.paint(view_, static_cast<int>(box.width), static_cast<int>(box.height), arms), box);
  canvas.fill({box.x + 10, box.y + 10, box.width - 20, 32}, kVeil, 6);
  canvas.fill({box.x + 20, box.y + 19, 22, 13}, paint_of(observer.colour), 3);
  canvas.text({box.x + 52, box.y + 31}, "observer with " + observer.label,
              {.size = 15, .paint = kInk, .bold = true});
  if (alarm)
    canvas.text({box.x + box.width - 20, box.y + 31}, film_.pushed(row) ? "contact" : "alarm",
                {.size = 15, .paint = kAlarm, .align = Align::kRight, .bold = true});
}

void ContactFrames::draw_strips(Canvas& canvas, int row) const {
  const double top = kStripsTop + 4, height = kFilmHeight - kStripsTop - 6, half = kFilmWidth / 2.0;
  const double now = film_.t[row], first_s = std::max(0.0, now - kPast);
  std::vector<double> t, truth;
  std::vector<std::vector<double>> torques(film_.observers.size()), levels(film_.observers.size());
  constexpr double kLeast = 0.02, kMost = 30;  // of the levels shown
  for (int k = film_.row(first_s); k <= row; ++k) {
    t.push_back(film_.t[k]);
    truth.push_back(film_.tau_ext(k, film_.joint));
    for (std::size_t m = 0; m < film_.observers.size(); ++m) {
      torques[m].push_back(film_.observers[m].tau_ext(k, film_.joint));
      levels[m].push_back(std::clamp(film_.observers[m].level(k), kLeast, kMost));
    }
  }
  const Chart torque(
      {0, top, half, height},
      "external torque (grey: true), " + film_.joint_names[static_cast<std::size_t>(film_.joint)],
      {first_s, first_s + kPast, false, "t [s]"}, {range_.first, range_.second, false, "N m"});
  torque.draw_axes(canvas);
  torque.draw_curve(canvas, t, truth, {.width = 4, .paint = kTruth});
  const Chart level({half, top, half, height}, "largest torque over its threshold",
                    {first_s, first_s + kPast, false, "t [s]"}, {kLeast, kMost, true, "1"});
  level.draw_axes(canvas);
  const std::vector<double> ends{first_s, first_s + kPast}, one{1, 1};
  level.draw_curve(canvas, ends, one, {.width = 1.3, .paint = kInk, .dashed = true});
  for (std::size_t m = 0; m < film_.observers.size(); ++m) {
    const LineStyle style{.width = 1.6, .paint = paint_of(film_.observers[m].colour)};
    torque.draw_curve(canvas, t, torques[m], style);
    level.draw_curve(canvas, t, levels[m], style);
  }
}

Image ContactFrames::frame(int index) {
  const int row = film_.row(static_cast<double>(index) / kFilmRate);
  Canvas canvas(kFilmWidth, kFilmHeight);
  const double count = static_cast<double>(film_.observers.size());
  const double width = std::floor((kFilmWidth - kGap * (count - 1)) / count);
  for (std::size_t m = 0; m < film_.observers.size(); ++m)
    draw_arm(canvas, film_.observers[m],
             {static_cast<double>(m) * (width + kGap), kHeader, width, kStripsTop - kHeader}, row);
  const TextStyle title{.size = 19, .paint = kInk, .bold = true};
  canvas.fill({0, 0, kFilmWidth, kHeader}, {1, 1, 1, 1});
  canvas.text({16, 29}, film_.scene, title);
  const double after = 16 + canvas.text_width(film_.scene, title) + 14;
  if (film_.pushed(row))
    canvas.text({after, 29}, fmt::format("a push of {:g} N", film_.force_N),
                {.size = 15, .paint = kAlarm, .bold = true});
  else
    canvas.text({after, 29}, "external torque along a task", {.size = 15, .paint = kFaint});
  canvas.text({kFilmWidth - 16, 29},
              fmt::format("t = {:5.2f} s of {:.1f} s", film_.t[row], film_.t[film_.t.size() - 1]),
              {.size = 17, .paint = kInk, .align = Align::kRight, .bold = true});
  draw_strips(canvas, row);
  return canvas.image();
}

}  // namespace fricid::film
