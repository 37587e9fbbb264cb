/// \file
/// A displaced surface with its maps, as rays meet it.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <span>
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

/// The part of a scene that stays when other maps are shown: the surface that heights move, and the light around it.
struct SurfaceShape {
  /// @param height  The size of heights, to whose texels the mesh is refined; empty: not refined.
  SurfaceShape(const Mesh& given, const ImageF& height, const RenderOptions& options, const RunControl& control);

  /// Whether these heights can move it. @param height  As in the constructor.
  [[nodiscard]] bool fits(const ImageF& height) const {
    return height.width() == texels_across && height.height() == texels_down;
  }

  Mesh mesh;  ///< Refined; equal positions are one.
  Box box;    ///< Box of the mesh as it was given.
  int texels_across, texels_down;
  std::vector<float> open;  ///< Ambient visibility of its positions.
  Ground ground;
};

/// Immutable after construction; queries are thread-safe.
class SurfaceScene {
 public:
  /// @param mesh  As it was given. @param shape  Must fit the heights. @throws InvalidInput as SurfaceView.
  SurfaceScene(const Mesh& mesh, std::shared_ptr<const SurfaceShape> shape, SurfaceMaps maps,
               const RenderOptions& options, const SurfaceOptions& surface, const RunControl& control);
  /// The heights that move a surface: those of the maps, or none.
  [[nodiscard]] static const ImageF& heights(const SurfaceMaps& maps, const SurfaceOptions& surface);

  [[nodiscard]] const Ground& ground() const { return shape_->ground; }
  [[nodiscard]] const Box& box() const { return shape_->box; }
  [[nodiscard]] double diagonal() const { return shape_->box.diagonal(); }
  /// How far off a surface rays begin.
  [[nodiscard]] double ray_offset() const;

  [[nodiscard]] std::optional<SeenPoint> first_hit(const Vec3& origin, const Vec3& direction) const;
  [[nodiscard]] bool is_blocked(const Vec3& origin, const Vec3& direction,
                                double distance = std::numeric_limits<double>::infinity()) const {
    return scene_->is_blocked_along(origin, direction, distance);
  }
  /// The same of at most 8 directions at once, which should be near each other: bit i is set for directions[i].
  [[nodiscard]] unsigned blocked_of_8(const Vec3& origin, std::span<const Vec3> directions,
                                      std::span<const double> distances) const {
    return scene_->blocked_of_8(origin, directions, distances);
  }

 private:
  /// Appends the pieces to the mesh, and finds their ambient visibility.
  void add_pieces(const RunControl& control);
  [[nodiscard]] SeenPoint point(const RayHit& hit, const Vec3& direction) const;
  /// Of what a triangle shows.
  [[nodiscard]] const SurfaceMaps& maps_of(std::size_t triangle) const;
  void read_material(SeenPoint& point, const SurfaceMaps& maps, const Vec2& uv) const;
  void read_leaf(SeenPoint& point, std::size_t triangle, const RayHit& hit) const;

  SurfaceMaps maps_;
  RenderOptions options_;
  SurfaceOptions surface_;
  std::shared_ptr<const SurfaceShape> shape_;
  Mesh mesh_;                                        ///< Displaced.
  std::vector<float> open_;                          ///< Ambient visibility of its positions.
  CornerTangents tangents_;                          ///< Where a map tells normals.
  std::size_t first_piece_ = 0, end_of_pieces_ = 0;  ///< Triangles of maps_.pieces.
  PlantField plants_;
  std::optional<RayScene> scene_;
};

}  // namespace patinate
