/// \file
/// Turns of copied pieces against the frames of texels, and how frames of neighboring triangles lie to each other.
///
/// A piece of a source whose lines run every way need not follow a direction field: where that turns, a piece that
/// follows it is sheared. Such a piece has a turn at each of its texels. With e a step on the surface in a texel's
/// frame, the piece goes by turned(e, turn) in the source. From texel to texel the turn changes by what the frames
/// differ by, so that the piece as a whole lies flat.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patinate/atlas/texel_map.h"

namespace patinate::transfer {

/// In 2^-16 of a full turn, from x to y; sums wrap around.
using Turn = std::int16_t;
inline constexpr int kFullTurn = 1 << 16;

[[nodiscard]] constexpr Turn sum_of(int a, int b) { return static_cast<Turn>(static_cast<std::uint16_t>(a + b)); }
[[nodiscard]] constexpr Turn difference_of(int a, int b) { return sum_of(a, -b); }

/// In 1/256 pixel; middles of pixels are multiples of 256. A source is at most kLargestSource_px wide and high.
struct FixedPoint {
  std::int32_t x = 0, y = 0;
  friend bool operator==(const FixedPoint&, const FixedPoint&) = default;
};
inline constexpr int kLargestSource_px = 4'000'000;

inline constexpr int kSineBits = 14;     ///< Fraction bits of the integer sines.
inline constexpr int kSineSteps = 4096;  ///< A piece of 100 pixels is off by a twelfth of a pixel at its ends.
extern const std::array<std::int32_t, kSineSteps> kSines;  ///< Sines of a full turn, times 2^kSineBits.

/// A step of up to 256 pixels, turned and rounded to 1/256 pixel; by a turn of 0 the same.
[[nodiscard]] inline FixedPoint turned(const FixedPoint& step, Turn turn) {
  if (turn == 0) return step;
  constexpr int kPerStep = kFullTurn / kSineSteps;
  const auto at = static_cast<std::size_t>((static_cast<std::uint16_t>(turn) + kPerStep / 2) / kPerStep);
  const std::int32_t s = kSines[at % kSineSteps], c = kSines[(at + kSineSteps / 4) % kSineSteps];
  constexpr std::int32_t kHalf = 1 << (kSineBits - 1);
  return {(c * step.x - s * step.y + kHalf) >> kSineBits, (s * step.x + c * step.y + kHalf) >> kSineBits};
}
[[nodiscard]] double radians_of(Turn turn);
[[nodiscard]] Turn turn_of(double radians);

/// Turns between frames of neighboring triangles: one is tilted into the other's plane, the shortest way.
class FrameTurns {
 public:
  /// @param frames  One a triangle; must outlive this. Right-handed as seen from the same side of the surface.
  FrameTurns(const Mesh& mesh, const FlowFrames& frames);

  /// How far frame `b` is turned in frame `a`: a step with coordinates turned(e, -between(a, b)) in b is e in a.
  [[nodiscard]] Turn between(int a, int b) const {
    if (a == b) return 0;
    const Beside& beside = beside_[a];
    for (std::size_t k = 0; k < 3; ++k) {
      if (beside.triangles[k] == b) return beside.turns[k];
    }
    return found_between(a, b);
  }

 private:
  [[nodiscard]] Turn found_between(int a, int b) const;

  /// Over the edges of a triangle; most pairs are.
  struct Beside {
    std::array<int, 3> triangles;
    std::array<Turn, 3> turns = {};
  };
  const FlowFrames& frames_;
  std::vector<Vec3> normals_;  ///< Normals of the frames.
  std::vector<Beside> beside_;
};

}  // namespace patinate::transfer
