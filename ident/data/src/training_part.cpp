#include "fricid/data/training_part.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/rng.hpp"
#include "fricid/data/log_part.hpp"

namespace fricid::data {
namespace {

constexpr double kPiece = 20;    // [s]
constexpr int kFewest = 8;       // pieces
constexpr double kStill = 0.02;  // [rad or m] of travel
constexpr std::uint64_t kSeed = 1;

struct Piece {
  const Dataset* of;
  int begin, length;
};

std::vector<Piece> pieces_of(std::span<const Dataset> recordings, int most) {
  std::vector<Piece> pieces;
  for (const Dataset& d : recordings) {
    const int longest =
        std::max(2, std::min(static_cast<int>(std::lround(kPiece * d.rate_hz)), most / kFewest));
    const auto length = static_cast<std::int64_t>(d.length());
    const std::int64_t count = std::max<std::int64_t>(1, length / longest);
    for (std::int64_t i = 0; i < count; ++i) {
      const auto begin = static_cast<int>(i * length / count);
      pieces.push_back({&d, begin, static_cast<int>((i + 1) * length / count) - begin});
    }
  }
  return pieces;
}

// Whether a joint moves and every signal is there for the most part.
bool tells_something(const Piece& piece) {
  bool moves = false;
  for (int j = 0; j < piece.of->n(); ++j) {
    const auto q = piece.of->q.col(j).segment(piece.begin, piece.length).array(),
               tau = piece.of->tau.col(j).segment(piece.begin, piece.length).array();
    if (2 * std::min(q.isFinite().count(), tau.isFinite().count()) < piece.length) return false;
    moves = moves ||
            q.maxCoeff<Eigen::PropagateNumbers>() - q.minCoeff<Eigen::PropagateNumbers>() > kStill;
  }
  return moves;
}

}  // namespace

TrainingPart training_part(std::span<const Dataset> recordings, int most) {
  TrainingPart part;
  double samples = 0;
  for (const Dataset& d : recordings) {
    samples += d.length();
    part.of_seconds += d.length() * d.dt();
  }
  if (samples <= most) {
    part.recordings.assign(recordings.begin(), recordings.end());
    part.seconds = part.of_seconds;
    return part;
  }
  std::vector<Piece> pieces = pieces_of(recordings, most);
  std::erase_if(pieces, [](const Piece& piece) { return !tells_something(piece); });
  if (pieces.empty()) pieces = pieces_of(recordings, most);
  double left = 0;
  for (const Piece& piece : pieces) left += piece.length;
  const auto all = std::ssize(pieces);
  const auto count =
      std::clamp<std::ptrdiff_t>(std::lround(static_cast<double>(all) * most / left), 1, all);
  Rng rng(kSeed, 0);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t first = i * all / count, end = (i + 1) * all / count;
    const auto drawn =
        static_cast<std::ptrdiff_t>(rng.uniform() * static_cast<double>(end - first));
    const auto [of, begin, length] = pieces[static_cast<std::size_t>(first + drawn)];
    part.recordings.push_back(rows_of(*of, begin, length));
    part.recordings.back().name =
        fmt::format("{}[{:.6g}:{:.6g}]", of->name, begin * of->dt(), (begin + length) * of->dt());
    part.seconds += length * of->dt();
  }
  return part;
}

}  // namespace fricid::data
