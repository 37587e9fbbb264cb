#include "simulation/composition/height_frames.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::simulation::composition {

namespace {

constexpr double kMinSpread =
    0.05;  // texel steps, squared: what neighbors nearer together than that say of a slope is noise
constexpr std::int32_t kWeightOne = 4096;     ///< 1 in fixed point.
constexpr double kMaxBorderWeight = 1 << 27;  ///< Keeps weights times heights within 64 bits.

Vec3 texel_position(const SceneMesh& scene_mesh, const SurfaceAtlas& surface, TexelIndex t) {
  const auto triangle = static_cast<std::size_t>(surface.triangle(t));
  const Vec2& uv = scene_mesh.mesh.uvs[scene_mesh.mesh.uv_triangles[triangle][0]];
  const Vec3& corner = scene_mesh.mesh.positions[scene_mesh.mesh.triangles[triangle][0]];
  const TileGrid& grid = surface.grid();
  const Vec2 from_corner(grid.x(t) - (uv.x() * grid.width - 0.5), grid.y(t) - ((1.0 - uv.y()) * grid.height - 0.5));
  return corner + surface.mm_per_texel(static_cast<int>(triangle)).cast<double>() * from_corner;
}

/// Slope (1 = kSlopeOne) by a quantum of difference over two texels: rows T, B; columns right - left, below - above.
Eigen::Matrix2d slope_matrix(const TexelFrame& frame, double median_texel_mm) {
  if (frame.is_degenerate) return Eigen::Matrix2d::Zero();
  // Height = gradient . step, so gradient = step^-T (h_right, h_down); a quantum is median / kHeightQuanta.
  const Eigen::Matrix2d m = frame.step.inverse().transpose() * (0.5 * median_texel_mm * kSlopeOne / kHeightQuanta);
  return m.allFinite() ? m : Eigen::Matrix2d(Eigen::Matrix2d::Zero());
}

Frame quantized(const Eigen::Matrix2d& m) {
  const double largest = m.cwiseAbs().maxCoeff();
  if (!(largest > 0.0)) return {};
  const int shift = std::clamp(13 - static_cast<int>(std::floor(std::log2(largest))), 1, 30);
  const auto mantissa = [&](double value) {
    return static_cast<std::int16_t>(std::clamp<double>(std::round(std::ldexp(value, shift)), -16383, 16383));
  };
  return {.t = mantissa(m(0, 0)),
          .bt = mantissa(m(1, 0)),
          .b = mantissa(-m(1, 1)),
          .shift = static_cast<std::int16_t>(shift)};
}

BorderTexel border_texel(const SceneMesh& scene_mesh, const SurfaceAtlas& surface, TexelIndex t) {
  BorderTexel result{.texel = t, .neighbor = surface.neighbors(t)};
  const TexelFrame frame = texel_frame(surface.mm_per_texel(surface.triangle(t)).cast<double>());
  const Eigen::Matrix2d slope = 2.0 * slope_matrix(frame, surface.median_texel_size_mm());
  const Eigen::Matrix<double, 2, 4> weights = slope * gradient_weights(neighbor_steps(scene_mesh, surface, t));
  for (std::size_t k = 0; k < 4; ++k) {
    if (result.neighbor[k] == kNoTexel) result.neighbor[k] = t;
    const auto rounded = [&](int row) {
      return static_cast<std::int32_t>(
          std::lround(std::clamp(weights(row, static_cast<int>(k)) * kWeightOne, -kMaxBorderWeight, kMaxBorderWeight)));
    };
    result.along_t[k] = rounded(0);
    result.along_b[k] = rounded(1);
  }
  return result;
}

}  // namespace

TexelFrame texel_frame(const Eigen::Matrix<double, 3, 2>& mm_per_texel) {
  TexelFrame frame;
  const Vec3 right = mm_per_texel.col(0), down = mm_per_texel.col(1);
  const double length = right.norm();
  if (!(length > 0.0) || !mm_per_texel.allFinite()) return frame;
  frame.t = right / length;
  const Vec3 across = frame.t * down.dot(frame.t) - down;  // up, without what lies along T
  const double height = across.norm();
  if (!(height > 1e-9 * down.norm())) return frame;
  frame.b = across / height;
  frame.step << length, down.dot(frame.t), 0.0, -height;
  frame.is_degenerate = false;
  return frame;
}

std::array<Vec2, 4> neighbor_steps(const SceneMesh& scene_mesh, const SurfaceAtlas& surface, TexelIndex t) {
  std::array<Vec2, 4> steps;
  steps.fill(Vec2::Zero());
  const TexelFrame frame = texel_frame(surface.mm_per_texel(surface.triangle(t)).cast<double>());
  if (frame.is_degenerate) return steps;
  const Vec3 here = texel_position(scene_mesh, surface, t);
  const Eigen::Matrix2d from_mm = frame.step.inverse();
  const std::array<TexelIndex, 4> around = surface.neighbors(t);
  for (std::size_t k = 0; k < 4; ++k) {
    if (around[k] == kNoTexel) continue;
    const Vec3 way = texel_position(scene_mesh, surface, around[k]) - here;
    const Vec2 flat(way.dot(frame.t), way.dot(frame.b));
    if (const double length = flat.norm(); length > 1e-3 * way.norm())
      steps[k] = from_mm * (flat * (way.norm() / length));
  }
  return steps;
}

Eigen::Matrix<double, 2, 4> gradient_weights(const std::array<Vec2, 4>& steps) {
  Eigen::Matrix<double, 2, 4> d;
  for (std::size_t k = 0; k < 4; ++k) d.col(static_cast<int>(k)) = steps[k].allFinite() ? steps[k] : Vec2(0, 0);
  const SymmetricEigen<Eigen::Matrix2d> spread = symmetric_eigen(Eigen::Matrix2d(d * d.transpose()));
  Eigen::Matrix<double, 2, 4> weights = Eigen::Matrix<double, 2, 4>::Zero();
  for (int i = 0; i < 2; ++i) {
    const Vec2 axis = spread.vectors.col(i);
    if (spread.values[i] > kMinSpread) weights += axis * (axis.transpose() * d) / spread.values[i];
  }
  return weights;
}

std::array<TileIndex, 4> tiles_beside(const TileGrid& grid, TileIndex tile) {
  constexpr TileIndex kPage = TileGrid::kPageTiles;
  const auto pages_x = static_cast<TileIndex>(grid.pages_x());
  const TileIndex x = tile & 7, y = tile >> 3 & 7, page = tile / kPage;
  std::array<TileIndex, 4> beside{tile + 1, tile - 1, tile + 8, tile - 8};
  if (x == 7) beside[0] = (page + 1) % pages_x == 0 ? tile : tile + kPage - 7;
  if (x == 0) beside[1] = page % pages_x == 0 ? tile : tile - kPage + 7;
  if (y == 7) beside[2] = page + pages_x >= grid.num_pages() ? tile : tile + pages_x * kPage - 56;
  if (y == 0) beside[3] = page < pages_x ? tile : tile - pages_x * kPage + 56;
  return beside;
}

HeightFrames::HeightFrames(const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const RunControl& control)
    : frames_(static_cast<std::size_t>(surface.num_triangles()) + 1) {
  parallel_for(surface.num_triangles(), 8192, control.part(0.0, 0.3), [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const TexelFrame frame = texel_frame(surface.mm_per_texel(static_cast<int>(i)).cast<double>());
      frames_[static_cast<std::size_t>(i) + 1] = quantized(slope_matrix(frame, surface.median_texel_size_mm()));
    }
  });
  const std::span<const TexelIndex> border = surface.border();
  border_.resize(border.size());
  parallel_for(static_cast<std::int64_t>(border.size()), 4096, control.part(0.3, 1.0),
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
                   border_[i] = border_texel(scene_mesh, surface, border[i]);
               });
  const std::size_t num_tiles = surface.grid().num_tiles();
  border_begin_.assign(num_tiles + 1, 0);
  std::vector<std::pair<TileIndex, TileIndex>> uses;  // tile whose heights are used, tile that uses them
  for (const BorderTexel& texel : border_) {
    const TileIndex tile = TileGrid::tile_of(texel.texel);
    ++border_begin_[tile + 1];
    const std::array<TileIndex, 4> beside = tiles_beside(surface.grid(), tile);
    for (const TexelIndex n : texel.neighbor) {
      const TileIndex other = TileGrid::tile_of(n);
      if (other != tile && std::find(beside.begin(), beside.end(), other) == beside.end())
        uses.emplace_back(other, tile);
    }
  }
  for (std::size_t i = 0; i < num_tiles; ++i) border_begin_[i + 1] += border_begin_[i];
  std::sort(uses.begin(), uses.end());
  uses.erase(std::unique(uses.begin(), uses.end()), uses.end());
  dependents_begin_.assign(num_tiles + 1, 0);
  for (const auto& [used, user] : uses) {
    ++dependents_begin_[used + 1];
    dependents_.push_back(user);
  }
  for (std::size_t i = 0; i < num_tiles; ++i) dependents_begin_[i + 1] += dependents_begin_[i];
}

std::span<const BorderTexel> HeightFrames::border(TileIndex tile) const {
  return std::span(border_).subspan(border_begin_[tile], border_begin_[tile + 1] - border_begin_[tile]);
}

std::span<const TileIndex> HeightFrames::dependents(TileIndex tile) const {
  return std::span(dependents_).subspan(dependents_begin_[tile], dependents_begin_[tile + 1] - dependents_begin_[tile]);
}

std::size_t HeightFrames::memory() const {
  return frames_.size() * sizeof(Frame) + border_.size() * sizeof(BorderTexel) +
         (border_begin_.size() + dependents_begin_.size() + dependents_.size()) * 4;
}

}  // namespace patinate::simulation::composition
