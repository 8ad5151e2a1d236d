#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fricid/film/run_film.hpp"
#include "fricid/film/viewpoint.hpp"
#include "fricid/viewer/latent_cloud.hpp"
#include "fricid/viewer/live_arm.hpp"
#include "fricid/viewer/viewer.hpp"

namespace fricid::viewer {

inline constexpr const char* kLiveColour = "#0072B2";

/// The cloud of the selected joint, and the friction and age that it belongs to.
struct ShownCloud {
  std::string label, colour;
  double age;  ///< [s]
  LatentCloud cloud;
};

/// State of the viewer, independent of window and ImGui: panels and scripts use the same functions.
struct Stage {
  explicit Stage(scene::Problem of_scene) : problem(std::move(of_scene)) {}

  Mode mode = Mode::kLive;
  scene::Problem problem;
  std::optional<sim::MujocoArm> arm;
  std::optional<film::RunFilm> film;  ///< of a run folder
  std::unique_ptr<LiveArm> live;

  bool playing = true;
  double speed = 1;
  double t = 0;               ///< of the replay [s]
  std::vector<bool> visible;  ///< per model of the film
  int joint = 0;              ///< whose friction is shown
  double cloud_age = 0.1;     ///< [s]
  film::View view;

  int row() const { return film->row(t); }
  /// Advances replay or simulation by a real time.
  void advance(double seconds);
  void seek(double seconds);
  void reset();
  /// Cloud of the live friction, or of the first visible model with states at the selected joint
  /// along its open loop; empty without such a model.
  std::optional<ShownCloud> cloud();

  static constexpr int kCopies = 200;
  static constexpr double kOldestCloud = 0.5;  ///< [s]

 private:
  /// One joint of a model of the film, kept while it is shown.
  struct Replayed {
    std::size_t model;
    int joint;
    friction::Friction friction;
    JointMotion motion;
  };
  void replay_joint(std::size_t model);

  std::optional<Replayed> replayed_;
};

/// @throws UserError as `view`
Stage make_stage(const std::filesystem::path& target);

/// Request of a command to the window.
struct Asked {
  std::filesystem::path shot{};  ///< a picture of it, into this file
  double race = 0;               ///< draw frames as fast as possible for this time [s]
};

/// One command of a script:
///
///     seek T | play | pause | speed X | toggle MODEL | joint NAME | live | replay | reset
///     set PARAMETER VALUE      of the shown joint, by its symbol, e.g. set Fc 12
///     age SECONDS              of the latent cloud
///     push TORQUE [AMPLITUDE FREQUENCY]    on the shown joint; ends the swing
///     swing                    of all joints again
///     run SECONDS              simulates or replays
///     shot FILE.png | scene FILE.toml
///     fps SECONDS              prints how many frames are drawn in a second
///
/// @throws UserError naming the command
Asked obey(Stage& stage, const std::string& command);

/// The scene with the live friction in place of the injected one. @throws UserError when unwritable
void save_scene(const Stage& stage, const std::filesystem::path& path);

}  // namespace fricid::viewer
