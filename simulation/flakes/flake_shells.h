/// \file
/// Lifted flakes as thin curled shells: closed surfaces with an upper side, an underside and walls.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"
#include "simulation/flakes/lifted_flakes.h"

namespace patinate::simulation {

/// Side of a shell that a triangle belongs to; walls belong to the underside.
enum class FlakeSide : std::uint8_t { Top, Under };

struct FlakeShells {
  /// mm, with normals; UVs over the atlas, the same on both sides; surfaces are those of what a flake lies on. Shells
  /// share no position.
  Mesh mesh;
  std::vector<FlakeSide> sides;      ///< By triangle.
  std::vector<std::int32_t> flakes;  ///< By triangle, into LiftedFlakes::flakes.
};

/// Most triangles of all shells together: a quarter of what render() refines a surface to (1.2 million).
inline constexpr int kMostFlakeTriangles = 300'000;
/// Angle at which a curl ends, radians; from there on a flake is straight. The height that lift_mm() gives ends at a
/// rise of 45 degrees of a height map; an arc whose end lies as high over its hinge has turned by about 1.
inline constexpr double kMostCurl = 1.0;
inline constexpr int kMostFlakeStep = 8;  ///< Texels along a square of a shell.
/// Share of its thickness by which a flake lies lower where it hangs on its layer; it is as high again a texel from
/// there. So its end is inside the layer, and the two surfaces cross where they look alike.
inline constexpr double kSunkShare = 0.25;

/// A shell over every flake. Its middle surface is the layer's, bent along arcs of the flake's radius from where the
/// layer holds: what lies at the distance x from there has turned by x / radius, at most kMostCurl. No length along
/// such an arc changes, so that a shell over a plane has the volume area x thickness. Squares of a shell have the side
/// of a texel, or of 2, 3 ... kMostFlakeStep texels, the smallest with which there are at most `most_triangles`. If
/// none is, the largest flakes are kept.
/// @param map      Of the surface, in mm, as large as `flakes`.
/// @param heights  mm along the normal of the upper side where nothing is lifted, as large; empty: 0.
/// Same bits for any number of threads.
[[nodiscard]] FlakeShells flake_shells(const LiftedFlakes& flakes, const TexelMap& map, const ImageF& heights = {},
                                       int most_triangles = kMostFlakeTriangles, const RunControl& control = {});

}  // namespace patinate::simulation
