#include "patinate/atlas/texel_map.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "libcommon/atlas/raster.h"
#include "libcommon/core/text.h"

namespace patinate {

namespace {

constexpr int kMaxCrossings = 10'000;
constexpr int kLargestStep = 32767;  ///< Texels; its square, doubled, is an int. What lies farther is walked to.
constexpr double kUvSlack = 0.01;    ///< Charts that lean over the atlas's edge lose that strip.

void check_uvs(const Mesh& mesh) {
  if (!mesh.has_uvs())
    throw InvalidInput("the mesh has no UVs; unwrap it in a modeling program, or export it with UVs");
  for (const Triangle& corners : mesh.uv_triangles) {
    for (int corner : corners) {
      const Vec2& uv = mesh.uvs[corner];
      if (uv.minCoeff() >= -kUvSlack && uv.maxCoeff() <= 1.0 + kUvSlack) continue;
      throw InvalidInput("the mesh has UVs outside [0, 1] (" + number_text(uv.x()) + ", " + number_text(uv.y()) +
                         "); lay them out in one square first");
    }
  }
}

/// Triangles joined where both ends of a shared edge have equal UVs.
std::vector<int> label_charts(const Mesh& mesh, const std::vector<std::array<int, 3>>& neighbors) {
  const auto uv_at = [&](int triangle, int position) -> const Vec2& {
    const auto t = static_cast<std::size_t>(triangle);
    std::size_t corner = 0;
    while (mesh.triangles[t][corner] != position && corner < 2) ++corner;
    return mesh.uvs[mesh.uv_triangles[t][corner]];
  };
  std::vector<int> chart(mesh.triangles.size(), -1);
  std::vector<int> open;
  int num_charts = 0;
  for (int seed = 0; seed < mesh.num_triangles(); ++seed) {
    if (chart[seed] >= 0) continue;
    chart[seed] = num_charts;
    open.assign(1, seed);
    while (!open.empty()) {
      const int t = open.back();
      open.pop_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const int n = neighbors[t][k];
        if (n < 0 || chart[n] >= 0) continue;
        const int a = mesh.triangles[t][k];
        const int b = mesh.triangles[t][(k + 1) % 3];
        if (uv_at(t, a) != uv_at(n, a) || uv_at(t, b) != uv_at(n, b)) continue;
        chart[n] = num_charts;
        open.push_back(n);
      }
    }
    ++num_charts;
  }
  return chart;
}

Sheet checked(Sheet sheet) {
  const int width = sheet.width(), height = sheet.height();
  if (width >= 1 && height >= 1 && width <= Sheet::kMaxSide && height <= Sheet::kMaxSide) return sheet;
  throw InvalidInput("atlas size " + std::to_string(width) + " x " + std::to_string(height) +
                     " is out of range; use [1, 65536]");
}

}  // namespace

TexelMap::Surface::Surface(Mesh with_uvs) : mesh(std::move(with_uvs)) {
  check_uvs(mesh);
  neighbors = triangle_neighbors(mesh);
  chart = label_charts(mesh, neighbors);
}

TexelMap::TexelMap(Mesh mesh, int width, int height, const RunControl& control)
    : TexelMap(std::move(mesh), Sheet{.tile_width = width, .tile_height = height, .columns = 1, .names = {""}},
               control) {}

TexelMap::TexelMap(Mesh mesh, Sheet sheet, const RunControl& control)
    : TexelMap(std::make_shared<const Surface>(std::move(mesh)), checked(std::move(sheet)), control) {}

TexelMap TexelMap::halved(const RunControl& control) const {
  return {surface_, checked({.tile_width = width_ / 2, .tile_height = height_ / 2, .columns = 1, .names = {""}}),
          control};
}

TexelMap::TexelMap(std::shared_ptr<const Surface> surface, Sheet sheet, const RunControl& control)
    : surface_(std::move(surface)),
      sheet_(std::move(sheet)),
      width_(sheet_.width()),
      height_(sheet_.height()),
      triangles_(static_cast<std::size_t>(num_texels()), -1) {
  find_triangles(control);
}

std::array<Vec2, 3> TexelMap::corners_in_texels(int triangle) const {
  std::array<Vec2, 3> p;
  for (std::size_t k = 0; k < 3; ++k) {
    const int corner = mesh().uv_triangles[triangle][k];
    p[k] = texel_from_uv(mesh().uvs[corner], width_, height_);
  }
  return p;
}

int TexelMap::chart(TexelId t) const {
  const int own = triangle(t);
  return own < 0 ? -1 : surface_->chart[own];
}

namespace {

/// Not inlined: of two numbers side by side, which become a vector, g++ 12 leaves the rounding out.
[[gnu::noinline]] double in_single_precision(double v) { return static_cast<double>(static_cast<float>(v)); }

}  // namespace

SurfacePoint TexelMap::point(TexelId t) const {
  const int own = triangle(t);
  if (own < 0) return {};
  const std::array<Vec2, 3> p = corners_in_texels(own);
  const TexelId column = t % width_, row = t / width_;
  const auto [b1, b2] =
      weights_at(p, cross2(p[1] - p[0], p[2] - p[0]), Vec2(static_cast<double>(column), static_cast<double>(row)));
  return {own, in_single_precision(b1), in_single_precision(b2)};
}

namespace {

/// Sum of three corner values weighted by a surface point's barycentrics.
template <class Values>
auto interpolate(const Values& values, const Triangle& corners, const SurfacePoint& p) -> typename Values::value_type {
  return (1.0 - p.b1 - p.b2) * values[corners[0]] + p.b1 * values[corners[1]] + p.b2 * values[corners[2]];
}

}  // namespace

Vec3 TexelMap::position_mm(TexelId t) const {
  const SurfacePoint p = point(t);
  return interpolate(mesh().positions, mesh().triangles[p.triangle], p);
}

Vec3 TexelMap::normal(TexelId t) const {
  const SurfacePoint p = point(t);
  Vec3 n = area_vector(mesh(), p.triangle);
  if (!mesh().normal_triangles.empty()) {
    const Vec3 shading = interpolate(mesh().normals, mesh().normal_triangles[p.triangle], p);
    if (shading.norm() > 1e-12) n = shading;
  }
  const double length = n.norm();
  return length > 0.0 ? Vec3(n / length) : Vec3(0.0, 0.0, 1.0);
}

Eigen::Matrix<double, 3, 2> TexelMap::mm_per_texel(int triangle) const {
  const Triangle& c = mesh().triangles[triangle];
  const Triangle& u = mesh().uv_triangles[triangle];
  const auto texel = [&](std::size_t k) { return texel_from_uv(mesh().uvs[u[k]], width_, height_); };
  const auto position = [&](std::size_t k) -> const Vec3& { return mesh().positions[c[k]]; };
  const Vec2 d1 = texel(1) - texel(0), d2 = texel(2) - texel(0);
  const Vec3 e1 = position(1) - position(0), e2 = position(2) - position(0);
  const double det = cross2(d1, d2);
  Eigen::Matrix<double, 3, 2> j = Eigen::Matrix<double, 3, 2>::Zero();
  if (det != 0.0) {
    j.col(0) = (e1 * d2.y() - e2 * d1.y()) / det;
    j.col(1) = (e2 * d1.x() - e1 * d2.x()) / det;
  }
  return j;
}

FlowFrame TexelMap::tangents(int triangle) const {
  const Eigen::Matrix<double, 3, 2> j = mm_per_texel(triangle);
  FlowFrame frame = FlowFrame::Zero();
  if (!(j.col(0).norm() > 0.0)) return frame;
  frame.col(0) = j.col(0).normalized();
  const Vec3 rest = j.col(1) - frame.col(0) * frame.col(0).dot(j.col(1));
  if (rest.norm() > 0.0) frame.col(1) = rest.normalized();
  return frame;
}

Eigen::Matrix2d TexelMap::texels_per_mm(int triangle, const FlowFrame& frame) const {
  const Eigen::Matrix2d m = frame.transpose() * mm_per_texel(triangle);
  const double det = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  if (!(std::abs(det) > 1e-300)) return Eigen::Matrix2d::Zero();
  Eigen::Matrix2d inverse;
  inverse << m(1, 1) / det, -m(0, 1) / det, -m(1, 0) / det, m(0, 0) / det;
  return inverse;
}

ImageU8 TexelMap::coverage() const {
  ImageU8 image(width_, height_);
  for (TexelId t = 0; t < num_texels(); ++t) image.data()[t] = static_cast<std::uint8_t>(is_covered(t) ? 255 : 0);
  return image;
}

SurfacePoint TexelMap::walk(SurfacePoint from, Vec3 step_mm) const {
  constexpr SurfacePoint kNowhere{};
  for (int crossing = 0; crossing < kMaxCrossings; ++crossing) {
    const auto t = static_cast<std::size_t>(from.triangle);
    const Triangle& corners = mesh().triangles[t];
    const auto position = [&](std::size_t k) -> const Vec3& { return mesh().positions[corners[k % 3]]; };
    const Vec3 e1 = position(1) - position(0), e2 = position(2) - position(0);
    const double g11 = e1.dot(e1), g12 = e1.dot(e2), g22 = e2.dot(e2), det = g11 * g22 - g12 * g12;
    if (!(det > 1e-24 * g11 * g22)) return from;  // No area: nowhere to go.
    const double s1 = e1.dot(step_mm), s2 = e2.dot(step_mm);
    const double d1 = (g22 * s1 - g12 * s2) / det, d2 = (g11 * s2 - g12 * s1) / det;
    const std::array<double, 3> weight{1.0 - from.b1 - from.b2, from.b1, from.b2};
    const std::array<double, 3> slope{-d1 - d2, d1, d2};
    double fraction = 1.0;
    std::size_t left = 3;  // The corner whose weight runs out first: we leave over the edge opposite to it.
    for (std::size_t k = 0; k < 3; ++k) {
      if (slope[k] < 0.0 && std::max(0.0, weight[k]) < -slope[k] * fraction) {
        fraction = std::max(0.0, weight[k]) / -slope[k];
        left = k;
      }
    }
    if (left == 3) return {from.triangle, from.b1 + d1, from.b2 + d2};
    const std::size_t edge = (left + 1) % 3;
    const int next = surface_->neighbors[t][edge];
    if (next < 0) return kNowhere;
    // Unfold the next triangle into this one's plane: keep the part along the edge, turn the part across it.
    const Vec3 along = (position(edge + 1) - position(edge)).normalized();
    Vec3 outward = position(edge) - position(left);
    outward = (outward - along * along.dot(outward)).normalized();
    const Triangle& next_corners = mesh().triangles[next];
    std::array<double, 3> next_weight{0.0, 0.0, 0.0};
    Vec3 inward = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](std::size_t c) { return weight[c % 3] + fraction * slope[c % 3]; };
      if (next_corners[k] == corners[edge]) {
        next_weight[k] = std::max(0.0, at(edge));
      } else if (next_corners[k] == corners[(edge + 1) % 3]) {
        next_weight[k] = std::max(0.0, at(edge + 1));
      } else {
        inward = mesh().positions[next_corners[k]] - position(edge);
      }
    }
    inward -= along * along.dot(inward);
    const double total = next_weight[0] + next_weight[1] + next_weight[2];
    if (!(inward.norm() > 0.0) || !(total > 0.0)) return kNowhere;
    step_mm = (1.0 - fraction) * (along * along.dot(step_mm) + inward.normalized() * outward.dot(step_mm));
    from = {next, next_weight[1] / total, next_weight[2] / total};
  }
  return kNowhere;
}

TexelId TexelMap::texel_of(const SurfacePoint& p) const {
  if (p.triangle < 0) return -1;
  const Vec2 uv = interpolate(mesh().uvs, mesh().uv_triangles[p.triangle], p);
  const Vec2 texel = texel_from_uv(uv, width_, height_);
  const int x = static_cast<int>(std::floor(texel.x() + 0.5)), y = static_cast<int>(std::floor(texel.y() + 0.5));
  const int wanted_chart = surface_->chart[p.triangle];
  TexelId best = -1;
  double best_distance = 1e30;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int qx = x + dx, qy = y + dy;
      if (qx < 0 || qy < 0 || qx >= width_ || qy >= height_) continue;
      const TexelId q = TexelId{qy} * width_ + qx;
      if (chart(q) != wanted_chart) continue;
      const double distance = (Vec2(qx, qy) - texel).squaredNorm();
      if (distance < best_distance) {
        best_distance = distance;
        best = q;
      }
    }
  }
  return best;
}

namespace {

struct TexelStep {
  int x = 0, y = 0;
};

/// To the nearest texel; nothing for a sliver's, where there is no grid to go by.
std::optional<TexelStep> whole_step(const Vec2& step, int largest) {
  if (!(step.cwiseAbs().maxCoeff() < largest)) return std::nullopt;
  return TexelStep{static_cast<int>(std::floor(step.x() + 0.5)), static_cast<int>(std::floor(step.y() + 0.5))};
}

}  // namespace

TexelId TexelMap::inside_chart(TexelId from, int dx, int dy) const {
  const int own_chart = chart(from), x = static_cast<int>(from % width_), y = static_cast<int>(from / width_);
  const auto is_own = [&](int qx, int qy) {
    return qx >= 0 && qy >= 0 && qx < width_ && qy < height_ && chart(TexelId{qy} * width_ + qx) == own_chart;
  };
  // A step's parts are as many texels to the left as they would be to the right: division cuts toward 0 on both sides.
  const int num_steps = std::max(std::abs(dx), std::abs(dy));
  const auto near = [&](int d, int i) { return (2 * d * i + (d < 0 ? -num_steps : num_steps)) / (2 * num_steps); };
  for (int i = 1; i <= num_steps; ++i) {
    if (!is_own(x + near(dx, i), y + near(dy, i)) && !is_own(x + dx * i / num_steps, y + dy * i / num_steps)) return -1;
  }
  return is_own(x + dx, y + dy) ? from + TexelId{dy} * width_ + dx : -1;
}

void TexelMap::gather(TexelId t, const FlowFrames& frames, std::span<const Vec2> offsets_mm,
                      std::span<TexelNeighbor> out) const {
  const SurfacePoint p = point(t);
  const FlowFrame& frame = frames[p.triangle];
  const Eigen::Matrix2d to_texels = texels_per_mm(p.triangle, frame),
                        to_mm = frame.transpose() * mm_per_texel(p.triangle);
  for (std::size_t k = 0; k < offsets_mm.size(); ++k) {
    const std::optional<TexelStep> step =
        whole_step(to_texels * offsets_mm[k], std::min(kLargestStep, std::max(width_, height_)));
    const TexelId inside = step ? inside_chart(t, step->x, step->y) : -1;
    if (inside >= 0) {
      out[k] = {inside, to_mm * Vec2(step->x, step->y)};
      continue;
    }
    const SurfacePoint end = walk(p, frame * offsets_mm[k]);
    out[k] = {texel_of(end), offsets_mm[k]};
    if (out[k].texel < 0) continue;
    // Remainder that texel_of() rounds away, in the texels over there.
    const Vec2 at = texel_from_uv(interpolate(mesh().uvs, mesh().uv_triangles[end.triangle], end), width_, height_);
    const TexelId column = out[k].texel % width_, row = out[k].texel / width_;
    const Vec2 rest = Vec2(static_cast<double>(column), static_cast<double>(row)) - at;
    out[k].offset_mm += frames[end.triangle].transpose() * (mm_per_texel(end.triangle) * rest);
  }
}

}  // namespace patinate
