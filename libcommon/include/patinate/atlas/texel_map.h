/// \file
/// Which surface point each texel of a UV atlas shows, how large it is, and what lies around it on the surface.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "patinate/atlas/sheet.h"
#include "patinate/core/run_control.h"
#include "patinate/core/zeroed_vector.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate {

using TexelId = std::int64_t;  ///< y * width + x; -1 = none.

/// Orthonormal axes in a triangle's plane, mm: which way "right" and "down" are for what lies there. Zero for a
/// triangle without UVs' area.
using FlowFrame = Eigen::Matrix<double, 3, 2>;
using FlowFrames = std::vector<FlowFrame>;  ///< One a triangle of a mesh.

/// A texel near another one.
struct TexelNeighbor {
  TexelId texel = -1;
  Vec2 offset_mm{0.0, 0.0};  ///< Position of its center relative to the other texel, in the other's frame.
};

/// A point on a mesh.
struct SurfacePoint {
  int triangle = -1;
  double b1 = 0.0;  ///< Barycentric weights of corners 1 and 2.
  double b2 = 0.0;
};

/// A rectangle of texels: [x0, x1) x [y0, y1).
struct TexelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  [[nodiscard]] bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  [[nodiscard]] int width() const { return x1 - x0; }
  [[nodiscard]] int height() const { return y1 - y0; }
  [[nodiscard]] std::int64_t num_texels() const { return std::int64_t{width()} * height(); }
  friend bool operator==(const TexelRect&, const TexelRect&) = default;
};

/// Texel -> surface. A texel is covered when its center lies in a triangle's UVs; where UVs overlap, the lowest
/// triangle wins. Stores 4 bytes per texel; points, positions, frames and neighbors are computed. Thread-safe.
class TexelMap {
 public:
  /// @param mesh  With UVs in [0, 1], in mm. Kept by copy.
  /// @throws InvalidInput if the mesh has no UVs, they leave [0, 1] by more than 1 %, or a size is outside [1, 65536].
  TexelMap(Mesh mesh, int width, int height, const RunControl& control = {});
  /// Over the tiles of a sheet. @param mesh  As sheet_mesh() gives it: UVs over the whole sheet.
  TexelMap(Mesh mesh, Sheet sheet, const RunControl& control = {});
  /// Half as many texels in both directions, rounded down, in one square. The mesh is shared. @throws InvalidInput if
  /// nothing is left.
  [[nodiscard]] TexelMap halved(const RunControl& control = {}) const;
  /// The whole of it.
  [[nodiscard]] TexelRect rect() const { return {0, 0, width_, height_}; }
  /// How many texels each triangle has.
  [[nodiscard]] std::vector<std::int64_t> count_texels() const;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Where the tiles lie; one tile over everything unless a sheet was given.
  [[nodiscard]] const Sheet& sheet() const { return sheet_; }
  [[nodiscard]] std::int64_t num_texels() const { return std::int64_t{width_} * height_; }
  [[nodiscard]] std::int64_t num_covered() const { return num_covered_; }
  /// Texels that a second triangle wanted too.
  [[nodiscard]] std::int64_t num_overlapping() const { return num_overlapping_; }
  [[nodiscard]] const Mesh& mesh() const { return surface_->mesh; }

  [[nodiscard]] bool is_covered(TexelId t) const { return triangle(t) >= 0; }
  /// UV-connected piece of the atlas, from 0; -1 outside.
  [[nodiscard]] int chart(TexelId t) const;
  /// Its center, the weights in single precision; triangle -1 outside.
  [[nodiscard]] SurfacePoint point(TexelId t) const;
  [[nodiscard]] int triangle(TexelId t) const { return triangles_[t]; }
  /// Triangle of every texel, in order; -1 outside the charts.
  [[nodiscard]] const std::vector<std::int32_t>& triangles() const { return triangles_; }
  [[nodiscard]] Vec3 position_mm(TexelId t) const;
  /// Interpolated shading normal, unit.
  [[nodiscard]] Vec3 normal(TexelId t) const;
  /// Columns: surface vectors (mm) of one texel step to the right and one down, constant in a triangle.
  [[nodiscard]] Eigen::Matrix<double, 3, 2> mm_per_texel(int triangle) const;
  /// Orthonormal tangents of a triangle: first along texel x, second as near texel y as orthogonality allows.
  [[nodiscard]] FlowFrame tangents(int triangle) const;
  /// Texel steps per mm in a frame: the inverse of frame^T mm_per_texel. Zero where there is none.
  [[nodiscard]] Eigen::Matrix2d texels_per_mm(int triangle, const FlowFrame& frame) const;
  /// Median over covered texels of sqrt(area of one texel), mm.
  [[nodiscard]] double median_texel_size_mm() const { return median_texel_size_mm_; }
  /// Share of the surface whose texels are larger than `size_mm`, [0, 1].
  [[nodiscard]] double share_of_larger_texels(double size_mm) const;
  /// Half of the surface has texels of at most this size. It differs from the median over texels where some parts of
  /// the surface have many more texels than others. 0 where no triangle has texels.
  [[nodiscard]] double median_texel_size_by_area_mm() const;
  /// 0 / 255.
  [[nodiscard]] ImageU8 coverage() const;

  /// Texels that lie at `offsets_mm` (in the frame of the texel's triangle) from texel `t`, walking straight over the
  /// surface and across seams; texel -1 where the surface ends. With where they really lie: texels are a grid, offsets
  /// are not. Over seams that is known as well as the frames on both sides agree.
  /// @param frames  One a triangle: uv_frames(), or a direction field. @param out  As long as offsets_mm.
  void gather(TexelId t, const FlowFrames& frames, std::span<const Vec2> offsets_mm,
              std::span<TexelNeighbor> out) const;
  /// The straight walk itself: from a surface point along a 3D vector in its triangle's plane. triangle = -1 where the
  /// surface ends.
  [[nodiscard]] SurfacePoint walk(SurfacePoint from, Vec3 step_mm) const;
  /// Texel that shows a surface point, or the nearest covered one of its chart next to it; -1 if there is none.
  [[nodiscard]] TexelId texel_of(const SurfacePoint& p) const;

 private:
  /// The texel (dx, dy) away if the chart's own grid leads there; -1 otherwise.
  [[nodiscard]] TexelId inside_chart(TexelId from, int dx, int dy) const;
  [[nodiscard]] std::array<Vec2, 3> corners_in_texels(int triangle) const;

  /// Data that does not depend on the number of texels.
  struct Surface {
    Mesh mesh;
    std::vector<std::array<int, 3>> neighbors;
    std::vector<int> chart;  ///< Of each triangle.
    explicit Surface(Mesh with_uvs);
  };
  TexelMap(std::shared_ptr<const Surface> surface, Sheet sheet, const RunControl& control);

  void find_triangles(const RunControl& control);
  [[nodiscard]] std::vector<float> texel_sizes() const;

  std::shared_ptr<const Surface> surface_;
  Sheet sheet_;
  int width_;
  int height_;
  std::vector<std::int32_t> triangles_;
  std::int64_t num_covered_ = 0;
  std::int64_t num_overlapping_ = 0;
  double median_texel_size_mm_ = 0.0;
};

}  // namespace patinate
