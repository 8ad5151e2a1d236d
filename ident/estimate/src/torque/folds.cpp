#include "fricid/estimate/torque/folds.hpp"

#include <algorithm>
#include <cmath>

namespace fricid::estimate {
namespace {

constexpr std::ptrdiff_t kMostFolds = 4;  // of several motions
constexpr int kFifths = 5;                // of a single one

/// Cuts samples [begin, end) into equal stretches.
void add_stretches(const signals::Recording& recording, int index, int begin, int end,
                   std::vector<Stretch>& out) {
  const int longest = static_cast<int>(std::lround(kLongestStretch / recording.dt));
  const int length = end - begin, parts = std::max(1, length / longest);
  for (int i = 0; i < parts; ++i)
    out.push_back({index, begin + i * length / parts, begin + (i + 1) * length / parts});
}

/// Indices of recordings of one motion together, in the order of their first.
std::vector<std::vector<int>> by_motion(std::span<const signals::Recording> recordings) {
  std::vector<std::vector<int>> motions;
  for (int i = 0; i < std::ssize(recordings); ++i) {
    const int number = recordings[static_cast<std::size_t>(i)].motion_number;
    const auto found = std::ranges::find_if(motions, [&](const std::vector<int>& motion) {
      return number >= 0 &&
             recordings[static_cast<std::size_t>(motion.front())].motion_number == number;
    });
    if (found == motions.end())
      motions.push_back({i});
    else
      found->push_back(i);
  }
  return motions;
}

}  // namespace

std::vector<Fold> folds_of(std::span<const signals::Recording> recordings) {
  const std::vector<std::vector<int>> motions = by_motion(recordings);
  const auto count = std::ssize(motions);
  std::vector<Fold> folds(
      static_cast<std::size_t>(count == 1 ? kFifths : std::min(count, kMostFolds)));
  for (std::size_t m = 0; m < motions.size(); ++m)
    for (const int i : motions[m]) {
      const signals::Recording& recording = recordings[static_cast<std::size_t>(i)];
      const int length = recording.length();
      if (count > 1)
        add_stretches(recording, i, 0, length, folds[m % folds.size()].left_out);
      else
        for (int k = 0; k < kFifths; ++k)
          add_stretches(recording, i, k * length / kFifths, (k + 1) * length / kFifths,
                        folds[static_cast<std::size_t>(k)].left_out);
    }
  return folds;
}

std::vector<signals::Recording> without(const Fold& fold,
                                        std::span<const signals::Recording> recordings) {
  std::vector<signals::Recording> rest(recordings.begin(), recordings.end());
  for (int i = 0; i < std::ssize(rest); ++i)
    if (const std::optional<Stretch> out = fold.left_out_of(i))
      rest[static_cast<std::size_t>(i)]
          .use.middleRows(out->begin, out->end - out->begin)
          .setConstant(false);
  return rest;
}

std::optional<Stretch> Fold::left_out_of(int recording) const {
  std::optional<Stretch> all;
  for (const Stretch& part : left_out) {
    if (part.recording != recording) continue;
    if (!all) all = part;
    all->begin = std::min(all->begin, part.begin);
    all->end = std::max(all->end, part.end);
  }
  return all;
}

}  // namespace fricid::estimate
