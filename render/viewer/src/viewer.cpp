#include "fricid/viewer/viewer.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/json.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/film/viewpoint.hpp"
#include "imgui_gl.hpp"
#include "panels.hpp"

namespace fricid::viewer {
namespace {

namespace fs = std::filesystem;

constexpr double kTrailPast = 1.5;  // [s]
constexpr double kLiveShot = 5;     // time of a screenshot of the live arm [s]

/// Settings of the window, kept for the next session.
fs::path settings_file() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  const char* home = std::getenv("HOME");
  const fs::path folder =
      config && *config ? fs::path(config) : fs::path(home ? home : ".") / ".config";
  return folder / "fricid" / "viewer.json";
}

/// Damaged settings are replaced by the defaults.
void load_settings(Stage& stage) {
  const fs::path file = settings_file();
  if (!fs::exists(file)) return;
  try {
    const auto settings = parse_json(read_file(file), file.string());
    const auto read = [&](const char* key, auto& value) { value = settings.value(key, value); };
    film::View view = stage.view;
    double speed = stage.speed;
    read("azimuth_deg", view.azimuth_deg);
    read("elevation_deg", view.elevation_deg);
    read("speed", speed);
    stage.view = std::move(view);
    stage.speed = speed;
  } catch (const UserError&) {
    return;
  } catch (const nlohmann::json::exception&) {
    return;
  }
}

void save_settings(const Stage& stage) {
  const nlohmann::json settings{{"azimuth_deg", stage.view.azimuth_deg},
                                {"elevation_deg", stage.view.elevation_deg},
                                {"speed", stage.speed}};
  try {
    write_file_atomically(settings_file(), settings.dump(2) + "\n");
  } catch (const UserError&) {
    // settings are lost if the home folder cannot be written
  }
}

std::span<const double> row_of(const film::RowMatrix& values, int row) {
  return {values.data() + row * values.cols(), static_cast<std::size_t>(values.cols())};
}

/// From the front, so far that the whole motion of a replay or, about its pose, the live arm is
/// seen.
film::View first_view(const Stage& stage, film::ArmPainter& painter) {
  constexpr double kAzimuth = 135, kElevation = -8;          // [deg]
  constexpr double kAspect = 1.6;                            // of the picture beside the panels
  constexpr double kAroundMotion = 1.15, kAroundPose = 1.5;  // distance
  const auto points = stage.film ? film::paths_of(*stage.film, painter).outline
                                 : painter.joints(stage.live->state().q);
  film::View view = film::view_of(points, kAzimuth, kElevation, painter.field_of_view(), kAspect);
  view.distance *= stage.film ? kAroundMotion : kAroundPose;
  return view;
}

film::Image paint(const Stage& stage, film::ArmPainter& painter, int width, int height) {
  std::vector<film::PaintedArm> arms;
  std::vector<film::Trail> trails;
  if (stage.mode == Mode::kLive) {
    arms.push_back({stage.live->state().q});
  } else {
    const film::RunFilm& film = *stage.film;
    const int row = stage.row(), first = film.row(stage.t - kTrailPast);
    const auto trail = [&](const film::RowMatrix& q, const film::Paint& colour) {
      film::Trail path{{}, colour};
      for (int k = first; k < row; k += 12) path.points.push_back(painter.tip(row_of(q, k)));
      path.points.push_back(painter.tip(row_of(q, row)));
      trails.push_back(std::move(path));
    };
    arms.push_back({row_of(film.q, row), film::Paint{0.8f, 0.81f, 0.83f, 1}});
    trail(film.q, {0.35f, 0.35f, 0.35f, 1});
    for (std::size_t m = 0; m < film.models.size(); ++m) {
      if (!stage.visible[m]) continue;
      arms.push_back({row_of(film.models[m].q, row), film::paint_of(film.models[m].colour, 0.5f)});
      trail(film.models[m].q, film::paint_of(film.models[m].colour));
    }
    painter.keep_backdrop(stage.view, width, height);
  }
  return painter.paint(stage.view, width, height, arms, trails);
}

/// ImGui's context, style and renderer.
class Gui {
 public:
  explicit Gui(const film::GlLookup& function) {
    ImGui::CreateContext();
    ImGui::StyleColorsLight();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    if (fs::exists(kFont)) io.Fonts->AddFontFromFileTTF(kFont, 14);
    gl_.emplace(function);
  }
  ~Gui() {
    gl_.reset();
    ImGui::DestroyContext();
  }
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  /// Draws one frame into the window's buffer.
  Wishes frame(Stage& stage, film::ArmPainter& painter) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const ImVec2 picture = picture_size(size.x, size.y);
    const ImTextureID texture =
        gl_->show(paint(stage, painter, static_cast<int>(picture.x), static_cast<int>(picture.y)));
    ImGui::NewFrame();
    const Wishes wishes = draw_panels(stage, texture, size.x, size.y);
    ImGui::Render();
    gl_->draw(*ImGui::GetDrawData());
    if (const unsigned error = gl_->error())
      throw std::runtime_error(fmt::format("OpenGL error {:#x}", error));
    return wishes;
  }

  film::Image seen() {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    return gl_->read(static_cast<int>(size.x), static_cast<int>(size.y));
  }

 private:
  std::optional<ImguiGl> gl_;
};

std::vector<std::string> commands_of(const Stage& stage, const ViewerOptions& options) {
  std::vector<std::string> commands;
  if (!options.script.empty()) {
    std::istringstream text(read_file(options.script));
    for (std::string line; std::getline(text, line);) commands.push_back(line);
  } else {
    const double at = stage.mode == Mode::kLive ? kLiveShot : stage.film->t.tail<1>()[0] / 2;
    commands.push_back(fmt::format("seek {}", options.at.value_or(at)));
    commands.push_back("shot " + options.screenshot.string());
  }
  return commands;
}

/// Plays for some seconds at full speed and prints the frames per second.
void race(Stage& stage, double seconds, const std::function<void()>& frame) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  const bool was_playing = std::exchange(stage.playing, true);
  const auto begin = Clock::now();
  int frames = 0;
  for (auto last = begin; seconds_since(begin) < seconds; ++frames) {
    throw_if_stopped();
    stage.advance(seconds_since(std::exchange(last, Clock::now())));
    frame();
  }
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const auto ghosts =
      stage.mode == Mode::kLive ? 0 : std::count(stage.visible.begin(), stage.visible.end(), true);
  fmt::print("{:.1f} frames/s, {} x {}, {} ghosts\n", frames / seconds_since(begin), size.x, size.y,
             ghosts);
  stage.playing = was_playing;
}

/// Executes the commands, each followed by one frame.
void run_script(Stage& stage, film::ArmPainter& painter, Gui& gui,
                const std::vector<std::string>& commands, const std::function<void()>& before_frame,
                const std::function<void()>& after_frame) {
  const auto frame = [&](const fs::path& shot = {}) {
    before_frame();
    gui.frame(stage, painter);
    if (!shot.empty()) film::save_png(gui.seen(), shot);
    after_frame();
  };
  stage.playing = false;
  for (const std::string& command : commands) {
    throw_if_stopped();
    const Asked asked = obey(stage, command);
    frame();  // ImGui needs two frames to settle its sizes
    if (!asked.shot.empty()) frame(asked.shot);
    if (asked.race > 0) race(stage, asked.race, frame);
  }
}

void view_offscreen(Stage& stage, const ViewerOptions& options) {
  const auto context = film::make_gl_context(options.renderer, options.width, options.height);
  film::ArmPainter painter(*stage.arm, stage.problem.scene.robot.payload_frame, options.width,
                           options.height, film::PaintQuality::final(), context->functions());
  stage.view = first_view(stage, painter);
  Gui gui(context->functions());
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(options.width), static_cast<float>(options.height)};
  io.DeltaTime = 1.0f / 60;
  run_script(
      stage, painter, gui, commands_of(stage, options), [] {}, [] {});
}

/// GLFW for the lifetime of one window, whose context is current.
class Window {
 public:
  Window(const std::string& title, int width, int height) {
    // libmujoco looks GL up among globally visible symbols
    if (!dlopen("libGL.so.1", RTLD_NOW | RTLD_GLOBAL))
      throw UserError("libGL.so.1 is missing; install libgl1 libgl1-mesa-dri");
    if (!glfwInit()) throw UserError("found no display; --screenshot FILE works without one");
    glfwWindowHint(GLFW_SAMPLES, 0);
    window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (!window_) {
      glfwTerminate();
      throw UserError("cannot open a window with OpenGL; --screenshot FILE works without one");
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
  }
  ~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  GLFWwindow* get() const { return window_; }

 private:
  GLFWwindow* window_ = nullptr;
};

void view_in_window(Stage& stage, const ViewerOptions& options) {
  const Window window("fricid: " + stage.problem.scene.name, options.width, options.height);
  const film::GlLookup functions = [](const char* name) {
    return reinterpret_cast<void*>(glfwGetProcAddress(name));
  };
  const film::PaintQuality quality = film::draws_by_processor(functions)
                                         ? film::PaintQuality::draft()
                                         : film::PaintQuality::standard();
  film::ArmPainter painter(*stage.arm, stage.problem.scene.robot.payload_frame, options.width,
                           options.height, quality, functions);
  stage.view = first_view(stage, painter);
  Gui gui(functions);
  ImGui_ImplGlfw_InitForOpenGL(window.get(), true);
  if (!options.script.empty()) {
    run_script(
        stage, painter, gui, commands_of(stage, options),
        [] {
          glfwPollEvents();
          ImGui_ImplGlfw_NewFrame();
        },
        [&] { glfwSwapBuffers(window.get()); });
  } else {
    load_settings(stage);
    auto last = std::chrono::steady_clock::now();
    for (int shot = 0; !glfwWindowShouldClose(window.get()) && !stop_requested();) {
      glfwPollEvents();
      ImGui_ImplGlfw_NewFrame();
      const auto now = std::chrono::steady_clock::now();
      stage.advance(std::chrono::duration<double>(now - last).count());
      last = now;
      const Wishes wishes = gui.frame(stage, painter);
      if (wishes.still)
        film::save_png(gui.seen(), fmt::format("{}_{}.png", stage.problem.scene.name, ++shot));
      if (wishes.scene) save_scene(stage, stage.problem.scene.name + "_edited.toml");
      glfwSwapBuffers(window.get());
    }
    save_settings(stage);
  }
  ImGui_ImplGlfw_Shutdown();
}

}  // namespace

void view(const fs::path& target, const ViewerOptions& options) {
  Stage stage = make_stage(target);
  const bool script_alone = !options.script.empty() && !std::getenv("DISPLAY");
  if (options.offscreen || script_alone || !options.screenshot.empty())
    view_offscreen(stage, options);
  else
    view_in_window(stage, options);
}

}  // namespace fricid::viewer
