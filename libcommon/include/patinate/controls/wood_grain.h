/// \file
/// Rings, fibers and knots of a board: a pattern in space, as it shows on any face that is cut through it.
#pragma once

#include <cstdint>

#include "patinate/core/options.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

/// Settings of wood_grain_at().
struct WoodGrainOptions {
  double ring_mm = 5.0;  ///< Width of a year's ring; > 0.
  double stretch =
      25.0;  ///< Ratio of the variation length along the trunk to that across it, for rings and fibers; >= 1.
  double waviness = 0.6;         ///< How far rings stray, in rings; [0, 10].
  double knots_per_meter = 1.5;  ///< Knots per meter of trunk, whether or not they reach the board; [0, 100].
  std::int64_t seed = 1;         ///< >= 0. Another board of another tree.
};
void describe(OptionVisitor& visitor, WoodGrainOptions& options);

/// A board's place in its tree.
struct Board {
  Vec3 middle_mm = Vec3::Zero();
  Vec3 along = Vec3::UnitX();   ///< Unit: the trunk's direction, from which its pith is up to 1 degree off.
  double half_width_mm = 50.0;  ///< Across: piths lie some of these away, some inside.
  std::int64_t number = 0;      ///< Boards of other numbers are cut elsewhere.
};

/// 0 where a year's wood begins, up to 1 at its dark end; a ring rises slowly and falls at once. Around a pith, by a
/// smooth minimum of the years in which the trunk and its branches reached a place, so that rings flow around knots,
/// which are dark. Fibers, a fifth of it, are noise stretched along the trunk. What is finer than `least_mm` is left at
/// its mean. Sums, products, quotients and square roots: the same bits on every machine.
/// @param position_mm  Within 1e9 of the board. @param least_mm  >= 0.
[[nodiscard]] double wood_grain_at(const Vec3& position_mm, const Board& board, const WoodGrainOptions& options,
                                   double least_mm = 0.0);

}  // namespace patinate
