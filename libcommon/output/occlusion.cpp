#include "libcommon/output/occlusion.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/output/orbit_camera.h"
#include "libcommon/output/sampling.h"

namespace patinate {

namespace {

constexpr int kGroundGrid = 96;
constexpr double kGroundExtent = 1.4;      // Half side of that grid, in diagonals.
constexpr double kRefinedEdge = 1.0 / 48;  // Longest edge for the ambient term, in diagonals.
constexpr int kMaxRefined = 400'000;
constexpr std::uint32_t kOcclusion = 31;  // Purpose of random streams.

double ambient_visibility(const RayScene& scene, double diagonal, const RenderOptions& options, const Vec3& p,
                          const Vec3& normal, std::uint64_t item) {
  RandomStream random(kRenderSeed, item, kOcclusion);
  const Vec2 shift(random.uniform(), random.uniform());
  Vec3 a, b;
  tangents(normal, a, b);
  const double reach = options.occlusion_reach * diagonal;
  double open = 0.0;
  for (int i = 0; i < options.occlusion_samples; ++i) {
    const Vec2 d = disc_point(sequence_point(i, shift));
    const double up = std::sqrt(std::max(0.0, 1.0 - d.squaredNorm()));
    const Vec3 direction = d.x() * a + d.y() * b + up * normal;
    const std::optional<RayHit> hit = scene.first_hit(p, direction, 0.0, reach);
    // Far things hide less than near ones: the term has no hard range.
    open += hit ? std::pow(hit->distance / reach, 2) : 1.0;
  }
  return open / options.occlusion_samples;
}

}  // namespace

Mesh refined_for_occlusion(const Mesh& mesh, const RenderOptions& options) {
  Mesh ready = with_normals(mesh);
  if (options.occlusion_samples > 0)
    ready = refine_edges(std::move(ready), kRefinedEdge * bounding_box(mesh).diagonal(), kMaxRefined);
  return ready;
}

std::vector<float> occlusion_at_vertices(const Mesh& mesh, const RayScene& scene, double diagonal,
                                         const RenderOptions& options, const RunControl& control) {
  std::vector<float> open(mesh.positions.size(), 1.0f);
  if (options.occlusion_samples == 0) return open;
  const std::vector<Vec3> normals = vertex_normals(mesh);
  const double epsilon = 2e-4 * diagonal;
  parallel_for(static_cast<std::int64_t>(open.size()), 256, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      control.throw_if_stopped();  // Options may ask for thousands of rays.
      const std::size_t k = i;
      open[k] =
          static_cast<float>(ambient_visibility(scene, diagonal, options, mesh.positions[k] + epsilon * normals[k],
                                                normals[k], static_cast<std::uint64_t>(i)));
    }
  });
  return open;
}

Ground::Ground(const Mesh& mesh, const Box& box, UpAxis up)
    : box_(box),
      diagonal_(box.diagonal()),
      up_(world_from_y_up(Vec3::UnitY(), up)),
      height_(std::numeric_limits<double>::infinity()) {
  tangents(up_, x_, y_);
  for (const Triangle& t : mesh.triangles) {
    for (const int i : t) height_ = std::min(height_, mesh.positions[i].dot(up_));
  }
}

void Ground::find_visibility(const RayScene& scene, const RenderOptions& options, const RunControl& control) {
  visibility_.assign(std::size_t{kGroundGrid} * kGroundGrid, 1.0f);
  if (options.occlusion_samples == 0) return;
  parallel_for(kGroundGrid, 4, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t j = begin; j < end; ++j) {
      for (std::int64_t i = 0; i < kGroundGrid; ++i) {
        control.throw_if_stopped();
        const double u = (2.0 * static_cast<double>(i) / (kGroundGrid - 1) - 1.0) * kGroundExtent * diagonal_;
        const double v = (2.0 * static_cast<double>(j) / (kGroundGrid - 1) - 1.0) * kGroundExtent * diagonal_;
        const Vec3 center = box_.center() - (box_.center().dot(up_) - height_ + 1e-4 * diagonal_) * up_;
        const std::size_t k = j * kGroundGrid + i;
        visibility_[k] = static_cast<float>(
            ambient_visibility(scene, diagonal_, options, center + u * x_ + v * y_, up_, (std::uint64_t{1} << 40) + k));
      }
    }
  });
}

double Ground::visibility(const Vec3& p) const {
  const Vec3 off = p - box_.center();
  const double u = off.dot(x_) / (kGroundExtent * diagonal_), v = off.dot(y_) / (kGroundExtent * diagonal_);
  if (visibility_.empty() || !(std::abs(u) < 1.0) || !(std::abs(v) < 1.0)) return 1.0;
  const double x = 0.5 * (u + 1.0) * (kGroundGrid - 1), y = 0.5 * (v + 1.0) * (kGroundGrid - 1);
  const int i = std::min(static_cast<int>(x), kGroundGrid - 2), j = std::min(static_cast<int>(y), kGroundGrid - 2);
  const auto at = [&](int a, int b) { return static_cast<double>(visibility_[b * kGroundGrid + a]); };
  const double fx = x - i, fy = y - j;
  const double open = (1.0 - fy) * ((1.0 - fx) * at(i, j) + fx * at(i + 1, j)) +
                      fy * ((1.0 - fx) * at(i, j + 1) + fx * at(i + 1, j + 1));
  // Fades at the rim of the grid, so that its end is not seen.
  const double edge = std::clamp(4.0 * (1.0 - std::max(std::abs(u), std::abs(v))), 0.0, 1.0);
  return 1.0 - edge * (1.0 - open);
}

}  // namespace patinate
