/// \file
/// Gloss over time from a series under one lamp: the highlight is a slice of the lobe, laid out over the surface.
/// Inside of ingest only.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/gloss/gloss_rig.h"
#include "capture/gloss/lobe_course.h"
#include "patinate/core/run_control.h"

namespace patinate::capture {

/// Pixels that look alike, in all photographs.
struct GlossMaterial {
  Vec3 color = Vec3::Zero();        ///< Color of the albedo: shares of red and green, and a little of lightness.
  std::optional<Vec3> albedo = {};  ///< Its mean; not known where all is taken for one material.
  double share = 0.0;               ///< Share of the pixels of all photographs.
  bool is_metallic = false;         ///< Its lobe has a color, or reflects more than minerals do.
  LobeCourse course = {};           ///< Where its is_told is false, no highlight is removed.
};

struct StandingGloss {
  std::string refusal = "";                      ///< Why nothing can be told; "" = it can.
  double nearest_deg = 0.0, farthest_deg = 0.0;  ///< From the mirror's direction, of all pixels and photographs.
  std::vector<GlossMaterial> materials = {};     ///< The most frequent first.

  [[nodiscard]] bool is_any_told() const;
  [[nodiscard]] bool is_any_metallic() const;
};

/// A photograph as it was taken.
struct GlossPhoto {
  ImageF color = {};   ///< H x W x 3, linear.
  ImageU8 valid = {};  ///< H x W, 0 = saturated or out of view; may be empty.
};

/// Materials are classes of color (found where the highlight is weak), and each has a lobe over time
/// (fit_lobe_course()). Photographs are read three times: for all as one material, and twice for materials with the
/// highlight of the round before taken off.
/// A rig of which no pixel lies within kNearMirror of the mirror's direction, or whose pixels lie within kMinSpread
/// of one another, is refused: the lobe's top or its slope is not seen then.
/// @param times  Rising. Memory: the tiles of all photographs, some 40 numbers each, of 1,000 tiles at most.
[[nodiscard]] StandingGloss find_standing_gloss(const GlossRig& rig, const std::vector<double>& times,
                                                const std::function<GlossPhoto(int)>& read_photo,
                                                const RunControl& control);
inline constexpr double kNearMirrorDeg = 8.0;  ///< Satin of roughness 0.4 falls to a quarter of its top by 9 degrees.
inline constexpr double kMinSpreadDeg = 6.0;   ///< See docs/algorithms/gloss.md, step 1.

/// A photograph with its highlight taken off.
struct GlossFrame {
  ImageF albedo;     ///< H x W x 3; 0 where nothing is lit.
  ImageF strength;   ///< H x W x 3, of the lobe in each channel.
  ImageF roughness;  ///< H x W; 0 where there is no lobe.
  ImageF metallic;   ///< H x W, share of such materials, [0, 1].
};
[[nodiscard]] GlossFrame take_gloss_off(const GlossRig& rig, int frame, const ImageF& color, const StandingGloss& gloss,
                                        const RunControl& control);

}  // namespace patinate::capture
