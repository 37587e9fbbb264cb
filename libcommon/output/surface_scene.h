/// \file
/// A displaced surface with its maps, as rays meet it.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "libcommon/geometry/ray_scene.h"
#include "libcommon/output/glb_tangents.h"
#include "libcommon/output/occlusion.h"
#include "libcommon/output/plantlets.h"
#include "patinate/output/render_surface.h"

namespace patinate {

/// A place of a surface that a ray has met, with its material there.
struct SeenPoint {
  Vec3 place = Vec3::Zero();    ///< Off the surface, where other rays begin.
  Vec3 view = Vec3::UnitZ();    ///< Unit, back along the ray.
  Vec3 face = Vec3::UnitZ();    ///< Face of the triangle, toward the viewer.
  Vec3 smooth = Vec3::UnitZ();  ///< Without what a map of normals says.
  Vec3 normal = Vec3::UnitZ();
  double open = 1.0;  ///< Ambient visibility.
  Vec3 color = Vec3::Zero();
  Vec3 specular = Vec3::Zero();  ///< At normal incidence, of what is no metal.
  double roughness = 0.5;
  double metalness = 0.0;
  double wetness = 0.0;
};

/// Immutable after construction; queries are thread-safe.
class SurfaceScene {
 public:
  /// @throws InvalidInput as SurfaceView.
  SurfaceScene(const Mesh& mesh, SurfaceMaps maps, const RenderOptions& options, const SurfaceOptions& surface,
               const RunControl& control);

  [[nodiscard]] const Ground& ground() const { return ground_; }
  [[nodiscard]] const Box& box() const { return box_; }
  [[nodiscard]] double diagonal() const { return box_.diagonal(); }
  /// How far off a surface rays begin.
  [[nodiscard]] double ray_offset() const;

  [[nodiscard]] std::optional<SeenPoint> first_hit(const Vec3& origin, const Vec3& direction) const;
  [[nodiscard]] bool is_blocked(const Vec3& origin, const Vec3& direction,
                                double distance = std::numeric_limits<double>::infinity()) const {
    return scene_->is_blocked_along(origin, direction, distance);
  }

 private:
  [[nodiscard]] SeenPoint point(const RayHit& hit, const Vec3& direction) const;
  void read_material(SeenPoint& point, const Vec2& uv) const;
  /// Refines the mesh to the curves that its normals describe.
  void curve();
  void read_leaf(SeenPoint& point, std::size_t triangle, const RayHit& hit) const;

  SurfaceMaps maps_;
  RenderOptions options_;
  SurfaceOptions surface_;
  Box box_;                  ///< Box of the mesh as it was given.
  Mesh mesh_;                ///< Displaced.
  std::vector<float> open_;  ///< Ambient visibility of its positions.
  CornerTangents tangents_;  ///< Where a map tells normals.
  PlantField plants_;
  std::optional<RayScene> scene_;
  Ground ground_;
};

}  // namespace patinate
