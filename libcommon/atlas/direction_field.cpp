#include "patinate/atlas/direction_field.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "libcommon/core/parallel.h"
#include "libcommon/geometry/dense_solve.h"
#include "libcommon/geometry/nearest_points.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

using Complex = std::complex<double>;
constexpr double kUvWeight = 1e-4;     ///< Where nothing else is said, and enough for the solve to be definite.
constexpr double kSmoothShare = 0.05;  ///< Share of the mesh's diagonal: directions turn over this length.

/// A triangle's own axes, in which directions are complex numbers.
struct TriangleAxes {
  Vec3 x = Vec3::Zero(), y = Vec3::Zero(), normal = Vec3::Zero();
  double area = 0.0;

  [[nodiscard]] Complex of(const Vec3& v) const { return {x.dot(v), y.dot(v)}; }
};

std::vector<TriangleAxes> triangle_axes(const Mesh& mesh) {
  std::vector<TriangleAxes> axes(mesh.triangles.size());
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    TriangleAxes& a = axes[t];
    const Triangle& c = mesh.triangles[t];
    const Vec3 area = area_vector(mesh, t), edge = mesh.positions[c[1]] - mesh.positions[c[0]];
    if (!(area.norm() > 0.0) || !(edge.norm() > 0.0)) continue;
    a.area = 0.5 * area.norm();
    a.normal = area.normalized();
    a.x = edge.normalized();
    a.y = a.normal.cross(a.x);
  }
  return axes;
}

Vec3 centroid(const Mesh& mesh, std::size_t t) {
  Vec3 sum = Vec3::Zero();
  for (int corner : mesh.triangles[t]) sum += mesh.positions[corner];
  return sum / 3.0;
}

Complex unit(const Complex& z) {
  const double length = std::sqrt(z.real() * z.real() + z.imag() * z.imag());
  return length > 1e-300 ? z / length : Complex(0.0, 0.0);
}

/// Right for someone outside, and down.
FlowFrame frame_of(const TriangleAxes& axes, const Complex& down) {
  FlowFrame frame;
  frame.col(1) = down.real() * axes.x + down.imag() * axes.y;
  frame.col(0) = axes.normal.cross(frame.col(1));
  return frame;
}

/// The system of smooth_frames(): lower half, and right side.
struct FieldSystem {
  std::vector<Eigen::Triplet<Complex>> entries;
  Eigen::VectorXcd right;
  std::vector<double> diagonal;

  explicit FieldSystem(std::size_t n) : right(Eigen::VectorXcd::Zero(static_cast<Eigen::Index>(n))), diagonal(n, 0.0) {}
};

void add_smoothness(const Mesh& mesh, const std::vector<TriangleAxes>& axes, FieldSystem& system) {
  const std::vector<std::array<int, 3>> neighbors = triangle_neighbors(mesh);
  for (std::size_t t = 0; t < axes.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int other = neighbors[t][k];
      if (other <= static_cast<int>(t)) continue;  // Every edge once; -1 never.
      const auto u = static_cast<std::size_t>(other);
      const Vec3& a = mesh.positions[mesh.triangles[t][k]];
      const Vec3& b = mesh.positions[mesh.triangles[t][(k + 1) % 3]];
      const Complex in_t = unit(axes[t].of(b - a)), in_u = unit(axes[u].of(b - a));
      if (in_t == 0.0 || in_u == 0.0 || !(axes[t].area > 0.0) || !(axes[u].area > 0.0)) continue;
      // Centroids lie a third of the heights from the edge; their distance, unfolded, along and across it.
      const double length = (b - a).norm(), across = 2.0 / 3.0 * (axes[t].area + axes[u].area) / length;
      const double along = (b - a).dot(centroid(mesh, u) - centroid(mesh, t)) / length;
      const double weight = length / std::sqrt(across * across + along * along);
      const Complex transport = in_u * std::conj(in_t);  // From t to u.
      system.diagonal[t] += weight;
      system.diagonal[u] += weight;
      system.entries.emplace_back(other, static_cast<int>(t), -weight * transport);
    }
  }
}

}  // namespace

FlowFrames uv_frames(const TexelMap& map) {
  FlowFrames frames(map.mesh().triangles.size());
  for (std::size_t t = 0; t < frames.size(); ++t) frames[t] = map.tangents(static_cast<int>(t));
  return frames;
}

FlowFrames smooth_frames(const TexelMap& map, const std::vector<DirectionGuide>& guides, double smooth_mm,
                         const RunControl& control) {
  const Mesh& mesh = map.mesh();
  if (guides.size() != mesh.triangles.size()) throw InvalidInput("direction field: expected one guide a triangle");
  if (!(smooth_mm > 0.0)) throw InvalidInput("direction field: smooth_mm must be > 0");
  FlowFrames frames = uv_frames(map);
  const std::vector<TriangleAxes> axes = triangle_axes(mesh);
  FieldSystem system(axes.size());
  add_smoothness(mesh, axes, system);
  control.throw_if_stopped();
  for (std::size_t t = 0; t < axes.size(); ++t) {
    const double scale = axes[t].area / (smooth_mm * smooth_mm);
    const auto add = [&](const Vec3& down, double weight) {
      const Complex wanted = unit(axes[t].of(down));
      if (wanted == 0.0 || !(weight > 0.0)) return;
      system.diagonal[t] += weight * scale;
      system.right[static_cast<Eigen::Index>(t)] += weight * scale * wanted;
    };
    add(guides[t].down, guides[t].weight);
    add(frames[t].col(1), kUvWeight);
    system.entries.emplace_back(static_cast<int>(t), static_cast<int>(t),
                                system.diagonal[t] > 0.0 ? system.diagonal[t] : 1.0);
  }
  const auto n = static_cast<Eigen::Index>(axes.size());
  Eigen::SparseMatrix<Complex> matrix(n, n);
  matrix.setFromTriplets(system.entries.begin(), system.entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>, Eigen::Lower> solver(matrix);
  const Eigen::VectorXcd down = solver.solve(system.right);
  if (solver.info() != Eigen::Success || !down.allFinite())
    return frames;  // Areas that no double can weigh: the UVs are left.
  for (std::size_t t = 0; t < axes.size(); ++t) {
    const Complex z = unit(down[static_cast<Eigen::Index>(t)]);
    if (z != 0.0 && axes[t].area > 0.0) frames[t] = frame_of(axes[t], z);
  }
  return frames;
}

namespace {

/// The direction of least curvature of every triangle from how its corners' normals turn [Rusinkiewicz 2004], its sense
/// downward; weighted by how much more the other one bends.
std::vector<DirectionGuide> curvature_guides(const Mesh& mesh, const Vec3& down, double smooth_mm) {
  const std::vector<TriangleAxes> axes = triangle_axes(mesh);
  const std::vector<Vec3> normals = vertex_normals(mesh);
  std::vector<DirectionGuide> guides(axes.size());
  for (std::size_t t = 0; t < axes.size(); ++t) {
    if (!(axes[t].area > 0.0)) continue;
    Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
    Vec3 right = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(mesh.triangles[t][k]),
                 b = static_cast<std::size_t>(mesh.triangles[t][(k + 1) % 3]);
      const Complex e = axes[t].of(mesh.positions[b] - mesh.positions[a]), d = axes[t].of(normals[b] - normals[a]);
      // (l m; m n) e = d, in the least squares of three edges.
      const Vec3 first(e.real(), e.imag(), 0.0), second(0.0, e.real(), e.imag());
      left += first * first.transpose() + second * second.transpose();
      right += first * d.real() + second * d.imag();
    }
    const Vec3 s = solve_ldlt(left, right);
    if (!s.allFinite()) continue;
    const double half = 0.5 * (s[0] - s[2]), spread = std::sqrt(half * half + s[1] * s[1]);
    if (!(spread > 0.0)) continue;
    const bool least_is_upper = std::abs(0.5 * (s[0] + s[2]) + spread) < std::abs(0.5 * (s[0] + s[2]) - spread);
    const double value = 0.5 * (s[0] + s[2]) + (least_is_upper ? spread : -spread);
    // An eigenvector of (l m; m n): the longer of the two rows' answers.
    const Complex v1(s[1], value - s[0]), v2(value - s[2], s[1]);
    const Complex z = unit(std::norm(v1) > std::norm(v2) ? v1 : v2);
    const Vec3 along = z.real() * axes[t].x + z.imag() * axes[t].y;
    const double bend = 2.0 * spread * smooth_mm;
    guides[t] = {along.dot(down) < 0.0 ? Vec3(-along) : along, std::min(1.0, bend * bend)};
  }
  return guides;
}

double smoothing_length(const Mesh& mesh) {
  const double diagonal = bounding_box(mesh).diagonal();
  return std::isfinite(diagonal) && diagonal > 0.0 ? kSmoothShare * diagonal : 1.0;
}

}  // namespace

FlowFrames direction_frames(const TexelMap& map, DirectionKind kind, const Vec3& up, const RunControl& control) {
  if (kind == DirectionKind::Uv) return uv_frames(map);
  if (!(up.norm() > 0.0) || !up.allFinite()) throw InvalidInput("up: expected a direction of some length");
  const Mesh& mesh = map.mesh();
  const Vec3 down = -up.normalized();
  const double smooth_mm = smoothing_length(mesh);
  if (kind == DirectionKind::Curvature)
    return smooth_frames(map, curvature_guides(mesh, down, smooth_mm), smooth_mm, control);
  std::vector<DirectionGuide> guides(mesh.triangles.size());
  for (std::size_t t = 0; t < guides.size(); ++t) {
    const Vec3 area = area_vector(mesh, static_cast<int>(t));
    if (!(area.norm() > 0.0)) continue;
    const Vec3 n = area.normalized(), along = down - n * n.dot(down);
    guides[t] = {along, along.squaredNorm()};
  }
  return smooth_frames(map, guides, smooth_mm, control);
}

FlowFrames curve_frames(const TexelMap& map, const std::vector<std::vector<Vec3>>& curves, const RunControl& control) {
  constexpr double kCurveWeight = 1e3;  ///< A stroke is meant.
  const Mesh& mesh = map.mesh();
  std::vector<Vec3> centroids;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) centroids.push_back(centroid(mesh, t));
  const NearestPoints nearest(centroids);
  const double smooth_mm = smoothing_length(mesh), spacing = 0.1 * smooth_mm;
  std::vector<DirectionGuide> guides(mesh.triangles.size());
  bool has_length = false;
  for (const std::vector<Vec3>& curve : curves) {
    for (std::size_t i = 1; i < curve.size(); ++i) {
      const Vec3 step = curve[i] - curve[i - 1];
      if (!(step.norm() > 0.0)) continue;
      has_length = true;
      const int count = static_cast<int>(std::min(10'000.0, std::ceil(step.norm() / spacing)));
      for (int k = 0; k < count; ++k) {
        const NearestPoints::Found found = nearest.nearest(curve[i - 1] + (k + 0.5) / count * step);
        DirectionGuide& guide = guides[found.index];
        guide.down += step.normalized();
        guide.weight = kCurveWeight;
      }
    }
  }
  if (!has_length) throw InvalidInput("direction: no curve has two different points");
  return smooth_frames(map, guides, smooth_mm, control);
}

FrameInUv frame_in_uv(const FlowFrame& frame, const FlowFrame& uv_tangents) {
  const Eigen::Matrix2d m = uv_tangents.transpose() * frame;  // Columns: the axes along texel x and y (down).
  return {std::atan2(-m(1, 0), m(0, 0)), m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0) < 0.0};
}

FlowFrame frame_from_uv(const FrameInUv& in_uv, const FlowFrame& uv_tangents) {
  const double c = std::cos(in_uv.angle), s = std::sin(in_uv.angle), side = in_uv.is_mirrored ? -1.0 : 1.0;
  Eigen::Matrix2d m;
  m << c, side * s, -s, side * c;
  return uv_tangents * m;
}

}  // namespace patinate
