#include "libcommon/output/render_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/output/hit_corners.h"
#include "libcommon/output/sampling.h"

namespace patinate {

namespace {

constexpr int kLightRays = 9;  // Per ray of the camera that meets the surface.

// GGX lobe with Smith's shadowing and Schlick's Fresnel term, times n.l.
double coat(const Vec3& n, const Vec3& view, const Vec3& light, double reflectance, double roughness) {
  const double nl = n.dot(light), nv = n.dot(view);
  if (!(nl > 0.0) || !(nv > 0.0)) return 0.0;
  const Vec3 h = (view + light).normalized();
  const double a2 = std::pow(roughness, 4);
  const double nh = std::max(0.0, n.dot(h));
  const double d = nh * nh * (a2 - 1.0) + 1.0;
  const double g_light = nl + std::sqrt(a2 + (1.0 - a2) * nl * nl);
  const double g_view = nv + std::sqrt(a2 + (1.0 - a2) * nv * nv);
  const double fresnel = reflectance + (1.0 - reflectance) * std::pow(1.0 - std::max(0.0, h.dot(view)), 5);
  // The light's radiance is such that a white surface facing it shows 1: irradiance pi.
  return std::numbers::pi * fresnel * a2 / (std::numbers::pi * d * d) * nl / (g_light * g_view);
}

}  // namespace

std::array<double, 3> texture_at(const ImageF& texture, double u, double v) {
  const double x = std::clamp(u * texture.width() - 0.5, 0.0, texture.width() - 1.0);
  const double y = std::clamp((1.0 - v) * texture.height() - 0.5, 0.0, texture.height() - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, texture.width() - 1), y1 = std::min(y0 + 1, texture.height() - 1);
  const double fx = x - x0, fy = y - y0;
  const bool is_gray = texture.channels() < 3;
  std::array<double, 3> color{};
  for (int c = 0; c < 3; ++c) {
    const int k = is_gray ? 0 : c;
    const double top =
        (1.0 - fx) * static_cast<double>(texture.at(x0, y0, k)) + fx * static_cast<double>(texture.at(x1, y0, k));
    const double low =
        (1.0 - fx) * static_cast<double>(texture.at(x0, y1, k)) + fx * static_cast<double>(texture.at(x1, y1, k));
    color[c] = (1.0 - fy) * top + fy * low;
  }
  return color;
}

LitMesh::LitMesh(const Mesh& mesh, const RenderOptions& options, const SurfaceDetail& detail, const OrbitCamera& camera,
                 const RunControl& control)
    : mesh_(refined_for_occlusion(mesh, options)),
      options_(options),
      detail_(detail),
      tangents_(detail.normals.empty() ? CornerTangents{} : corner_tangents(mesh_)),
      scene_(mesh_),
      box_(bounding_box(mesh_)),
      diagonal_(box_.diagonal()),
      up_(world_from_y_up(Vec3::UnitY(), options.up)),
      light_(options, box_.center()),
      ground_(mesh_, box_, options.up) {
  // Seen from below, the ground would hide the object.
  if (camera.position.dot(up_) <= ground_.height()) options_.ground = false;
  ambient_ = occlusion_at_vertices(mesh_, scene_, diagonal_, options_, control.part(0.0, 0.7));
  if (options_.ground) ground_.find_visibility(scene_, options_, control.part(0.7, 1.0));
}

Vec3 LitMesh::light_point(int x, int y, int sample, int num_samples) const {
  // Stratified by radius over the pixel's samples, so that few of them cover the light evenly.
  Vec2 square = sequence_point(sample, pixel_shift(x, y));
  square.x() = (sample + square.x()) / num_samples;
  return light_.point(square);
}

bool LitMesh::is_blocked(const Vec3& from, const KeyLight::Ray& ray) const {
  return scene_.is_blocked_along(from, ray.direction, ray.distance);
}

LitPoint LitMesh::look(const Vec3& origin, const Vec3& direction, int x, int y, int sample, int num_samples) const {
  std::array<Vec3, std::max(kLightRays, kGroundRays)> points;
  const auto lamps = [&](int num) {
    for (int i = 0; i < num; ++i) points[i] = light_point(x, y, sample * num + i, num_samples * num);
    return std::span<const Vec3>(points).first(static_cast<std::size_t>(num));
  };
  if (const std::optional<RayHit> hit = scene_.first_hit(origin, direction))
    return surface(*hit, direction, lamps(kLightRays));
  LitPoint point;
  const double fall = direction.dot(up_);
  if (options_.ground && fall < -1e-6) {
    const double distance = (ground_.height() - origin.dot(up_)) / fall;
    point.diffuse = ground_light(origin + distance * direction, lamps(kGroundRays));
  }
  return point;
}

LitPoint LitMesh::surface(const RayHit& hit, const Vec3& direction, std::span<const Vec3> lamps) const {
  const HitCorners corners = corners_of(mesh_, ambient_, static_cast<std::size_t>(hit.triangle));
  const std::array<Vec3, 3>& p = corners.positions;
  Vec3 face = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  Vec3 normal = blend(corners.normals, hit.b1, hit.b2).normalized();
  const Vec2 at = blend(corners.uvs, hit.b1, hit.b2);
  if (!detail_.normals.empty()) {
    const std::array<double, 3> n = texture_at(detail_.normals, at.x(), at.y());
    normal = mapped_normal(tangents_, hit, normal, Vec3(n[0], n[1], n[2]));
  }
  const double roughness = detail_.roughness.empty()
                               ? options_.roughness
                               : std::clamp(texture_at(detail_.roughness, at.x(), at.y())[0], 0.05, 1.0);
  // Both sides show: a surface seen from behind is lit like one that faces the viewer.
  const double side = face.dot(direction) > 0.0 ? -1.0 : 1.0;
  face *= side;
  normal *= side;

  LitPoint point;
  point.is_hit = true;
  point.uv = at;
  const double gradient = 1.0 - options_.ambient_gradient * 0.5 * (1.0 - normal.dot(up_));
  point.diffuse =
      options_.ambient * gradient * (options_.occlusion_samples > 0 ? blend(corners.open, hit.b1, hit.b2) : 1.0);
  if (!(options_.light > 0.0)) return point;
  const Vec3 place = smooth_place(corners, hit, side), from = place + kRayOffset * diagonal_ * face;
  for (const Vec3& lamp : lamps) {
    const KeyLight::Ray light = light_.toward(lamp, place);
    const double facing = normal.dot(light.direction);
    if (!(facing > 0.0) || is_blocked(from, light)) continue;
    const double share = options_.light / static_cast<double>(lamps.size()) * light.strength;
    point.diffuse += share * facing;
    if (options_.specular > 0.0)
      point.specular += share * coat(normal, -direction, light.direction, options_.specular, roughness);
  }
  return point;
}

// Share of the light on open ground that arrives at p.
double LitMesh::ground_light(const Vec3& p, std::span<const Vec3> lamps) const {
  const double key = options_.light * std::max(0.0, light_.toward(light_.direction(), p).direction.dot(up_));
  const double whole = options_.ambient + key;
  if (!(whole > 0.0)) return 1.0;
  double lit = 0.0;
  for (const Vec3& lamp : lamps) {
    const KeyLight::Ray light = light_.toward(lamp, p);
    if (light.direction.dot(up_) > 0.0 && !is_blocked(p + kRayOffset * diagonal_ * up_, light)) lit += 1.0;
  }
  return (options_.ambient * ground_.visibility(p) + key * lit / static_cast<double>(lamps.size())) / whole;
}

}  // namespace patinate
