#include "plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fricid/film/paint.hpp"

namespace fricid::viewer {
namespace {

constexpr float kLeft = 52, kRight = 10, kTop = 24, kBottom = 36;
constexpr ImU32 kInk = IM_COL32(40, 40, 45, 255), kFaint = IM_COL32(105, 105, 110, 255),
                kGrid = IM_COL32(224, 224, 228, 255), kPaper = IM_COL32(255, 255, 255, 255);

float share_of(const film::Axis& axis, double value) {
  const double share =
      axis.log ? std::log(std::max(value, 1e-300) / axis.low) / std::log(axis.high / axis.low)
               : (value - axis.low) / (axis.high - axis.low);
  return static_cast<float>(std::clamp(share, -1.0, 2.0));
}

}  // namespace

ImU32 colour_of(const std::string& colour) {
  const film::Paint paint = film::paint_of(colour);
  return ImGui::ColorConvertFloat4ToU32({paint.red, paint.green, paint.blue, 1});
}

void draw_plot(const ImVec2& from, const ImVec2& size, const std::string& title,
               const film::Axis& x, const film::Axis& y, const std::vector<Line>& lines) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 to(from.x + size.x, from.y + size.y);
  const ImVec2 low(from.x + kLeft, to.y - kBottom), high(to.x - kRight, from.y + kTop);
  const auto at = [&](double px, double py) {
    return ImVec2(low.x + (high.x - low.x) * share_of(x, px),
                  low.y + (high.y - low.y) * share_of(y, py));
  };
  list.AddRectFilled(from, to, kPaper, 4);
  list.AddText({low.x, from.y + 5}, kInk, title.c_str());
  const auto label = [](double value) {
    return fmt::format("{:g}", std::abs(value) < 1e-12 ? 0 : value);
  };
  for (const double tick : film::ticks_of(x, static_cast<int>((high.x - low.x) / 60))) {
    const ImVec2 foot = at(tick, y.low);
    const std::string text = label(tick);
    list.AddLine(foot, {foot.x, high.y}, kGrid);
    list.AddText({foot.x - ImGui::CalcTextSize(text.c_str()).x / 2, low.y + 3}, kFaint,
                 text.c_str());
  }
  for (const double tick : film::ticks_of(y, static_cast<int>((low.y - high.y) / 30))) {
    const ImVec2 foot = at(x.low, tick);
    const std::string text = label(tick);
    list.AddLine(foot, {high.x, foot.y}, kGrid);
    list.AddText({low.x - 5 - ImGui::CalcTextSize(text.c_str()).x, foot.y - 7}, kFaint,
                 text.c_str());
  }
  list.AddLine(low, {high.x, low.y}, kInk);
  list.AddLine(low, {low.x, high.y}, kInk);
  list.AddText({(low.x + high.x) / 2 - ImGui::CalcTextSize(x.label.c_str()).x / 2, low.y + 18},
               kInk, x.label.c_str());
  list.AddText({from.x + 5, from.y + 5}, kFaint, y.label.c_str());

  list.PushClipRect({low.x, high.y}, {high.x, low.y}, true);
  std::vector<ImVec2> points;
  for (const Line& line : lines) {
    points.clear();
    for (std::size_t i = 0; i < line.x.size(); ++i) points.push_back(at(line.x[i], line.y[i]));
    if (line.dots) {
      for (const ImVec2& point : points)
        list.AddCircleFilled(point, line.width / 2, colour_of(line.colour));
      continue;
    }
    list.AddPolyline(points.data(), static_cast<int>(points.size()), colour_of(line.colour), 0,
                     line.width);
    if (!points.empty()) list.AddCircleFilled(points.back(), 4, colour_of(line.colour));
  }
  list.PopClipRect();
}

}  // namespace fricid::viewer
