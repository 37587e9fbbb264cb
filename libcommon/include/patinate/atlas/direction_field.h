/// The direction of a texture's rows on a surface: a smooth direction at every triangle, independent of UVs and charts.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"

namespace patinate {

enum class DirectionKind {
  Gravity,    ///< Down the surface, so that streaks run.
  Curvature,  ///< Along tubes and ridges (least curvature), so that brush marks follow the shape; on the whole
              ///< downward.
  Uv,         ///< As each chart lies in the atlas: turns where charts turn.
};
inline constexpr std::array<std::string_view, 3> kDirectionKindNames{"gravity", "curvature", "uv"};

/// What "down" is at one triangle.
struct DirectionGuide {
  Vec3 down = Vec3::Zero();  ///< Its part in the triangle's plane counts; any length.
  double weight = 0.0;       ///< >= 0; 1 holds it against bends of about `smooth_mm`.
};

/// Frames whose second axis ("down") is the smoothest direction near the guides, and whose first points right for
/// someone who looks at the surface from outside: minimizes the difference of neighboring triangles' directions
/// (unfolded over their common edge) and, by weight, the distance from the guides [Knoeppel et al. 2013, "Globally
/// optimal direction fields", sec. 6.1.2, here on triangles]. Where guides say nothing, the direction comes from afar;
/// with no guide at all it is the UVs' down. Neighbors join by position, so that a seam of UVs changes nothing. One
/// sparse solve, O(n log n) for n triangles. Triangles without area have the UVs' frame.
/// @param guides     One a triangle.
/// @param smooth_mm  > 0. @throws InvalidInput
[[nodiscard]] FlowFrames smooth_frames(const TexelMap& map, const std::vector<DirectionGuide>& guides, double smooth_mm,
                                       const RunControl& control = {});

/// Frames by kind. Gravity weighs by how steep the surface is, curvature by how different its two bends are.
/// @param up  Any length > 0. @throws InvalidInput
[[nodiscard]] FlowFrames direction_frames(const TexelMap& map, DirectionKind kind, const Vec3& up,
                                          const RunControl& control = {});

/// Frames that follow curves drawn near the surface, from first point to last ("down"), and continue smoothly
/// elsewhere.
/// @param curves  mm; of at least two points. @throws InvalidInput if none has a length.
[[nodiscard]] FlowFrames curve_frames(const TexelMap& map, const std::vector<std::vector<Vec3>>& curves,
                                      const RunControl& control = {});

/// Each triangle's own UV tangents.
[[nodiscard]] FlowFrames uv_frames(const TexelMap& map);

/// A frame in a triangle's UVs.
struct FrameInUv {
  double angle = 0.0;        ///< Radians, (-pi, pi]: from u to the frame's first axis, counter-clockwise where v is up.
  bool is_mirrored = false;  ///< The second axis lies on the other side of the first than texel rows do.
};
[[nodiscard]] FrameInUv frame_in_uv(const FlowFrame& frame, const FlowFrame& uv_tangents);
/// The inverse.
[[nodiscard]] FlowFrame frame_from_uv(const FrameInUv& in_uv, const FlowFrame& uv_tangents);

}  // namespace patinate
