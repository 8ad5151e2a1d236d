#include "panels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fricid/render/palette.hpp"
#include "plot.hpp"

namespace fricid::viewer {
namespace {

constexpr float kSide = 380, kStrip = 230, kGap = 6;
constexpr double kReplayPast = 4;        // [s] of friction shown
constexpr double kLeastHistory = 2;      // [s] on the time axis of the live arm
constexpr double kFramesPerSecond = 30;  // of single steps
constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus |
                                    ImGuiWindowFlags_NoSavedSettings;
constexpr const char* kBeginningColour = "#C4C4C9";

void draw_transport(Stage& stage) {
  if (stage.film && stage.live) {
    int mode = static_cast<int>(stage.mode);
    ImGui::RadioButton("replay", &mode, static_cast<int>(Mode::kReplay));
    ImGui::SameLine();
    ImGui::RadioButton("live arm", &mode, static_cast<int>(Mode::kLive));
    stage.mode = static_cast<Mode>(mode);
  }
  if (ImGui::Button(stage.playing ? "pause" : "play")) stage.playing = !stage.playing;
  ImGui::SameLine();
  if (ImGui::Button("step")) {
    stage.playing = false;
    if (stage.mode == Mode::kLive)
      stage.live->step();
    else
      stage.seek(stage.t + 1.0 / kFramesPerSecond);
  }
  ImGui::SameLine();
  if (ImGui::Button("reset")) stage.reset();
  ImGui::SameLine();
  float speed = static_cast<float>(stage.speed);
  ImGui::SetNextItemWidth(110);
  if (ImGui::SliderFloat("speed", &speed, 0.05f, 4, "%.2f x", ImGuiSliderFlags_Logarithmic))
    stage.speed = static_cast<double>(speed);
}

void draw_joints(Stage& stage) {
  const auto& joints = stage.problem.robot.joints;
  const auto& shown = joints[static_cast<std::size_t>(stage.joint)].name;
  if (ImGui::BeginCombo("joint", shown.c_str())) {
    for (std::size_t j = 0; j < joints.size(); ++j)
      if (ImGui::Selectable(joints[j].name.c_str(), stage.joint == static_cast<int>(j)))
        stage.joint = static_cast<int>(j);
    ImGui::EndCombo();
  }
}

void draw_models(Stage& stage) {
  ImGui::TextUnformatted("Models (ghosts)");
  for (std::size_t m = 0; m < stage.film->models.size(); ++m) {
    const film::FilmModel& model = stage.film->models[m];
    bool visible = stage.visible[m];
    ImGui::PushStyleColor(ImGuiCol_CheckMark, colour_of(model.colour));
    if (ImGui::Checkbox(model.label.c_str(), &visible)) stage.visible[m] = visible;
    ImGui::PopStyleColor();
    const double e = (model.q.row(stage.row()) - stage.film->q.row(stage.row())).norm();
    ImGui::SameLine(150);
    ImGui::Text("%.4f rad off", e);
  }
}

void draw_push(Stage& stage) {
  LiveArm& live = *stage.live;
  Push& push = live.push;
  if (push.joint != stage.joint) push = {.joint = stage.joint};
  const double effort = stage.problem.robot.joints[static_cast<std::size_t>(stage.joint)].effort;
  const double most = effort > 0 ? 0.3 * effort : 50;
  const auto slide = [](const char* name, double& value, double low, double high,
                        const char* format) {
    return ImGui::SliderScalar(name, ImGuiDataType_Double, &value, &low, &high, format);
  };
  if (ImGui::RadioButton("gentle swing", live.swings)) live.swings = true;
  ImGui::SameLine();
  if (ImGui::RadioButton("push this joint by hand", !live.swings)) live.swings = false;
  bool pushed = slide("torque", push.torque, -most, most, "%.2f N m");
  pushed |= slide("amplitude", push.amplitude, 0, most, "%.2f N m");
  pushed |= slide("frequency", push.frequency_hz, 0.05, 5, "%.2f Hz");
  if (ImGui::Button("let go")) {
    push.torque = push.amplitude = 0;
    pushed = true;
  }
  if (pushed) live.swings = false;
}

void draw_parameters(Stage& stage) {
  const friction::Friction& friction = stage.live->friction();
  const auto& parameters = friction.model.parameters();
  ImGui::TextUnformatted("Friction of this joint");
  ImGui::BeginChild("parameters");
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const friction::ParameterRef& parameter = parameters[i];
    if (parameter.joint != stage.joint) continue;
    // sliders end at four times the typical value
    const double low = std::max(parameter.info.lower, -4 * std::abs(parameter.info.typical));
    const double high =
        std::min(parameter.info.upper,
                 4 * std::max(std::abs(parameter.info.typical), std::abs(friction.theta[i])));
    double value = friction.theta[i];
    const std::string name = fmt::format("{}##{}", parameter.symbol, i);
    const std::string format =
        fmt::format("%.4g {}", parameter.info.has_unit() ? parameter.info.unit : "");
    ImGui::SetNextItemWidth(210);
    if (ImGui::SliderScalar(name.c_str(), ImGuiDataType_Double, &value, &low, &high,
                            format.c_str()))
      stage.live->set_parameter(static_cast<int>(i), value);
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("%s: %s", parameter.owner.c_str(),
                        std::string(parameter.info.meaning).c_str());
  }
  ImGui::EndChild();
}

/// Friction torque against velocity.
void draw_loop(const Stage& stage, const ImVec2& from, const ImVec2& size) {
  std::vector<Line> lines;
  std::vector<double> all_v, all_tau;
  const auto j = static_cast<std::size_t>(stage.joint);
  if (stage.mode == Mode::kLive) {
    Line line{{}, {}, kLiveColour, 1.8f};
    for (const Moment& moment : stage.live->history()) {
      line.x.push_back(moment.v[j]);
      line.y.push_back(moment.tau_f[j]);
    }
    all_v = line.x;
    all_tau = line.y;
    lines.push_back(std::move(line));
  } else {
    const int last = stage.row(), first = stage.film->row(stage.t - kReplayPast);
    const auto add = [&](const film::RowMatrix& v, const film::RowMatrix& tau_f,
                         const std::string& colour, float width) {
      if (v.size() == 0) return;
      Line line{{}, {}, colour, width};
      for (int k = first; k <= last; k += 2) {
        line.x.push_back(v(k, stage.joint));
        line.y.push_back(tau_f(k, stage.joint));
      }
      all_v.insert(all_v.end(), v.col(stage.joint).begin(), v.col(stage.joint).end());
      all_tau.insert(all_tau.end(), tau_f.col(stage.joint).begin(), tau_f.col(stage.joint).end());
      lines.push_back(std::move(line));
    };
    if (stage.film->has_truth()) add(stage.film->v, stage.film->tau_f, render::kTruthColour, 4);
    for (std::size_t m = 0; m < stage.film->models.size(); ++m)
      if (stage.visible[m]) {
        const film::FilmModel& model = stage.film->models[m];
        add(model.v, model.tau_f, model.colour, 1.8f);
      }
  }
  const auto [v_low, v_high] = film::range_of(all_v, 0.05);
  const auto [tau_low, tau_high] = film::range_of(all_tau, 0.08);
  draw_plot(from, size, "friction torque, " + stage.problem.robot.joints[j].name,
            {v_low, v_high, false, "velocity [rad/s]"}, {tau_low, tau_high, false, "N m"}, lines);
}

/// Replay: error of the joint angles against time; live: friction torque against time.
void draw_history(Stage& stage, const ImVec2& from, const ImVec2& size) {
  std::vector<Line> lines;
  if (stage.mode == Mode::kLive) {
    const auto j = static_cast<std::size_t>(stage.joint);
    Line line{{}, {}, kLiveColour, 1.8f};
    for (const Moment& moment : stage.live->history()) {
      line.x.push_back(moment.t);
      line.y.push_back(moment.tau_f[j]);
    }
    const auto [low, high] = film::range_of(line.y, 0.08);
    const double end = std::max(stage.live->time(), kLeastHistory);
    lines.push_back(std::move(line));
    return draw_plot(from, size, "friction torque against time",
                     {std::max(end - LiveArm::kHistory, 0.0), end, false, "t [s]"},
                     {low, high, false, "N m"}, lines);
  }
  const film::RunFilm& film = *stage.film;
  std::vector<double> all;
  for (std::size_t m = 0; m < film.models.size(); ++m) {
    if (!stage.visible[m]) continue;
    Line line{{}, {}, film.models[m].colour, 1.8f};
    for (int k = 0; k <= stage.row(); k += 1 + stage.row() / 1000) {
      line.x.push_back(film.t[k]);
      line.y.push_back(std::max((film.models[m].q.row(k) - film.q.row(k)).norm(), 1e-6));
    }
    all.insert(all.end(), line.y.begin(), line.y.end());
    lines.push_back(std::move(line));
  }
  draw_plot(from, size, "error of the joint angles", {0, film.t[film.t.size() - 1], false, "t [s]"},
            {1e-5, 1, true, "rad"}, lines);
}

/// Latent states of the shown joint: the last two, or the only one and the torque.
void draw_cloud(Stage& stage, const ImVec2& from, const ImVec2& size) {
  const std::optional<ShownCloud> shown = stage.cloud();
  if (!shown) {
    ImGui::TextUnformatted("no state to show at this joint");
    return;
  }
  const LatentCloud& cloud = shown->cloud;
  const Eigen::Index latents = cloud.to.cols(), last = latents - 1;
  const auto scatter = [&](const RowMatrix& z, const Eigen::VectorXd& tau,
                           const std::string& colour, float width) {
    const Eigen::VectorXd x = z.col(std::max<Eigen::Index>(last - 1, 0)),
                          y = latents > 1 ? Eigen::VectorXd(z.col(last)) : tau;
    return Line{{x.begin(), x.end()}, {y.begin(), y.end()}, colour, width, true};
  };
  const std::vector<Line> lines{
      scatter(cloud.from, cloud.from_tau, kBeginningColour, 5),
      scatter(cloud.to, cloud.tau, shown->colour, 5),
      scatter(cloud.state, Eigen::VectorXd::Constant(1, cloud.state_tau), "#000000", 7)};
  std::vector<double> x, y;
  for (const Line& line : lines) {
    x.insert(x.end(), line.x.begin(), line.x.end());
    y.insert(y.end(), line.y.begin(), line.y.end());
  }
  const auto [x_low, x_high] = film::range_of(x, 0.08);
  const auto [y_low, y_high] = film::range_of(y, 0.08);
  ImGui::Text("torque spread %.2g (grey) to %.2g N m", spread(cloud.from_tau), spread(cloud.tau));
  draw_plot(from, size,
            fmt::format("{}: {} starts, {:.2f} s later", shown->label, cloud.to.rows(), shown->age),
            {x_low, x_high, false, fmt::format("z{}", std::max<Eigen::Index>(last, 1))},
            {y_low, y_high, false, latents > 1 ? fmt::format("z{}", latents) : "N m"}, lines);
}

void drag_camera(Stage& stage) {
  if (!ImGui::IsItemHovered()) return;
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsMouseDragging(ImGuiMouseButton_Left)) {
    stage.view.azimuth_deg -= 0.3 * static_cast<double>(io.MouseDelta.x);
    stage.view.elevation_deg = std::clamp(
        stage.view.elevation_deg - 0.3 * static_cast<double>(io.MouseDelta.y), -89.0, 89.0);
  }
  if (io.MouseWheel != 0) stage.view.distance *= std::pow(0.9, static_cast<double>(io.MouseWheel));
  stage.view.distance = std::clamp(stage.view.distance, 0.2, 20.0);
}

}  // namespace

ImVec2 picture_size(float width, float height) {
  return {std::max(width - kSide, 64.0f), std::max(height - kStrip, 64.0f)};
}

Wishes draw_panels(Stage& stage, ImTextureID picture, float width, float height) {
  Wishes wishes;
  const ImVec2 size = picture_size(width, height);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({width - kSide, height});
  ImGui::Begin("arm", nullptr,
               kFixed | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::Image(picture, size, {0, 0}, {1, 1});
  drag_camera(stage);
  if (stage.mode == Mode::kReplay) {
    float t = static_cast<float>(stage.t);
    ImGui::SetNextItemWidth(size.x);
    if (ImGui::SliderFloat("##time", &t, 0,
                           static_cast<float>(stage.film->t[stage.film->t.size() - 1]),
                           "t = %.2f s"))
      stage.seek(static_cast<double>(t));
  } else {
    ImGui::SetCursorPosX(8);
    ImGui::Text("live, t = %.2f s", stage.live->time());
  }
  const ImVec2 strip(0, size.y + 24), half((size.x - kGap) / 2, kStrip - 28);
  draw_loop(stage, strip, half);
  draw_history(stage, {strip.x + half.x + kGap, strip.y}, half);
  ImGui::End();
  ImGui::PopStyleVar(2);

  ImGui::SetNextWindowPos({width - kSide, 0});
  ImGui::SetNextWindowSize({kSide, size.y});
  ImGui::Begin("controls", nullptr, kFixed);
  ImGui::Text("%s", stage.problem.scene.name.c_str());
  ImGui::Separator();
  draw_transport(stage);
  draw_joints(stage);
  ImGui::SetNextItemWidth(210);
  const double youngest = 0, oldest = Stage::kOldestCloud;
  ImGui::SliderScalar("age of the cloud", ImGuiDataType_Double, &stage.cloud_age, &youngest,
                      &oldest, "%.3f s");
  ImGui::Separator();
  if (stage.mode == Mode::kReplay) {
    draw_models(stage);
  } else {
    draw_push(stage);
    ImGui::Separator();
  }
  wishes.still = ImGui::Button("save still");
  if (stage.live) {
    ImGui::SameLine();
    wishes.scene = ImGui::Button("save scene");
  }
  if (stage.mode == Mode::kLive) draw_parameters(stage);
  ImGui::End();

  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::SetNextWindowPos({width - kSide, size.y});
  ImGui::SetNextWindowSize({kSide, kStrip});
  ImGui::Begin("cloud", nullptr, kFixed);
  ImGui::SetCursorPos({kGap + 8, 4});
  draw_cloud(stage, {width - kSide + kGap, strip.y}, {kSide - kGap, half.y});
  ImGui::End();
  ImGui::PopStyleVar(2);
  return wishes;
}

}  // namespace fricid::viewer
