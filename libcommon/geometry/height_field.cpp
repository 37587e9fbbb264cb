#include "libcommon/geometry/height_field.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr int kMaxGridSide = 4096;
constexpr double kCut = 3.0;  ///< Cut of the Gaussian, in standard deviations.
constexpr std::int64_t kRowChunk = 8;
constexpr double kMinPivot =
    1e-7;  ///< Pivot of the fit's equations: below, the surroundings do not tell six coefficients.

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;

/// Powers of the monomials 1, x, y, x^2, x y, y^2 of the fit.
constexpr std::array<std::array<int, 2>, 6> kPowers{{{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};

/// weights[p][k] = Gaussian times offset^p, the offset in standard deviations.
struct Kernel {
  int radius;
  std::array<std::vector<double>, 5> weights;

  explicit Kernel(double sigma_px) : radius(std::max(1, static_cast<int>(std::ceil(kCut * sigma_px)))) {
    for (int k = -radius; k <= radius; ++k) {
      const double u = k / sigma_px;
      double w = std::exp(-0.5 * u * u);
      for (auto& list : weights) {
        list.push_back(w);
        w *= u;
      }
    }
  }
};

/// Sums of Gaussian x^i over a row, of 1 (i <= 4) and of the height (i <= 2), where something is seen.
struct RowMoments {
  std::vector<std::array<double, 8>> at;
};

RowMoments row_moments(const HeightField& field, double middle, const Kernel& kernel, int y) {
  const int width = field.height_mm.width();
  RowMoments out;
  out.at.assign(static_cast<std::size_t>(width), {});
  for (int x = 0; x < width; ++x) {
    auto& sums = out.at[x];
    for (int q = std::max(0, x - kernel.radius); q <= std::min(width - 1, x + kernel.radius); ++q) {
      if (field.seen.at(q, y) == 0) continue;
      const std::size_t k = q - x + kernel.radius;
      const double h = field.height_mm.at(q, y) - middle;
      for (std::size_t i = 0; i < 5; ++i) sums[i] += kernel.weights[i][k];
      for (std::size_t i = 0; i < 3; ++i) sums[5 + i] += kernel.weights[i][k] * h;
    }
  }
  return out;
}

/// @param weight  Sum of all weights of a whole window.
double curvature_of(const std::array<std::array<double, 5>, 5>& ones,
                    const std::array<std::array<double, 3>, 3>& heights, double weight, double sigma_mm) {
  Matrix6 a;
  Vec6 b;
  for (std::size_t r = 0; r < 6; ++r) {
    for (std::size_t c = 0; c < 6; ++c) {
      a(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) =
          ones[kPowers[r][0] + kPowers[c][0]][kPowers[r][1] + kPowers[c][1]] / weight;
    }
    b(static_cast<Eigen::Index>(r)) = heights[kPowers[r][0]][kPowers[r][1]] / weight;
  }
  const Eigen::LDLT<Matrix6> solver(a);
  if (!(solver.vectorD().minCoeff() > kMinPivot)) return 0.0;
  const Vec6 fit = solver.solve(b);
  const double hx = fit(1) / sigma_mm, hy = fit(2) / sigma_mm;
  const double hxx = 2.0 * fit(3) / (sigma_mm * sigma_mm), hxy = fit(4) / (sigma_mm * sigma_mm),
               hyy = 2.0 * fit(5) / (sigma_mm * sigma_mm);
  const double steep = 1.0 + hx * hx + hy * hy;
  return ((1.0 + hx * hx) * hyy - 2.0 * hx * hy * hxy + (1.0 + hy * hy) * hxx) / (2.0 * steep * std::sqrt(steep));
}

}  // namespace

Vec2 HeightField::grid_position(const Vec3& point) const {
  const Vec3 offset = (point - origin) / spacing_mm;
  return {offset.dot(right), offset.dot(down)};
}

HeightField height_field(const Mesh& mesh, const RayScene& scene, const Vec3& viewer, double spacing_mm,
                         const RunControl& control) {
  const Box box = bounding_box(mesh);
  if (!(spacing_mm > 0.0 && std::isfinite(spacing_mm))) throw InvalidInput("height field: its spacing must be > 0");
  if (!(box.diagonal() > 0.0)) throw InvalidInput("height field: the mesh has no extent");
  HeightField field;
  field.viewer = viewer;
  // The axis that is furthest from the viewer's makes rows run like the world's x wherever that can be.
  const Vec3 aside = std::abs(viewer.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  field.right = (aside - aside.dot(viewer) * viewer).normalized();
  field.down = field.right.cross(viewer);
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  double top = -std::numeric_limits<double>::infinity();
  for (const Triangle& triangle : mesh.triangles) {
    for (int corner : triangle) {
      const Vec3& p = mesh.positions[corner];
      const Vec2 at(p.dot(field.right), p.dot(field.down));
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
      top = std::max(top, p.dot(viewer));
    }
  }
  const Vec2 extent = high - low;
  field.spacing_mm = std::max(spacing_mm, extent.maxCoeff() / (kMaxGridSide - 2));
  const int width = static_cast<int>(extent.x() / field.spacing_mm) + 1,
            height = static_cast<int>(extent.y() / field.spacing_mm) + 1;
  // Centered, so that no row of rays runs along the border of a mesh that ends there.
  const Vec2 start = 0.5 * (low + high) - 0.5 * field.spacing_mm * Vec2(width - 1, height - 1);
  field.origin = start.x() * field.right + start.y() * field.down + box.center().dot(viewer) * viewer;
  field.height_mm = Image<double>(width, height);
  field.seen = ImageU8(width, height);
  const double above = top - box.center().dot(viewer) + 0.01 * box.diagonal();
  parallel_for(height, kRowChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        const Vec3 from = field.origin + field.spacing_mm * (x * field.right + y * field.down) + above * viewer;
        const std::optional<RayHit> hit = scene.first_hit(from, -viewer);
        if (!hit) continue;
        // The plane of the triangle, in double: the ray's own distance is a float.
        const Vec3 area = area_vector(mesh, hit->triangle);
        const Vec3& corner = mesh.positions[mesh.triangles[static_cast<std::size_t>(hit->triangle)][0]];
        const double slope = area.dot(viewer);
        const double exact = std::abs(slope) > 1e-6 * area.norm() ? (from - corner).dot(area) / slope : hit->distance;
        field.height_mm.at(x, y) =
            above - (std::abs(exact - hit->distance) < 0.01 * box.diagonal() ? exact : hit->distance);
        field.seen.at(x, y) = 255;
      }
    }
  });
  const auto seen = field.seen.values();
  if (std::all_of(seen.begin(), seen.end(), [](std::uint8_t v) { return v == 0; })) {
    throw InvalidInput("height field: nothing of the mesh is seen from there");
  }
  return field;
}

ImageF height_curvature(const HeightField& field, double width_mm, const RunControl& control) {
  const double sigma_px = width_mm / field.spacing_mm;
  if (!(sigma_px >= 0.5 && sigma_px <= 1000.0)) {
    throw InvalidInput("accessibility: a width of " + short_number_text(width_mm) +
                       " mm is out of range for heights every " + short_number_text(field.spacing_mm) +
                       " mm; use half of that to 1000 times that");
  }
  const int width = field.height_mm.width(), height = field.height_mm.height();
  const Kernel kernel(sigma_px);
  double weight = 0.0, middle = 0.0;
  for (double w : kernel.weights[0]) weight += w;
  weight *= weight;
  std::int64_t num_seen = 0;
  for (std::int64_t i = 0; i < field.seen.num_pixels(); ++i) {
    if (field.seen.data()[i] == 0) continue;
    middle += field.height_mm.data()[i];
    ++num_seen;
  }
  if (num_seen > 0) middle /= static_cast<double>(num_seen);
  std::vector<RowMoments> rows(static_cast<std::size_t>(height));
  parallel_for(height, kRowChunk, control.part(0.0, 0.3), [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) rows[y] = row_moments(field, middle, kernel, static_cast<int>(y));
  });
  ImageF out(width, height);
  parallel_for(height, kRowChunk, control.part(0.3, 1.0), [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        if (field.seen.at(x, y) == 0) continue;
        std::array<std::array<double, 5>, 5> ones{};
        std::array<std::array<double, 3>, 3> heights{};
        for (int q = std::max(0, y - kernel.radius); q <= std::min(height - 1, y + kernel.radius); ++q) {
          const auto& sums = rows[q].at[x];
          if (!(sums[0] > 0.0)) continue;
          const std::size_t k = q - y + kernel.radius;
          for (std::size_t i = 0; i < 5; ++i) {
            for (std::size_t j = 0; i + j < 5; ++j) ones[i][j] += sums[i] * kernel.weights[j][k];
          }
          for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; i + j < 3; ++j) heights[i][j] += sums[5 + i] * kernel.weights[j][k];
          }
        }
        out.at(x, y) = static_cast<float>(curvature_of(ones, heights, weight, width_mm));
      }
    }
  });
  return out;
}

std::optional<double> sample_field(const HeightField& field, const ImageF& values, const Vec3& point) {
  const Vec2 at = field.grid_position(point);
  const double x0 = std::floor(at.x()), y0 = std::floor(at.y());
  if (!(x0 >= -1.0 && y0 >= -1.0 && x0 < values.width() && y0 < values.height())) return std::nullopt;
  double sum = 0.0, weight = 0.0;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const int x = static_cast<int>(x0) + i, y = static_cast<int>(y0) + j;
      if (!values.contains(x, y) || field.seen.at(x, y) == 0) continue;
      const double w = std::max(1e-9, (1.0 - std::abs(at.x() - x)) * (1.0 - std::abs(at.y() - y)));
      sum += w * static_cast<double>(values.at(x, y));
      weight += w;
    }
  }
  if (!(weight > 0.0)) return std::nullopt;
  return sum / weight;
}

}  // namespace patinate
