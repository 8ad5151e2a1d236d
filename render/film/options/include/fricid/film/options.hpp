// Options of the film of a run.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"

namespace fricid::film {

enum class Layout {
  kGhosts,     ///< models as translucent arms over the true one
  kSideBySide  ///< each arm in a picture of its own
};
constexpr std::string_view names(Layout) { return "ghosts|side_by_side"; }

enum class Quality {
  kDraft,
  kStandard,  ///< smooth edges
  kFinal      ///< shadows too
};
constexpr std::string_view names(Quality) { return "draft|standard|final"; }

/// [render]: the film of a run. The plots and the report are always made.
struct FilmOptions {
  bool video = true;
  Layout layout = Layout::kGhosts;
  Quality quality = Quality::kStandard;
  std::vector<std::string> models;
  std::string joint;
  std::vector<double> camera_deg;
  double card_s = 3;

  template <class Archive>
  void visit(Archive& archive) {
    archive("video", video, flag("make the videos in `fricid run`"));
    archive("layout", layout,
            choice("models as translucent ghosts on one arm, or each beside the others"));
    archive("quality", quality, choice("standard has smooth edges, final shadows too"));
    archive("models", models,
            text("names of the models shown; []: the best, the first of the scene, the next best"));
    archive("joint", joint,
            text("joint whose friction is shown; empty: the one with the largest model error"));
    archive("camera_deg", camera_deg,
            number("deg", -360, 360, "azimuth and elevation; []: where the error appears largest"));
    archive("card_s", card_s, number("s", 0, 60, "opening and closing card, each; 0: none"));
  }
};

}  // namespace fricid::film
