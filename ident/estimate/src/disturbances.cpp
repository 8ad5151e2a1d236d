#include "disturbances.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fricid/base/text.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "log_times.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kMean = 0.15;   // [s] over which a residual is averaged
constexpr double kQuiet = 0.3;   // [s] that part two events
constexpr double kEnds = 0.25;   // of the largest mean of an event
constexpr std::size_t kFew = 3;  // events
constexpr double kBeyond = 6;    // times the next event
constexpr double kWorth = 0.05;  // of the joint's torque, root mean square
constexpr int kFewestReversals = 10;
constexpr double kBegin = 0.5;    // [s] of a recording, whose springs are bent nobody knows how
constexpr double kRest = 0.3;     // [s]
constexpr double kLongest = 0.5;  // of a recording: more is no event, but another motion

/// Mean of the residual of a joint about a time.
struct Mean {
  std::size_t recording = 0;
  Run run;
  double size = 0;  // [N m]
};

/// Whether a joint breaks away in a run after a rest, as no law may describe it.
bool breaks_away(const signals::Recording& r, int j, const Run& run, double least_speed) {
  const auto fastest = [&](int begin, int end) {
    begin = std::max(0, begin), end = std::min(end, r.length());
    return end > begin ? r.narrow.v.col(j).segment(begin, end - begin).cwiseAbs().maxCoeff() : 0;
  };
  const int rest = static_cast<int>(std::lround(kRest / r.dt));
  return fastest(run.first - rest, run.first) < least_speed &&
         fastest(run.first, run.last + rest) >= least_speed;
}

/// Every half of `kMean`, over the rows that are used, from `kBegin` on.
std::vector<Mean> means_of(std::span<const signals::Recording> recordings,
                           const FrictionTorques& residual, int j) {
  std::vector<Mean> means;
  for (std::size_t s = 0; s < recordings.size(); ++s) {
    const signals::Recording& r = recordings[s];
    const int length = std::max(2, static_cast<int>(std::lround(kMean / r.dt)));
    for (int begin = static_cast<int>(std::lround(kBegin / r.dt)); begin + length <= r.length();
         begin += length / 2) {
      double sum = 0;
      int count = 0;
      for (int k = begin; k < begin + length; ++k)
        if (r.use(k, j)) sum += residual[s](k, j), ++count;
      if (2 * count > length)
        means.push_back({s, {begin, begin + length - 1}, std::abs(sum / count)});
    }
  }
  return means;
}

/// The largest events, the largest first, one more than may count.
std::vector<Mean> events_of(std::vector<Mean> means) {
  constexpr int kQuietMeans = static_cast<int>(2 * kQuiet / kMean);
  std::vector<Mean> events;
  while (events.size() <= kFew && !means.empty()) {
    const auto most = std::ranges::max_element(means, {}, &Mean::size);
    Mean event = *most;
    const auto end_of = [&](auto at, const auto& end) {
      for (int quiet = 0; at != end && at->recording == event.recording; ++at) {
        quiet = at->size > kEnds * event.size ? 0 : quiet + 1;
        if (quiet == 0) {
          event.run.first = std::min(event.run.first, at->run.first);
          event.run.last = std::max(event.run.last, at->run.last);
        } else if (quiet > kQuietMeans) {
          break;
        }
      }
      return at;
    };
    const auto last = end_of(most, means.end());
    const auto first = end_of(std::make_reverse_iterator(most), means.rend());
    means.erase(first.base(), last);
    events.push_back(event);
  }
  return events;
}

}  // namespace

std::optional<Disturbances> find_disturbances(const dynamics::RobotModel& robot,
                                              std::span<const signals::Recording> recordings,
                                              std::span<const double> least_speed,
                                              const FrictionTorques& residual) {
  std::vector<std::string> joints;
  std::vector<Mean> all;
  double beyond = 0;
  const Eigen::VectorXd rms = filtered_torque_rms(recordings);
  for (int j = 0; j < robot.n(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    int reversals = 0;
    for (const signals::Recording& r : recordings)
      reversals += reversals_in(r.narrow.v.col(j), least_speed[i]);
    if (reversals < kFewestReversals) continue;
    const std::vector<Mean> events = events_of(means_of(recordings, residual, j));
    const double worth = kWorth * rms[j];
    if (std::ranges::all_of(events, [&](const Mean& event) {
          return event.size < worth ||
                 breaks_away(recordings[event.recording], j, event.run, least_speed[i]);
        }))
      continue;
    for (std::size_t e = std::min(kFew, std::max<std::size_t>(events.size(), 1) - 1); e > 0; --e) {
      const double times = events[e - 1].size / std::max(events[e].size, 1e-300);
      if (times < kBeyond || events[e - 1].size < worth) continue;
      const std::span<const Mean> large(events.data(), e);
      const auto is_long = [&](const Mean& event) {
        int together = 0;
        for (const Mean& other : large)
          if (other.recording == event.recording) together += other.run.last - other.run.first;
        return together > kLongest * recordings[event.recording].length();
      };
      const auto is_of_the_start = [&](const Mean& event) {
        return event.run.first <= std::lround(kBegin / recordings[event.recording].dt);
      };
      if (std::ranges::any_of(large, is_long) || std::ranges::all_of(large, is_of_the_start)) break;
      joints.push_back(fmt::format("{} by {:.2g} {}", robot.joints[i].name, events[0].size,
                                   unit_of_joint("N m", slides(robot.joints[i]))));
      beyond = std::max(beyond, events[0].size / std::max(events[e].size, 1e-300));
      all.insert(all.end(), events.begin(), events.begin() + static_cast<std::ptrdiff_t>(e));
      break;
    }
  }
  if (all.empty()) return {};
  std::ranges::sort(all, {}, [](const Mean& e) { return std::tuple(e.recording, e.run.first); });
  LogTimes times;
  for (const Mean& event : all) times.add(recordings[event.recording], event.run);
  return Disturbances{fmt::format("torques are off by up to {:.0f} times as much as ever else, {} "
                                  "({})",
                                  beyond, times.words(), enumeration(joints)),
                      times.remedy()};
}

}  // namespace fricid::estimate
