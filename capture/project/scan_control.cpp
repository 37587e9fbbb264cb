#include "capture/project/scan_control.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/controls/accessibility.h"

namespace patinate::capture {

namespace {

/// The corners of the triangle that was hit, and their shares.
struct Corners {
  std::array<std::size_t, 3> position;
  std::array<double, 3> weight;
};

Corners corners_of(const Mesh& mesh, const RayHit& hit) {
  const Triangle& t = mesh.triangles[hit.triangle];
  return {{static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]), static_cast<std::size_t>(t[2])},
          {1.0 - hit.b1 - hit.b2, hit.b1, hit.b2}};
}

class ScanPixels {
 public:
  ScanPixels(const AccessibleSurface& surface, const Camera& camera, const PhotoPart& part)
      : surface_(surface), camera_(camera), part_(part), scene_(surface.mesh) {}

  void fill_row(int row, ScanMaps& maps) const {
    for (int x = 0; x < part_.num_columns; ++x) fill(x, row, maps);
  }

 private:
  void fill(int x, int y, ScanMaps& maps) const {
    const Vec2 pixel = part_.center(x, y);
    const std::optional<CameraRay> ray = camera_.ray(pixel);
    if (!ray) return;
    const std::optional<RayHit> hit = scene_.first_hit(ray->origin, ray->direction);
    if (!hit) return;
    const Mesh& mesh = surface_.mesh;
    const Corners corners = corners_of(mesh, *hit);
    const auto corner_position = [&](std::size_t k) -> const Vec3& { return mesh.positions[corners.position[k]]; };
    const Vec3 position = weighted(corners, corner_position);
    const Vec3 area = area_vector(mesh, hit->triangle);
    const bool is_back = area.dot(ray->direction) > 0.0;
    const Triangle& normal_index = mesh.normal_triangles[hit->triangle];
    Vec3 normal = weighted(corners, [&](std::size_t k) -> const Vec3& { return mesh.normals[normal_index[k]]; });
    normal = normal.norm() > 1e-9 ? Vec3(normal.normalized()) : Vec3(area.normalized());
    double curvature = 0.0;
    for (std::size_t k = 0; k < 3; ++k) curvature += corners.weight[k] * surface_.curvature_per_mm[corners.position[k]];
    const double sign = is_back ? -1.0 : 1.0;
    maps.seen.at(x, y) = 255;
    for (int c = 0; c < 3; ++c) {
      maps.position_mm.at(x, y, c) = static_cast<float>(position[c]);
      maps.normal.at(x, y, c) = static_cast<float>(sign * normal[c]);
    }
    maps.curvature_per_mm.at(x, y) = static_cast<float>(sign * curvature);
    maps.texel_size_mm.at(x, y) = static_cast<float>(texel_size(pixel, position, area.normalized()));
  }

  template <class Values>
  [[nodiscard]] static Vec3 weighted(const Corners& corners, const Values& at) {
    return corners.weight[0] * at(0) + corners.weight[1] * at(1) + corners.weight[2] * at(2);
  }

  /// Where the pixels half a step to each side meet the plane of the triangle; grazing ones, that look past it, count
  /// as at `kGrazing`.
  [[nodiscard]] double texel_size(const Vec2& pixel, const Vec3& position, const Vec3& normal) const {
    constexpr double kGrazing = 1e-3;  // Least cosine, so that a grazing ray does not leave the picture.
    const Vec3& eye = camera_.center();
    const auto on_plane = [&](const Vec2& offset) {
      const std::optional<CameraRay> ray = camera_.ray(pixel + offset);
      if (!ray) return position;
      const double slope = ray->direction.dot(normal), least = std::copysign(kGrazing, slope);
      return Vec3(eye + (position - eye).dot(normal) / (std::abs(slope) < kGrazing ? least : slope) * ray->direction);
    };
    const Vec2 half_x(0.5 * part_.step_x(), 0.0), half_y(0.0, 0.5 * part_.step_y());
    const Vec3 across = on_plane(half_x) - on_plane(-half_x), down = on_plane(half_y) - on_plane(-half_y);
    return std::sqrt(across.cross(down).norm());
  }

  const AccessibleSurface& surface_;
  const Camera& camera_;
  const PhotoPart& part_;
  RayScene scene_;
};

}  // namespace

void describe(OptionVisitor& v, ScanOptions& o) {
  v.visit({"scan_scale",
           "size of the features that the accessibility of a scan sees; not given: 2 % of the bounding box's diagonal",
           "mm", above(0)},
          o.scale_mm);
}

ScanMaps scan_maps(const Mesh& mesh_mm, const Camera& camera_mm, const PhotoPart& part, const ScanOptions& options,
                   const RunControl& control) {
  check_ranges(options);
  const AccessibleSurface surface = accessible_surface(mesh_mm, options.scale_mm, control.part(0.0, 0.7));
  const int width = part.num_columns, height = part.num_rows;
  ScanMaps maps{.seen = ImageU8(width, height),
                .position_mm = ImageF(width, height, 3),
                .normal = ImageF(width, height, 3),
                .curvature_per_mm = ImageF(width, height),
                .texel_size_mm = ImageF(width, height),
                .scale_mm = surface.scale_mm};
  const ScanPixels pixels(surface, camera_mm, part);
  constexpr std::int64_t kRows = 4;
  parallel_for(height, kRows, control.part(0.7, 1.0), [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) pixels.fill_row(static_cast<int>(row), maps);
  });
  maps.num_seen = std::count(maps.seen.values().begin(), maps.seen.values().end(), std::uint8_t{255});
  control.report(1.0);
  return maps;
}

std::string where_it_lies(const Mesh& mesh_mm, const Camera& camera_mm) {
  const Vec3 middle = bounding_box(mesh_mm).center();
  const CameraParameters& p = camera_mm.parameters();
  const double depth = (p.rotation * middle + p.translation).z();
  if (!(depth > 0.0)) return "its middle lies " + short_number_text(-depth) + " mm behind the camera";
  const std::optional<Vec2> pixel = camera_mm.project(middle);
  if (!pixel) return "its middle lies far outside the picture";
  return "its middle lies at pixel (" + short_number_text(std::round(pixel->x())) + ", " +
         short_number_text(std::round(pixel->y())) + "), " + short_number_text(depth) + " mm in front of the camera";
}

}  // namespace patinate::capture
