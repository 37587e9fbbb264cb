/// \file
/// Lifted flakes in the plane of the atlas: a grid of squares inside an outline without the steps of texels.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patinate/geometry/mesh.h"
#include "simulation/flakes/lifted_flakes.h"

namespace patinate::simulation {

/// A side of a square with another flake or none behind it. The flake lies to the left of the way from `a` to `b`, as
/// seen in a picture.
struct OutlineEdge {
  int a = 0, b = 0;       ///< Into FlakeOutline::places.
  bool is_hinge = false;  ///< The layer goes on behind it and holds.
  double widening = 0.0;  ///< Texels by which the flake goes on behind it, into the texel of a crack.
};

/// One flake.
struct FlakeOutline {
  std::int32_t flake = 0;
  std::vector<Vec2> places;  ///< Of corners of squares, in texels: (0, 0) is the upper left corner of the atlas.
  std::vector<std::array<int, 4>> squares;  ///< Upper left, lower left, lower right, upper right.
  std::vector<OutlineEdge> edges;           ///< Closed: each of their corners begins one edge and ends one.
};

/// Outlines of all flakes from squares of `step` x `step` texels, each of the flake that has most of it. Edges beside a
/// crack go on to where the layer ends: half of what the crack leaves of its texel. The outline is smoothed [Taubin
/// 1995]: steps of texels vanish, and what is enclosed hardly shrinks. Corners between two straight sides of at least
/// three squares stay.
/// @param step  >= 1. Flakes in which no square fits are left out.
[[nodiscard]] std::vector<FlakeOutline> flake_outlines(const LiftedFlakes& flakes, int step);

}  // namespace patinate::simulation
