#include "fricid/film/comparison.hpp"

#include <algorithm>
#include <cmath>

#include "cards.hpp"
#include "film_style.hpp"
#include "fricid/base/error.hpp"
#include "fricid/render/palette.hpp"

namespace fricid::film {
namespace {

constexpr int kMainWidth = 860;       // of the picture with all arms; the enlarged one has the rest
constexpr double kInset = 230;        // side of an enlarged picture in another
constexpr double kTrailPast = 1.5;    // [s] of path behind each tip
constexpr double kLeastZoom = 0.15;   // [m] half height, so that a flange is recognised
constexpr double kLeastInset = 0.04;  // [m] the same where millimetres matter
constexpr double kTipMargin = 0.06;   // [m] around the joints' paths
constexpr double kPortraitTurn = 35;  // [deg] from the view of the film
constexpr float kGhost = 0.65f;       // opacity
constexpr std::size_t kMostPoints = 1000;  // of a curve

constexpr Paint kDarkTruth{0.3f, 0.3f, 0.3f, 1};

std::string millimetres(double value) {
  return fmt::format("{:.{}f} mm", value, value < 0.995 ? 2 : value < 99.95 ? 1 : 0);
}

/// Rows first..last, thinned.
std::vector<int> rows_between(int first, int last) {
  const int stride = 1 + (last - first) / static_cast<int>(kMostPoints);
  std::vector<int> rows;
  for (int row = first; row < last; row += stride) rows.push_back(row);
  rows.push_back(last);
  return rows;
}

template <class Values>
std::vector<double> picked(const Values& values, const std::vector<int>& rows) {
  std::vector<double> result;
  for (const int row : rows) result.push_back(values[row]);
  return result;
}

}  // namespace

int frames_of(const RunFilm& film) {
  return std::max(1, static_cast<int>(std::lround(film.t[film.t.size() - 1] * kFilmRate)));
}

Comparison::Comparison(const RunFilm& film, const scene::Problem& problem, ArmPainter& painter)
    : film_(film),
      painter_(painter),
      side_by_side_(film.layout == Layout::kSideBySide),
      paths_(paths_of(film, painter)),
      joint_(most_telling_joint(film)) {
  if (const std::string& wanted = problem.scene.render.joint; !wanted.empty()) {
    const auto& names = film.joint_names;
    const auto found = std::find(names.begin(), names.end(), wanted);
    if (found == names.end())
      throw UserError("[render] joint: found {}; allowed: {}", wanted, fmt::join(names, ", "));
    joint_ = static_cast<int>(found - names.begin());
  }

  // errors of the tips
  for (std::size_t m = 0; m <= film.models.size(); ++m) {
    const auto& tips = m < film.models.size() ? paths_.models[m] : paths_.oracle;
    std::vector<double> errors;
    for (std::size_t k = 0; k < tips.size(); ++k)
      errors.push_back(1e3 * (tips[k] - paths_.truth[k]).norm());
    errors_mm_.push_back(std::move(errors));
  }
  std::vector<double> all;
  for (const auto& errors : errors_mm_) all.insert(all.end(), errors.begin(), errors.end());
  std::erase_if(all, [](double error) { return !(error > 0); });
  std::sort(all.begin(), all.end());
  error_range_ = {0.01, 1000};
  if (!all.empty()) {
    error_range_.first = std::pow(10, std::floor(std::log10(all[all.size() / 50])));
    error_range_.second =
        std::max(std::pow(10, std::ceil(std::log10(all.back()))), 10 * error_range_.first);
  }

  // the camera
  const double aspect =
      side_by_side_ ? kFilmWidth / (kStripsTop - kHeader) / static_cast<double>(film.models.size())
                    : kMainWidth / (kStripsTop - kHeader);
  if (const auto& angles = problem.scene.render.camera_deg; angles.size() == 2)
    view_ = view_of(paths_.outline, angles[0], angles[1], painter.field_of_view(), aspect);
  else
    view_ = telling_view(paths_, painter, aspect);
  view_.distance += kTipMargin / std::tan(painter.field_of_view() / 2);
  portrait_ = view_of(paths_.outline, view_.azimuth_deg + kPortraitTurn, view_.elevation_deg,
                      painter.field_of_view(), 0.5 * kFilmWidth / kFilmHeight);

  std::vector<double> model_errors;
  for (std::size_t m = 0; m < film.models.size(); ++m)
    model_errors.insert(model_errors.end(), errors_mm_[m].begin(), errors_mm_[m].end());
  std::sort(model_errors.begin(), model_errors.end());
  zoom_ = std::max(film.enlarged_flange ? kLeastInset : kLeastZoom,
                   1.3e-3 * model_errors[model_errors.size() * 9 / 10]);

  // ranges of the strips
  std::vector<double> torques, speeds;
  const auto add = [&](const RowMatrix& tau_f, const RowMatrix& v) {
    if (tau_f.size() == 0) return;
    torques.insert(torques.end(), tau_f.col(joint_).begin(), tau_f.col(joint_).end());
    speeds.insert(speeds.end(), v.col(joint_).begin(), v.col(joint_).end());
  };
  add(film.tau_f, film.v);
  for (const FilmModel& model : film.models) add(model.tau_f, model.v);
  torque_range_ = range_of(torques, 0.06);
  speed_range_ = range_of(speeds, 0.04);
}

double Comparison::error_mm(std::size_t model, int row) const {
  return errors_mm_[model][static_cast<std::size_t>(row)];
}

Image Comparison::frame(int index) {
  const int row = film_.row(static_cast<double>(index) / kFilmRate);
  Canvas canvas(kFilmWidth, kFilmHeight);
  if (side_by_side_)
    draw_side_by_side(canvas, row);
  else
    draw_ghosts(canvas, row);
  draw_header(canvas, row);
  draw_strips(canvas, row);
  return canvas.image();
}

std::vector<Trail> Comparison::trails(int row) const {
  std::vector<Trail> trails;
  const int first = film_.row(film_.t[row] - kTrailPast);
  const auto add = [&](const std::vector<Eigen::Vector3d>& tips, const Paint& paint) {
    Trail trail{{}, paint};
    for (int k = first; k < row; k += 5) trail.points.push_back(tips[static_cast<std::size_t>(k)]);
    trail.points.push_back(tips[static_cast<std::size_t>(row)]);
    trails.push_back(std::move(trail));
  };
  add(paths_.truth, kDarkTruth);
  for (std::size_t m = 0; m < film_.models.size(); ++m)
    add(paths_.models[m], paint_of(film_.models[m].colour));
  return trails;
}

std::vector<PaintedArm> Comparison::arms(int row) const {
  std::vector<PaintedArm> arms{{row_of(film_.q, row), kPlainArm}};
  for (const FilmModel& model : film_.models)
    arms.push_back({row_of(model.q, row), paint_of(model.colour, kGhost)});
  return arms;
}

void Comparison::draw_ghosts(Canvas& canvas, int row) {
  const auto picture = [&](const View& view, const Box& box) {
    canvas.picture(painter_.paint(view, static_cast<int>(box.width), static_cast<int>(box.height),
                                  arms(row), trails(row)),
                   box);
  };
  const double height = kStripsTop - kHeader;
  painter_.keep_backdrop(view_, kMainWidth, static_cast<int>(height));
  picture(view_, {0, kHeader, kMainWidth, height});

  const Box zoomed{kMainWidth + kGap, kHeader, kFilmWidth - kMainWidth - kGap, height};
  picture(close_view(row), zoomed);
  draw_scale(canvas, zoomed);
  canvas.fill({zoomed.x + 10, kHeader + 10, 150, 26}, kVeil, 6);
  canvas.text({zoomed.x + 20, kHeader + 28}, "flange, enlarged", {.size = 13, .paint = kInk});
  draw_legend(canvas, row);
}

View Comparison::close_view(int row) const {
  View close = view_;
  close.target = paths_.truth[static_cast<std::size_t>(row)];
  close.distance = zoom_ / std::tan(painter_.field_of_view() / 2);
  return close;
}

void Comparison::draw_scale(Canvas& canvas, const Box& zoomed) const {
  const double length_mm = 2e3 * zoom_ / 4;
  double bar_mm = std::pow(10, std::floor(std::log10(length_mm)));
  for (const double factor : {5.0, 2.0})
    if (factor * bar_mm <= length_mm) {
      bar_mm *= factor;
      break;
    }
  const double bar = bar_mm * 1e-3 / (2 * zoom_) * zoomed.height;
  const double right = zoomed.x + zoomed.width - 16, below = zoomed.y + zoomed.height - 18;
  canvas.fill({right - bar - 12, below - 26, bar + 24, 38}, kVeil, 6);
  canvas.line(std::vector<Point>{{right - bar, below}, {right, below}},
              {.width = 3, .paint = kInk});
  canvas.text({right - bar / 2, below - 8}, fmt::format("{:g} mm", bar_mm),
              {.size = 13, .paint = kInk, .align = Align::kCentre});
}

void Comparison::draw_legend(Canvas& canvas, int row) const {
  constexpr double kRow = 22, kLeft = 12, kTop = kHeader + 10;
  double label_width = 0;
  for (const FilmModel& model : film_.models)
    label_width = std::max(label_width, canvas.text_width(model.label, {.size = 14, .bold = true}));
  label_width = std::max(label_width, 70.0);
  const double rows = static_cast<double>(film_.models.size()) + 2;
  canvas.fill({kLeft, kTop, label_width + 225, kRow * rows + 10}, kVeil, 6);
  const double now = kLeft + label_width + 130, rms = kLeft + label_width + 215;
  canvas.text({now, kTop + 20}, "tip error", {.size = 12, .paint = kFaint, .align = Align::kRight});
  canvas.text({rms, kTop + 20}, "RMS so far",
              {.size = 12, .paint = kFaint, .align = Align::kRight});
  const auto line = [&](std::size_t i, const Paint& paint, const std::string& label) {
    const double y = kTop + kRow * static_cast<double>(i + 1) + 20;
    canvas.fill({kLeft + 10, y - 11, 22, 12}, paint, 3);
    canvas.text({kLeft + 42, y}, label, {.size = 14, .paint = kInk, .bold = true});
    return y;
  };
  line(0, kTruth, film_.words.base);
  for (std::size_t m = 0; m < film_.models.size(); ++m) {
    const double y = line(m + 1, paint_of(film_.models[m].colour), film_.models[m].label);
    double squares = 0;
    for (int k = 0; k <= row; ++k) squares += std::pow(error_mm(m, k), 2);
    canvas.text({now, y}, millimetres(error_mm(m, row)),
                {.size = 14, .paint = kInk, .align = Align::kRight});
    canvas.text({rms, y}, millimetres(std::sqrt(squares / (row + 1))),
                {.size = 14, .paint = kInk, .align = Align::kRight});
  }
}

void Comparison::draw_side_by_side(Canvas& canvas, int row) {
  const double count = static_cast<double>(film_.models.size());
  const double width = std::floor((kFilmWidth - kGap * (count - 1)) / count);
  for (std::size_t m = 0; m < film_.models.size(); ++m) {
    const FilmModel& model = film_.models[m];
    const std::vector<PaintedArm> arms{{row_of(film_.q, row), kPlainArm},
                                       {row_of(model.q, row), paint_of(model.colour, kGhost)}};
    std::vector<Trail> both = trails(row);
    both = {both[0], both[m + 1]};
    const Box box{static_cast<double>(m) * (width + kGap), kHeader, width, kStripsTop - kHeader};
    canvas.picture(painter_.paint(view_, static_cast<int>(box.width), static_cast<int>(box.height),
                                  arms, both),
                   box);
    if (film_.enlarged_flange) {
      const Box inset{box.x + box.width - kInset - 10, box.y + box.height - kInset - 10, kInset,
                      kInset};
      canvas.fill({inset.x - 2, inset.y - 2, kInset + 4, kInset + 4}, kInk);
      canvas.picture(painter_.paint(close_view(row), static_cast<int>(kInset),
                                    static_cast<int>(kInset), arms, both),
                     inset);
      draw_scale(canvas, inset);
    }
    canvas.fill({box.x + 10, kHeader + 10, width - 20, 32}, kVeil, 6);
    canvas.fill({box.x + 20, kHeader + 19, 22, 13}, paint_of(model.colour), 3);
    canvas.text({box.x + 52, kHeader + 31}, model.label, {.size = 15, .paint = kInk, .bold = true});
    canvas.text({box.x + width - 20, kHeader + 31}, "tip error " + millimetres(error_mm(m, row)),
                {.size = 14, .paint = kInk, .align = Align::kRight});
  }
}

void Comparison::draw_header(Canvas& canvas, int row) const {
  const TextStyle title{.size = 19, .paint = kInk, .bold = true};
  canvas.fill({0, 0, kFilmWidth, kHeader}, {1, 1, 1, 1});
  canvas.text({16, 29}, film_.scene, title);
  canvas.text({16 + canvas.text_width(film_.scene, title) + 14, 29},
              film_.words.motion + (side_by_side_ ? "; grey: " + film_.words.base : ""),
              {.size = 15, .paint = kFaint});
  canvas.text({kFilmWidth - 16, 29},
              fmt::format("t = {:5.2f} s of {:.1f} s", film_.t[row], film_.t[film_.t.size() - 1]),
              {.size = 17, .paint = kInk, .align = Align::kRight, .bold = true});
}

void Comparison::draw_strips(Canvas& canvas, int row) const {
  const double top = kStripsTop + 4, height = kFilmHeight - kStripsTop - 6;
  const std::string& joint = film_.joint_names[static_cast<std::size_t>(joint_)];
  const double now = film_.t[row], first_s = std::max(0.0, now - kPast);
  const std::vector<int> recent = rows_between(film_.row(first_s), row);
  const std::vector<int> so_far = rows_between(0, row);
  const LineStyle thick{.width = 4, .paint = kTruth}, thin{.width = 1.6};
  const auto style_of = [&](const FilmModel& model) {
    LineStyle style = thin;
    style.paint = paint_of(model.colour);
    return style;
  };

  const Chart torque({0, top, 470, height}, film_.words.torque + ", " + joint,
                     {first_s, first_s + kPast, false, "t [s]"},
                     {torque_range_.first, torque_range_.second, false, "N m"});
  torque.draw_axes(canvas);
  const std::vector<double> t = picked(film_.t, recent);
  if (film_.has_truth())
    torque.draw_curve(canvas, t, picked(film_.tau_f.col(joint_), recent), thick);
  for (const FilmModel& model : film_.models)
    torque.draw_curve(canvas, t, picked(model.tau_f.col(joint_), recent), style_of(model));

  const Chart error({470, top, 460, height}, film_.words.error,
                    {0, film_.t[film_.t.size() - 1], false, "t [s]"},
                    {error_range_.first, error_range_.second, true, "mm"});
  error.draw_axes(canvas);
  const std::vector<double> all_t = picked(film_.t, so_far);
  const auto picked_error = [&](std::size_t m) {
    std::vector<double> values;
    for (const int k : so_far) values.push_back(std::max(error_mm(m, k), 1e-12));
    return values;
  };
  if (!errors_mm_.back().empty())
    error.draw_curve(canvas, all_t, picked_error(film_.models.size()),
                     {.width = 1.3, .paint = kInk, .dashed = true});
  for (std::size_t m = 0; m < film_.models.size(); ++m) {
    error.draw_curve(canvas, all_t, picked_error(m), style_of(film_.models[m]));
    error.draw_point(canvas, now, error_mm(m, row), 4, paint_of(film_.models[m].colour));
  }

  const Chart loop({930, top, 350, height}, "friction loop, " + joint,
                   {speed_range_.first, speed_range_.second, false, "velocity [rad/s]"},
                   {torque_range_.first, torque_range_.second, false, "N m"});
  loop.draw_axes(canvas);
  const auto draw_loop = [&](const RowMatrix& v, const RowMatrix& tau_f, const LineStyle& style) {
    loop.draw_curve(canvas, picked(v.col(joint_), recent), picked(tau_f.col(joint_), recent),
                    style);
    loop.draw_point(canvas, v(row, joint_), tau_f(row, joint_), 2 + style.width, style.paint);
  };
  if (film_.has_truth()) draw_loop(film_.v, film_.tau_f, thick);
  for (const FilmModel& model : film_.models) draw_loop(model.v, model.tau_f, style_of(model));
}

Image Comparison::still(int row) {
  return painter_.paint(view_, kFilmWidth, kFilmHeight, arms(row), trails(row));
}

Image Comparison::opening_card() {
  const std::vector<PaintedArm> arms{{row_of(film_.q, 0)}};
  return draw_opening_card(film_, painter_.paint(portrait_, kFilmWidth / 2, kFilmHeight, arms));
}

Image Comparison::closing_card() { return draw_closing_card(film_); }

}  // namespace fricid::film
