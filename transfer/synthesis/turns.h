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

/// A step of up to 256 pixels, turned and rounded to 1/256 pixel; by a turn of 0 the same.
[[nodiscard]] FixedPoint turned(const FixedPoint& step, Turn turn);
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
  std::vector<Beside> beside_;
};

}  // namespace patinate::transfer
