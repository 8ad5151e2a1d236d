#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fricid/scene/problem.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::film {

/// Options of drawing that are not in the scene.
struct DrawingOptions {
  std::string renderer{};  ///< egl, osmesa; empty: FRICID_GL, else the first that works
  double orbit_s = 8;      ///< [s] of video/orbit.mp4
  int jobs = 0;            ///< processes that draw; 0: one per core, 8 at most
};

/// Makes the videos of a run, H.264 in MP4, 1280 x 720 at 30 frames per second:
///
///     video/comparison.mp4   truth and models, between two cards of render.card_s seconds
///     video/compensation.mp4 the arm in closed loop without and with friction fed forward, if the
///                            run has such loops
///     video/contact.mp4      pushes and what observers make of them, likewise
///     video/orbit.mp4        the arm in the middle of its motion, seen from all around
///
/// Without the ffmpeg program the frames go to video/comparison/00001.png ..., others likewise, and
/// one line on stderr says so.
/// @param visible  the files that they may show
/// @param out      the folder to write to
/// @return the files written
/// @throws UserError when nothing can be drawn (no GL, no MJCF), or, after the other video is made,
///         when one could not be written; Stopped
std::vector<std::filesystem::path> render_video(const workflow::RunFolder& visible,
                                                const workflow::RunFolder& out,
                                                const scene::Problem& problem,
                                                const DrawingOptions& options);

/// One picture, final quality: the arm and its ghosts at a time of the first held-out trajectory,
/// without text.
/// @param at  [s]; absent: the middle
/// @throws UserError when the film has no such time
void render_still(const workflow::RunFolder& folder, const scene::Problem& problem,
                  std::optional<double> at, const std::filesystem::path& picture,
                  const DrawingOptions& options);

}  // namespace fricid::film
