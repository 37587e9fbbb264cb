/// \file
/// What one lamp and one camera over a surface show of its highlight. Inside of ingest only.
#pragma once

#include <array>
#include <vector>

#include "patinate/geometry/light.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// A surface before a camera, under one lamp a photograph. Lengths in mm, one frame for all.
struct GlossRig {
  ImageF position_mm = {};         ///< H x W x 3.
  ImageF normal = {};              ///< H x W x 3, unit; (0, 0, 0) where there is no surface.
  ImageU8 mask = {};               ///< H x W, 0 = outside; may be empty.
  std::vector<Light> lights = {};  ///< One for all photographs, or one each.
  std::vector<Vec3> cameras = {};  ///< Camera of each photograph, or one for all.
  double exposure = 1.0;           ///< Times what the lamps' intensities say.

  [[nodiscard]] bool is_moving() const { return lights.size() > 1 || cameras.size() > 1; }
  [[nodiscard]] const Light& light(int frame) const;
  [[nodiscard]] const Vec3& camera(int frame) const;
};

/// A pixel's geometry in one photograph. Its value is matt * (albedo + strength * lobe), the lobe times
/// pi / cosine as lobe() has it.
struct GlossPixel {
  bool is_lit = false;  ///< Inside, with a normal, and faces lamp and camera.
  Vec3 normal, to_light, to_camera;
  Vec3 matt;  ///< Value that albedo 1 shows.
  /// Lobe that `render` draws. @param roughness  [0.05, 1].
  [[nodiscard]] double lobe(double roughness) const;
  /// Between the normal and the middle of lamp and camera, radians: 0 in the mirror's direction.
  [[nodiscard]] double half_angle() const;
};
[[nodiscard]] GlossPixel gloss_pixel(const GlossRig& rig, int frame, int x, int y);

/// Nearest to and farthest from the mirror's direction of all pixels and photographs, degrees; [0] > [1] where none is
/// lit.
[[nodiscard]] std::array<double, 2> half_angles_deg(const GlossRig& rig, int num_frames);

/// Sets the exposure so that in the median of pixels and photographs albedo 1 shows 1: for lamps without intensity,
/// beside which color stays as it was photographed.
void normalize_exposure(GlossRig& rig, int num_frames);

}  // namespace patinate::capture
