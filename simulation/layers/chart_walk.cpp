#include "simulation/layers/chart_walk.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patinate::simulation {

namespace {

using Vec3f = Eigen::Vector3f;

/// Right-angled axes of a triangle's plane, the first along rows of texels, and how far they are from texel to texel.
struct ChartFrame {
  Vec3f along, beside;
  float row_mm, slant_mm, column_mm;  ///< A texel to the right; a texel down: along rows, and at right angles to them.
};

ChartFrame frame_of(const SurfaceAtlas& surface, int triangle) {
  const Eigen::Matrix<float, 3, 2>& steps = surface.mm_per_texel(triangle);
  ChartFrame f{};
  f.row_mm = steps.col(0).norm();
  f.along = steps.col(0) / f.row_mm;
  f.slant_mm = steps.col(1).dot(f.along);
  const Vec3f rest = steps.col(1) - f.slant_mm * f.along;
  f.column_mm = rest.norm();
  f.beside = rest / f.column_mm;
  return f;
}

/// Of the side that the triangle's corners go around, whichever way its chart is laid.
Vec3f normal_of(const SurfaceAtlas& surface, int triangle, const ChartFrame& frame) {
  const std::array<float, 6>& c = surface.corner_texels()[triangle];
  const float area = (c[2] - c[0]) * (c[5] - c[1]) - (c[3] - c[1]) * (c[4] - c[0]);
  const Vec3f normal = frame.along.cross(frame.beside);
  return area < 0.0F ? Vec3f(-normal) : normal;
}

/// Turned as the shortest turn takes one unit vector to the other.
Vec3f turned(const Vec3f& v, const Vec3f& from, const Vec3f& to) {
  constexpr float kFolded = 1e-3F;
  const float cosine = from.dot(to);
  if (1.0F + cosine < kFolded) return -v;
  const Vec3f axis = from.cross(to), side = axis.cross(v);
  return v + side + axis.cross(side) / (1.0F + cosine);
}

}  // namespace

ChartWalk::ChartWalk(const SurfaceAtlas& surface, TexelIndex texel, std::array<float, 2> place, SurfaceVector way)
    : surface_(&surface), texel_(texel), triangle_(surface.triangle(texel)), place_(place), way_(way) {
  find_step();
}

void ChartWalk::find_step() {
  const ChartFrame f = frame_of(*surface_, triangle_);
  const float y = way_[1] / f.column_mm, x = (way_[0] - f.slant_mm * y) / f.row_mm;
  step_mm_ = 1.0F / std::max(std::abs(x), std::abs(y));
  step_ = {x * step_mm_, y * step_mm_};
}

bool ChartWalk::is_in_chart(int x, int y) const {
  const TileGrid& grid = surface_->grid();
  if (x < 0 || y < 0 || x >= grid.width || y >= grid.height) return false;
  const TexelIndex t = grid.index(x, y);
  if (surface_->is_plain(TileGrid::tile_of(t)) && TileGrid::tile_of(t) == TileGrid::tile_of(texel_)) return true;
  return surface_->is_covered(t) && surface_->charts()[surface_->triangle(t)] == surface_->charts()[triangle_];
}

bool ChartWalk::advance() {
  const TileGrid& grid = surface_->grid();
  const int x = grid.x(texel_), y = grid.y(texel_);
  std::array<float, 2> to{place_[0] + step_[0], place_[1] + step_[1]};
  int new_x = static_cast<int>(std::floor(to[0])), new_y = static_cast<int>(std::floor(to[1]));
  beside_ = {kNoTexel, kNoTexel};
  if (!is_in_chart(new_x, new_y)) {
    const bool is_in_row = std::abs(step_[0]) >= std::abs(step_[1]);
    (is_in_row ? new_y : new_x) = is_in_row ? y : x;
    to[is_in_row ? 1 : 0] = place_[is_in_row ? 1 : 0];
    if (!is_in_chart(new_x, new_y)) return cross(is_in_row ? (step_[0] > 0.0F ? 0 : 1) : (step_[1] > 0.0F ? 2 : 3));
  }
  if (new_x != x && new_y != y) beside_ = {grid.index(new_x, y), grid.index(x, new_y)};
  place_ = to;
  texel_ = grid.index(new_x, new_y);
  const int triangle = surface_->triangle(texel_);
  if (triangle == triangle_) return true;
  triangle_ = triangle;
  find_step();
  return true;
}

bool ChartWalk::cross(std::size_t neighbor) {
  const TexelIndex to = surface_->neighbors(texel_)[neighbor];
  if (to == kNoTexel) return false;
  const int triangle = surface_->triangle(to);
  const ChartFrame from = frame_of(*surface_, triangle_), into = frame_of(*surface_, triangle);
  const Vec3f way = turned(way_[0] * from.along + way_[1] * from.beside, normal_of(*surface_, triangle_, from),
                           normal_of(*surface_, triangle, into));
  const Eigen::Vector2f way_there(way.dot(into.along), way.dot(into.beside));
  constexpr float kLeast = 0.1F;
  if (!(way_there.norm() > kLeast)) return false;
  way_ = {way_there.x() / way_there.norm(), way_there.y() / way_there.norm()};
  texel_ = to;
  triangle_ = triangle;
  constexpr float kMiddle = 0.5F;
  place_ = {static_cast<float>(surface_->grid().x(to)) + kMiddle, static_cast<float>(surface_->grid().y(to)) + kMiddle};
  find_step();
  return true;
}

}  // namespace patinate::simulation
