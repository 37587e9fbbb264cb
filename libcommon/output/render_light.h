/// \file
/// The light of render(): what one ray brings, without the texture.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "libcommon/geometry/ray_scene.h"
#include "libcommon/output/glb_tangents.h"
#include "libcommon/output/key_light.h"
#include "libcommon/output/occlusion.h"
#include "libcommon/output/orbit_camera.h"
#include "patinate/output/render.h"

namespace patinate {

/// @throws InvalidInput if an option is out of range, or the picture has too many samples.
void check_render_options(const RenderOptions& options);

/// Point that a ray of the camera meets.
struct LitPoint {
  bool is_hit = false;
  Vec2 uv = Vec2::Zero();
  double diffuse = 1.0;   ///< Hit: times albedo = radiance. Else: share of light that the backdrop keeps.
  double specular = 0.0;  ///< Radiance.
};

/// The texture at a UV, bilinear, clamped at its borders; gray three times.
[[nodiscard]] std::array<double, 3> texture_at(const ImageF& texture, double u, double v);

/// Mesh with everything that light needs. Immutable after construction; queries are thread-safe.
class LitMesh {
 public:
  LitMesh(const Mesh& mesh, const RenderOptions& options, const SurfaceDetail& detail, const OrbitCamera& camera,
          const RunControl& control);

  /// @param sample, num_samples  Which of a pixel's rays this is: chooses the point of the light that it looks at.
  [[nodiscard]] LitPoint look(const Vec3& origin, const Vec3& direction, int x, int y, int sample,
                              int num_samples) const;

 private:
  /// @param lamps  Points of the light.
  [[nodiscard]] LitPoint surface(const RayHit& hit, const Vec3& direction, std::span<const Vec3> lamps) const;
  [[nodiscard]] double ground_light(const Vec3& p, std::span<const Vec3> lamps) const;
  [[nodiscard]] Vec3 light_point(int x, int y, int sample, int num_samples) const;
  [[nodiscard]] bool is_blocked(const Vec3& from, const KeyLight::Ray& ray) const;

  Mesh mesh_;
  RenderOptions options_;
  SurfaceDetail detail_;
  CornerTangents tangents_;  // Where there are normals.
  RayScene scene_;
  Box box_;
  double diagonal_ = 0.0;
  Vec3 up_;
  KeyLight light_;
  Ground ground_;
  std::vector<float> ambient_;  // Per position: ambient visibility.
};

}  // namespace patinate
