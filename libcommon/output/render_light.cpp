#include "libcommon/output/render_light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"

namespace patinate {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kLightRays = 3;        // Per ray of the camera.
constexpr double kRayOffset = 1e-4;  // Of the diagonal, off the surface.
constexpr int kGroundGrid = 96;
constexpr double kGroundExtent = 1.4;      // Half side of that grid, in diagonals.
constexpr double kRefinedEdge = 1.0 / 48;  // Longest edge for the ambient term, in diagonals.
constexpr int kMaxRefined = 400'000;
constexpr std::uint32_t kOcclusion = 31;  // Purposes of random streams.
constexpr std::uint32_t kPixel = 32;
constexpr std::uint64_t kSeed = 20;

// Point i of n of the R2 low-discrepancy sequence [Roberts 2018], shifted.
Vec2 sequence_point(int i, const Vec2& shift) {
  constexpr double kA = 0.7548776662466927, kB = 0.5698402909980532;
  const double a = shift.x() + kA * i, b = shift.y() + kB * i;
  return {a - std::floor(a), b - std::floor(b)};
}

Vec2 disc_point(const Vec2& square) {
  const double r = std::sqrt(square.x()), angle = 2.0 * kPi * square.y();
  return {r * std::cos(angle), r * std::sin(angle)};
}

// Orthonormal tangents [Duff et al. 2017, "Building an orthonormal basis, revisited"].
void tangents(const Vec3& n, Vec3& a, Vec3& b) {
  const double sign = std::copysign(1.0, n.z());
  const double p = -1.0 / (sign + n.z()), q = n.x() * n.y() * p;
  a = {1.0 + sign * n.x() * n.x() * p, sign * q, -sign * n.x()};
  b = {q, sign + n.y() * n.y() * p, -n.y()};
}

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
  return kPi * fresnel * a2 / (kPi * d * d) * nl / (g_light * g_view);
}

Mesh prepared(const Mesh& mesh, const RenderOptions& o) {
  Mesh ready = with_normals(mesh);
  if (o.occlusion_samples > 0)
    ready = refine_edges(std::move(ready), kRefinedEdge * bounding_box(mesh).diagonal(), kMaxRefined);
  return ready;
}

template <class T>
T blend(const std::array<T, 3>& corner, double b1, double b2) {
  return (1.0 - b1 - b2) * corner[0] + b1 * corner[1] + b2 * corner[2];
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
    color[static_cast<std::size_t>(c)] = (1.0 - fy) * top + fy * low;
  }
  return color;
}

LitMesh::LitMesh(const Mesh& mesh, const RenderOptions& options, const SurfaceDetail& detail, const OrbitCamera& camera,
                 const RunControl& control)
    : mesh_(prepared(mesh, options)),
      options_(options),
      detail_(detail),
      tangents_(detail.normals.empty() ? CornerTangents{} : corner_tangents(mesh_)),
      scene_(mesh_),
      box_(bounding_box(mesh_)),
      diagonal_(box_.diagonal()) {
  up_ = world_from_y_up(Vec3::UnitY(), options.up);
  const double azimuth = (options.azimuth_deg + options.light_azimuth_deg) * kPi / 180.0;
  const double elevation = options.light_elevation_deg * kPi / 180.0;
  light_ = world_from_y_up(
      {std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth)},
      options.up);
  tangents(light_, light_x_, light_y_);
  tangents(up_, ground_x_, ground_y_);
  ground_height_ = std::numeric_limits<double>::infinity();
  for (const Triangle& t : mesh_.triangles) {
    for (const int i : t)
      ground_height_ = std::min(ground_height_, mesh_.positions[static_cast<std::size_t>(i)].dot(up_));
  }
  // Seen from below, the ground would hide the object.
  if (camera.position.dot(up_) <= ground_height_) options_.ground = false;
  light_vertices(control.part(0.0, 0.7));
  if (options_.ground) light_ground(control.part(0.7, 1.0));
}

double LitMesh::ambient_visibility(const Vec3& p, const Vec3& normal, std::uint64_t item) const {
  RandomStream random(kSeed, item, kOcclusion);
  const Vec2 shift(random.uniform(), random.uniform());
  Vec3 a, b;
  tangents(normal, a, b);
  const double reach = options_.occlusion_reach * diagonal_;
  double open = 0.0;
  for (int i = 0; i < options_.occlusion_samples; ++i) {
    const Vec2 d = disc_point(sequence_point(i, shift));
    const double up = std::sqrt(std::max(0.0, 1.0 - d.squaredNorm()));
    const Vec3 direction = d.x() * a + d.y() * b + up * normal;
    const std::optional<RayHit> hit = scene_.first_hit(p, direction, 0.0, reach);
    // Far things hide less than near ones: the term has no hard range.
    open += hit ? std::pow(hit->distance / reach, 2) : 1.0;
  }
  return open / options_.occlusion_samples;
}

void LitMesh::light_vertices(const RunControl& control) {
  ambient_.assign(mesh_.positions.size(), 1.0f);
  if (options_.occlusion_samples == 0) return;
  const std::vector<Vec3> normals = vertex_normals(mesh_);
  const double epsilon = 2e-4 * diagonal_;
  parallel_for(static_cast<std::int64_t>(ambient_.size()), 256, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      ambient_[k] = static_cast<float>(
          ambient_visibility(mesh_.positions[k] + epsilon * normals[k], normals[k], static_cast<std::uint64_t>(i)));
    }
  });
}

void LitMesh::light_ground(const RunControl& control) {
  ground_visibility_.assign(std::size_t{kGroundGrid} * kGroundGrid, 1.0f);
  if (options_.occlusion_samples == 0) return;
  parallel_for(kGroundGrid, 4, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t j = begin; j < end; ++j) {
      for (std::int64_t i = 0; i < kGroundGrid; ++i) {
        const double u = (2.0 * static_cast<double>(i) / (kGroundGrid - 1) - 1.0) * kGroundExtent * diagonal_;
        const double v = (2.0 * static_cast<double>(j) / (kGroundGrid - 1) - 1.0) * kGroundExtent * diagonal_;
        const Vec3 center = box_.center() - (box_.center().dot(up_) - ground_height_ + 1e-4 * diagonal_) * up_;
        const std::size_t k = static_cast<std::size_t>(j * kGroundGrid + i);
        ground_visibility_[k] = static_cast<float>(
            ambient_visibility(center + u * ground_x_ + v * ground_y_, up_, (std::uint64_t{1} << 40) + k));
      }
    }
  });
}

Vec3 LitMesh::light_direction(int x, int y, int sample, int num_samples) const {
  if (!(options_.light_size_deg > 0.0)) return light_;
  RandomStream random(
      kSeed, (static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32) + static_cast<std::uint32_t>(x), kPixel);
  const Vec2 shift(random.uniform(), random.uniform());
  // Stratified by radius over the pixel's samples, so that few of them cover the light evenly.
  Vec2 square = sequence_point(sample, shift);
  square.x() = (sample + square.x()) / num_samples;
  const double radius = std::tan(options_.light_size_deg * kPi / 180.0);
  const Vec2 d = radius * disc_point(square);
  return (light_ + d.x() * light_x_ + d.y() * light_y_).normalized();
}

LitPoint LitMesh::look(const Vec3& origin, const Vec3& direction, int x, int y, int sample, int num_samples) const {
  std::array<Vec3, kLightRays> to_light;
  for (int i = 0; i < kLightRays; ++i) {
    to_light[static_cast<std::size_t>(i)] = light_direction(x, y, sample * kLightRays + i, num_samples * kLightRays);
  }
  if (const std::optional<RayHit> hit = scene_.first_hit(origin, direction)) return surface(*hit, direction, to_light);
  LitPoint point;
  const double fall = direction.dot(up_);
  if (options_.ground && fall < -1e-6) {
    const double distance = (ground_height_ - origin.dot(up_)) / fall;
    point.diffuse = ground_light(origin + distance * direction, to_light);
  }
  return point;
}

// The normal that the texture tells, in the frame of the smooth one.
Vec3 LitMesh::detailed_normal(const Vec3& smooth, std::size_t triangle, const RayHit& hit, const Vec2& uv) const {
  const Vec3 along = blend(tangents_.tangent[triangle], hit.b1, hit.b2);
  const Vec3 flat = along - along.dot(smooth) * smooth;
  if (!(flat.norm() > 1e-9)) return smooth;
  const Vec3 tangent = flat.normalized();
  const Vec3 up = (tangents_.is_mirrored[triangle] ? -1.0 : 1.0) * smooth.cross(tangent);
  const std::array<double, 3> n = texture_at(detail_.normals, uv.x(), uv.y());
  const Vec3 normal = n[0] * tangent + n[1] * up + n[2] * smooth;
  return normal.norm() > 1e-6 ? Vec3(normal.normalized()) : smooth;
}

LitPoint LitMesh::surface(const RayHit& hit, const Vec3& direction, std::span<const Vec3> to_light) const {
  const std::size_t t = static_cast<std::size_t>(hit.triangle);
  std::array<Vec3, 3> p, n;
  std::array<Vec2, 3> uv;
  std::array<double, 3> open;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t corner = static_cast<std::size_t>(mesh_.triangles[t][k]);
    p[k] = mesh_.positions[corner];
    n[k] = mesh_.normals[static_cast<std::size_t>(mesh_.normal_triangles[t][k])];
    uv[k] = mesh_.uvs[static_cast<std::size_t>(mesh_.uv_triangles[t][k])];
    open[k] = static_cast<double>(ambient_[corner]);
  }
  Vec3 face = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  Vec3 normal = blend(n, hit.b1, hit.b2).normalized();
  const Vec2 at = blend(uv, hit.b1, hit.b2);
  if (!detail_.normals.empty()) normal = detailed_normal(normal, t, hit, at);
  const double roughness = detail_.roughness.empty()
                               ? options_.roughness
                               : std::clamp(texture_at(detail_.roughness, at.x(), at.y())[0], 0.05, 1.0);
  const Vec3 place = blend(p, hit.b1, hit.b2);
  // Both sides show: a surface seen from behind is lit like one that faces the viewer.
  const double side = face.dot(direction) > 0.0 ? -1.0 : 1.0;
  face *= side;
  normal *= side;

  LitPoint point;
  point.is_hit = true;
  point.uv = at;
  const double gradient = 1.0 - options_.ambient_gradient * 0.5 * (1.0 - normal.dot(up_));
  point.diffuse = options_.ambient * gradient * (options_.occlusion_samples > 0 ? blend(open, hit.b1, hit.b2) : 1.0);
  if (!(options_.light > 0.0)) return point;
  std::array<Vec3, 3> lifted;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 off = place - p[k];
    lifted[k] = place - std::min(0.0, off.dot(side * n[k])) * side * n[k];
  }
  const Vec3 from = blend(lifted, hit.b1, hit.b2) + kRayOffset * diagonal_ * face;
  const double share = options_.light / static_cast<double>(to_light.size());
  for (const Vec3& light : to_light) {
    const double facing = normal.dot(light);
    if (!(facing > 0.0) || scene_.first_hit(from, light)) continue;
    point.diffuse += share * facing;
    if (options_.specular > 0.0)
      point.specular += share * coat(normal, -direction, light, options_.specular, roughness);
  }
  return point;
}

// Share of the light on open ground that arrives at p.
double LitMesh::ground_light(const Vec3& p, std::span<const Vec3> to_light) const {
  const Vec3 off = p - box_.center();
  const double u = off.dot(ground_x_) / (kGroundExtent * diagonal_),
               v = off.dot(ground_y_) / (kGroundExtent * diagonal_);
  double open = 1.0;
  if (std::abs(u) < 1.0 && std::abs(v) < 1.0) {
    const double x = 0.5 * (u + 1.0) * (kGroundGrid - 1), y = 0.5 * (v + 1.0) * (kGroundGrid - 1);
    const int i = std::min(static_cast<int>(x), kGroundGrid - 2), j = std::min(static_cast<int>(y), kGroundGrid - 2);
    const auto at = [&](int a, int b) {
      return static_cast<double>(ground_visibility_[static_cast<std::size_t>(b * kGroundGrid + a)]);
    };
    const double fx = x - i, fy = y - j;
    open = (1.0 - fy) * ((1.0 - fx) * at(i, j) + fx * at(i + 1, j)) +
           fy * ((1.0 - fx) * at(i, j + 1) + fx * at(i + 1, j + 1));
    // Fades at the rim of the grid, so that its end is not seen.
    const double edge = std::clamp(4.0 * (1.0 - std::max(std::abs(u), std::abs(v))), 0.0, 1.0);
    open = 1.0 - edge * (1.0 - open);
  }
  const double key = options_.light * std::max(0.0, light_.dot(up_));
  const double whole = options_.ambient + key;
  if (!(whole > 0.0)) return 1.0;
  double lit = 0.0;
  for (const Vec3& light : to_light) {
    if (light.dot(up_) > 0.0 && !scene_.first_hit(p + kRayOffset * diagonal_ * up_, light)) lit += 1.0;
  }
  return (options_.ambient * open + key * lit / static_cast<double>(to_light.size())) / whole;
}

}  // namespace patinate
