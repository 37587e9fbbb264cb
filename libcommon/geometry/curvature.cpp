#include "libcommon/geometry/curvature.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Sharpest angle that cotangents are taken of: sin(angle) >= kMinSine for the corner opposite the longest edge.
constexpr double kMinSine = 1e-5;
/// Least share of the mean vertex area that a vertex gets, so that the matrix stays positive definite.
constexpr double kMinMass = 1e-9;

struct Laplacian {
  std::vector<double> mass;                        ///< Mixed Voronoi area of each position [Meyer et al. 2003].
  std::vector<Eigen::Triplet<double>> half_edges;  ///< (i, j, cot / 2) of every triangle corner, i < j.
};

Laplacian assemble(const Mesh& mesh, const std::vector<Vec3>& x) {
  Laplacian out;
  out.mass.assign(x.size(), 0.0);
  out.half_edges.reserve(mesh.triangles.size() * 3);
  for (const Triangle& t : mesh.triangles) {
    std::array<Vec3, 3> edge;  // edge[k] is opposite corner k
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      edge[k] = x[t[(k + 2) % 3]] - x[t[(k + 1) % 3]];
      longest = std::max(longest, edge[k].squaredNorm());
    }
    const double double_area = edge[0].cross(edge[1]).norm();
    if (!(longest > 0.0)) continue;
    // One denominator for all three keeps the triangle's own matrix positive semi-definite, however thin it is.
    const double denominator = std::max(double_area, kMinSine * longest);
    std::array<double, 3> cot{};
    for (std::size_t k = 0; k < 3; ++k) {
      cot[k] = -edge[(k + 1) % 3].dot(edge[(k + 2) % 3]) / denominator;
      const auto [i, j] = std::minmax(t[(k + 1) % 3], t[(k + 2) % 3]);
      out.half_edges.emplace_back(i, j, 0.5 * cot[k]);
    }
    const bool is_obtuse = *std::min_element(cot.begin(), cot.end()) < 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
      const double share = is_obtuse
                               ? (cot[k] < 0.0 ? 0.25 : 0.125) * double_area
                               : (cot[next] * edge[next].squaredNorm() + cot[last] * edge[last].squaredNorm()) / 8.0;
      out.mass[t[k]] += share;
    }
  }
  return out;
}

/// Lower half of M + t L.
SparseMatrix system_matrix(const Laplacian& laplacian, const std::vector<double>& mass, double t) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(laplacian.half_edges.size() * 3 + mass.size());
  for (std::size_t i = 0; i < mass.size(); ++i) {
    entries.emplace_back(static_cast<int>(i), static_cast<int>(i), mass[i]);
  }
  for (const auto& e : laplacian.half_edges) {
    entries.emplace_back(e.row(), e.row(), t * e.value());
    entries.emplace_back(e.col(), e.col(), t * e.value());
    entries.emplace_back(e.col(), e.row(), -t * e.value());
  }
  const auto n = static_cast<Eigen::Index>(mass.size());
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

std::vector<double> mean_curvature(const Mesh& mesh, double scale_mm, const RunControl& control) {
  if (!(scale_mm > 0.0 && std::isfinite(scale_mm))) {
    throw InvalidInput("scale_mm: " + number_text(scale_mm) + " is out of range; use > 0");
  }
  // Lengths in units of the scale around the middle of the box: t = 1/2 whatever the unit is.
  const Vec3 center = bounding_box(mesh).center();
  std::vector<Vec3> x(mesh.positions.size(), Vec3::Zero());
  for (const Triangle& triangle : mesh.triangles) {
    for (int corner : triangle) {
      const auto i = static_cast<std::size_t>(corner);
      x[i] = (mesh.positions[i] - center) / scale_mm;
    }
  }
  constexpr double kTime = 0.5;
  const Laplacian laplacian = assemble(mesh, x);
  double total_mass = 0.0;
  std::int64_t num_used = 0;
  for (double m : laplacian.mass) {
    total_mass += m;
    num_used += m > 0.0;
  }
  if (!(total_mass > 0.0)) throw InvalidInput("mean curvature: the mesh has no area");
  std::vector<double> mass = laplacian.mass;
  for (double& m : mass) m = std::max(m, kMinMass * total_mass / static_cast<double>(num_used));
  control.throw_if_stopped();
  const Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> solver(system_matrix(laplacian, mass, kTime));
  control.throw_if_stopped();
  control.report(0.8);
  if (solver.info() != Eigen::Success) throw InvalidInput("mean curvature: the mesh is too degenerate to be smoothed");
  const auto n = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixX3d right(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    right.row(i) = mass[i] * x[i].transpose();
  }
  const Eigen::MatrixX3d smoothed = solver.solve(right);
  const std::vector<Vec3> normals = vertex_normals(mesh);
  std::vector<double> curvature(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 moved = smoothed.row(static_cast<Eigen::Index>(i)).transpose() - x[i];
    const double h = moved.dot(normals[i]) / (2.0 * kTime) / scale_mm;
    curvature[i] = std::isfinite(h) ? h : 0.0;
  }
  control.report(1.0);
  return curvature;
}

}  // namespace patinate
