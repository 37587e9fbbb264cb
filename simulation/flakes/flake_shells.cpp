#include "simulation/flakes/flake_shells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/geometry/mesh_append.h"
#include "patinate/core/error.h"
#include "simulation/flakes/flake_outline.h"

namespace patinate::simulation {

namespace {

std::int64_t num_triangles(const FlakeOutline& outline) {
  return 4 * static_cast<std::int64_t>(outline.squares.size()) + 2 * static_cast<std::int64_t>(outline.edges.size());
}

/// The finest outlines with at most so many triangles; the largest of the coarsest otherwise, in their order.
std::vector<FlakeOutline> bounded_outlines(const LiftedFlakes& flakes, std::int64_t most, int& step) {
  std::vector<FlakeOutline> outlines;
  for (step = 1;; ++step) {
    outlines = flake_outlines(flakes, step);
    const std::int64_t sum = std::accumulate(outlines.begin(), outlines.end(), std::int64_t{0},
                                             [](std::int64_t n, const auto& o) { return n + num_triangles(o); });
    if (sum <= most) return outlines;
    if (step == kMostFlakeStep) break;
  }
  std::stable_sort(outlines.begin(), outlines.end(),
                   [](const FlakeOutline& a, const FlakeOutline& b) { return a.squares.size() > b.squares.size(); });
  std::size_t kept = 0;
  for (std::int64_t sum = 0; kept < outlines.size(); ++kept) {
    sum += num_triangles(outlines[kept]);
    if (sum > most) break;
  }
  outlines.resize(kept);
  std::sort(outlines.begin(), outlines.end(),
            [](const FlakeOutline& a, const FlakeOutline& b) { return a.flake < b.flake; });
  return outlines;
}

/// A place of the surface below a flake.
struct Ground {
  Vec3 place = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  Eigen::Matrix<double, 3, 2> steps = Eigen::Matrix<double, 3, 2>::Zero();  ///< Surface vectors of one texel, mm.
};

/// A point of a shell's middle surface.
struct Bent {
  Vec3 middle = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
};

/// One shell after the other; each knows its flake alone.
class ShellMaker {
 public:
  ShellMaker(const LiftedFlakes& flakes, const TexelMap& map, const ImageF& heights, int step)
      : flakes_(flakes), map_(map), heights_(heights), step_(step) {}

  [[nodiscard]] FlakeShells make(const FlakeOutline& outline) const {
    const LiftedFlake& flake = flakes_.flakes[static_cast<std::size_t>(outline.flake)];
    FlakeShells shell;
    Mesh& mesh = shell.mesh;
    std::vector<Bent> bent;
    for (const Vec2& place : outline.places) bent.push_back(bend(outline, flake, place));
    const double half = 0.5 * flake.thickness_mm;
    const int n = static_cast<int>(bent.size());
    for (const Bent& at : bent) mesh.positions.push_back(at.middle + half * at.normal);
    for (const Bent& at : bent) mesh.positions.push_back(at.middle - half * at.normal);
    for (const Vec2& place : outline.places)
      mesh.uvs.push_back({place.x() / flakes_.width, 1.0 - place.y() / flakes_.height});
    const bool is_mirrored = is_mirrored_chart(outline);
    const auto add = [&](Triangle corners, Triangle uvs, FlakeSide side) {
      if (is_mirrored) {
        std::swap(corners[1], corners[2]);
        std::swap(uvs[1], uvs[2]);
      }
      mesh.triangles.push_back(corners);
      mesh.uv_triangles.push_back(uvs);
      shell.sides.push_back(side);
    };
    for (const auto& [a, b, c, d] : outline.squares) {
      add({a, b, c}, {a, b, c}, FlakeSide::Top);
      add({a, c, d}, {a, c, d}, FlakeSide::Top);
    }
    for (const auto& [a, b, c, d] : outline.squares) {
      add({n + a, n + c, n + b}, {a, c, b}, FlakeSide::Under);
      add({n + a, n + d, n + c}, {a, d, c}, FlakeSide::Under);
    }
    const std::size_t first_wall = mesh.triangles.size();
    for (const OutlineEdge& e : outline.edges) {
      add({n + e.a, n + e.b, e.b}, {e.a, e.b, e.b}, FlakeSide::Under);
      add({n + e.a, e.b, e.a}, {e.a, e.b, e.a}, FlakeSide::Under);
    }
    shell.flakes.assign(mesh.triangles.size(), outline.flake);
    mesh.triangle_surface.assign(mesh.triangles.size(), surface_below(outline));
    add_normals(mesh, first_wall);
    return shell;
  }

 private:
  /// Smooth over either side, and around the walls.
  static void add_normals(Mesh& mesh, std::size_t first_wall) {
    const std::size_t n = mesh.positions.size();
    std::vector<Vec3> sums(2 * n, Vec3::Zero());  // Of the sides, then of the walls.
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::size_t first = t < first_wall ? 0 : n;
      const Vec3 area = area_vector(mesh, static_cast<int>(t));
      Triangle& normals = mesh.normal_triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t at = first + static_cast<std::size_t>(mesh.triangles[t][k]);
        sums[at] += area;
        normals[k] = static_cast<int>(at);
      }
    }
    for (const Vec3& sum : sums) mesh.normals.push_back(sum.norm() > 0.0 ? Vec3(sum.normalized()) : Vec3::UnitZ());
  }

  /// The flake's texel nearest to a place; -1 if none is near.
  [[nodiscard]] TexelId texel_near(std::int32_t flake, const Vec2& place) const {
    const int cx = static_cast<int>(std::floor(place.x())), cy = static_cast<int>(std::floor(place.y()));
    const int reach = step_ + 1;
    double least = std::numeric_limits<double>::infinity();
    TexelId nearest = -1;
    for (int y = cy - reach; y <= cy + reach; ++y) {
      for (int x = cx - reach; x <= cx + reach; ++x) {
        if (!flakes_.is_inside(x, y) || flakes_.flake[flakes_.index(x, y)] != flake) continue;
        const double squared = (place - Vec2(x + 0.5, y + 0.5)).squaredNorm();
        const auto texel = static_cast<TexelId>(flakes_.index(x, y));
        if (squared < least && map_.is_covered(texel)) nearest = texel;
        if (nearest == texel) least = squared;
      }
    }
    return nearest;
  }

  /// In the plane of the triangle that the nearest texel shows.
  [[nodiscard]] Ground ground_at(std::int32_t flake, const Vec2& place) const {
    const TexelId texel = texel_near(flake, place);
    if (texel < 0) return {};
    const int triangle = map_.triangle(texel);
    const Mesh& mesh = map_.mesh();
    const Triangle& uv = mesh.uv_triangles[triangle];
    const auto at = [&](int k) {
      return Vec2(mesh.uvs[uv[k]].x() * flakes_.width, (1.0 - mesh.uvs[uv[k]].y()) * flakes_.height);
    };
    Eigen::Matrix2d sides;
    sides << at(1) - at(0), at(2) - at(0);
    const Vec2 b = sides.inverse() * (place - at(0));
    const Triangle &p = mesh.triangles[triangle], &n = mesh.normal_triangles[triangle];
    Ground ground;
    ground.place =
        (1.0 - b.x() - b.y()) * mesh.positions[p[0]] + b.x() * mesh.positions[p[1]] + b.y() * mesh.positions[p[2]];
    const double b1 = std::clamp(b.x(), 0.0, 1.0), b2 = std::clamp(b.y(), 0.0, 1.0 - b1);
    ground.normal =
        ((1.0 - b1 - b2) * mesh.normals[n[0]] + b1 * mesh.normals[n[1]] + b2 * mesh.normals[n[2]]).normalized();
    ground.steps = map_.mm_per_texel(triangle);
    return ground;
  }

  /// From the nearest place where the layer holds, mm along the surface.
  [[nodiscard]] Vec3 way_from_hinge(const FlakeOutline& outline, const Ground& ground, const Vec2& place) const {
    const Eigen::Matrix2d metric = ground.steps.transpose() * ground.steps;
    double least = std::numeric_limits<double>::infinity();
    Vec2 way = Vec2::Zero();
    for (const OutlineEdge& e : outline.edges) {
      if (!e.is_hinge) continue;
      const Vec2 along = outline.places[e.b] - outline.places[e.a], off = place - outline.places[e.a];
      const double length2 = along.dot(metric * along);
      const double share = length2 > 0.0 ? std::clamp(off.dot(metric * along) / length2, 0.0, 1.0) : 0.0;
      const Vec2 from = off - share * along;
      const double squared = from.dot(metric * from);
      if (squared < least) way = from;
      least = std::min(least, squared);
    }
    return ground.steps * way;
  }

  [[nodiscard]] double height_at(const Vec2& place) const {
    if (heights_.empty()) return 0.0;
    const double x = std::clamp(place.x() - 0.5, 0.0, heights_.width() - 1.0);
    const double y = std::clamp(place.y() - 0.5, 0.0, heights_.height() - 1.0);
    const int x0 = std::min(static_cast<int>(x), heights_.width() - 2),
              y0 = std::min(static_cast<int>(y), heights_.height() - 2);
    const double fx = x - x0, fy = y - y0;
    const auto at = [&](int dx, int dy) { return static_cast<double>(heights_.at(x0 + dx, y0 + dy)); };
    return (1.0 - fy) * ((1.0 - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1.0 - fx) * at(0, 1) + fx * at(1, 1));
  }

  [[nodiscard]] Bent bend(const FlakeOutline& outline, const LiftedFlake& flake, const Vec2& place) const {
    const Ground ground = ground_at(outline.flake, place);
    const Vec3 way = way_from_hinge(outline, ground, place);
    const Vec3 level = way - ground.normal * ground.normal.dot(way);
    const double x = way.norm();
    const Vec3 ahead = level.norm() > 0.0 ? Vec3(level.normalized()) : Vec3::Zero();
    const double radius = flake.radius_mm, angle = std::min(x / radius, kMostCurl);
    const double sine = std::sin(angle), cosine = std::cos(angle);
    double along = x, up = 0.0;
    if (angle > 0.0) {
      const double straight = std::max(0.0, x - kMostCurl * radius);
      along = radius * sine + straight * cosine;
      up = radius * (1.0 - cosine) + straight * sine;
    }
    const double texel_mm = std::sqrt(ground.steps.col(0).cross(ground.steps.col(1)).norm());
    const double sunk = texel_mm > 0.0 ? kSunkShare * std::max(0.0, 1.0 - x / texel_mm) : 0.0;
    const double low = (0.5 + sunk) * flake.thickness_mm;
    return {.middle = ground.place + (height_at(place) - low + up) * ground.normal + (along - x) * ahead,
            .normal = (cosine * ground.normal - sine * ahead).normalized()};
  }

  [[nodiscard]] int surface_below(const FlakeOutline& outline) const {
    const TexelId texel = texel_near(outline.flake, outline.places[outline.squares.front()[0]]);
    const std::vector<int>& surfaces = map_.mesh().triangle_surface;
    return texel < 0 || surfaces.empty() ? 0 : surfaces[map_.triangle(texel)];
  }

  /// Whether pictures on the surface are mirrored there.
  [[nodiscard]] bool is_mirrored_chart(const FlakeOutline& outline) const {
    const auto& [a, b, c, d] = outline.squares.front();
    const Ground ground = ground_at(outline.flake, 0.5 * (outline.places[a] + outline.places[c]));
    return ground.steps.col(0).cross(ground.steps.col(1)).dot(ground.normal) > 0.0;
  }

  const LiftedFlakes& flakes_;
  const TexelMap& map_;
  const ImageF& heights_;
  int step_;
};

}  // namespace

FlakeShells flake_shells(const LiftedFlakes& flakes, const TexelMap& map, const ImageF& heights, int most_triangles,
                         const RunControl& control) {
  if (map.width() != flakes.width || map.height() != flakes.height ||
      (!heights.empty() && (heights.width() != flakes.width || heights.height() != flakes.height)))
    throw InvalidInput("the flakes, their surface and their heights are of different sizes");
  FlakeShells all;
  if (flakes.flakes.empty()) return all;
  int step = 1;
  const std::vector<FlakeOutline> outlines = bounded_outlines(flakes, most_triangles, step);
  const ShellMaker maker(flakes, map, heights, step);
  std::vector<FlakeShells> shells(outlines.size());
  parallel_for(static_cast<std::int64_t>(outlines.size()), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      control.throw_if_stopped();
      shells[static_cast<std::size_t>(k)] = maker.make(outlines[static_cast<std::size_t>(k)]);
    }
  });
  for (const FlakeShells& shell : shells) {
    append_mesh(all.mesh, shell.mesh);
    all.sides.insert(all.sides.end(), shell.sides.begin(), shell.sides.end());
    all.flakes.insert(all.flakes.end(), shell.flakes.begin(), shell.flakes.end());
  }
  all.mesh.surfaces = map.mesh().surfaces;
  return all;
}

}  // namespace patinate::simulation
