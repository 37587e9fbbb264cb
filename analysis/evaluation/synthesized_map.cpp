#include "analysis/evaluation/synthesized_map.h"

#include <array>
#include <cmath>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kChunk = 16384;

using Pairs = std::vector<TexelPair>;

/// The offset of one texel step in a triangle's frame.
Vec2 step_mm(const TexelMap& surface, const FlowFrames& frames, TexelId t, int dx, int dy) {
  const int triangle = surface.triangle(t);
  return frames[static_cast<std::size_t>(triangle)].transpose() * (surface.mm_per_texel(triangle) * Vec2(dx, dy));
}

/// The texel one step away in the atlas, in the same chart; -1 if there is none.
TexelId beside(const TexelMap& surface, TexelId t, int dx, int dy) {
  const auto x = static_cast<int>(t % surface.width()) + dx, y = static_cast<int>(t / surface.width()) + dy;
  if (x < 0 || y < 0 || x >= surface.width() || y >= surface.height()) return -1;
  const TexelId n = TexelId{y} * surface.width() + x;
  return surface.is_covered(n) && surface.chart(n) == surface.chart(t) ? n : -1;
}

}  // namespace

std::shared_ptr<const TexelMap> flat_surface(int width, int height, double texel_mm) {
  const double w = width * texel_mm, h = height * texel_mm;
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {w, 0, 0}, {w, h, 0}, {0, h, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.normals = {{0, 0, 1}};
  for (const auto& c : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
    mesh.triangles.push_back(c);
    mesh.uv_triangles.push_back(c);
    mesh.normal_triangles.push_back({0, 0, 0});
  }
  return std::make_shared<TexelMap>(std::move(mesh), width, height);
}

SourceIndices::SourceIndices(const SynthesizedMap& map, const SynthesisSource& source) : width_(source.width()) {
  const TexelMap& surface = *map.surface;
  if (map.coordinates.channels() != 2 || map.coordinates.width() != surface.width() ||
      map.coordinates.height() != surface.height()) {
    throw InvalidInput(map.name + ": the coordinate map is " +
                       size_text(map.coordinates.width(), map.coordinates.height()) + " with " +
                       std::to_string(map.coordinates.channels()) + " channels; expected " +
                       size_text(surface.width(), surface.height()) + " with 2");
  }
  index_.assign(static_cast<std::size_t>(surface.num_texels()), -1);
  for (TexelId t = 0; t < surface.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const float* s = map.coordinates.data() + 2 * t;
    const double x = std::floor(static_cast<double>(s[0]) + 0.5), y = std::floor(static_cast<double>(s[1]) + 0.5);
    if (!(x >= 0.0 && y >= 0.0 && x < source.width() && y < source.height())) {
      throw InvalidInput(map.name + ": texel " + std::to_string(t % surface.width()) + ", " +
                         std::to_string(t / surface.width()) + " comes from " + number_text(x) + ", " + number_text(y) +
                         ", which is not in the source of " + size_text(source.width(), source.height()));
    }
    index_[static_cast<std::size_t>(t)] = static_cast<std::int32_t>(y) * width_ + static_cast<std::int32_t>(x);
  }
}

std::optional<TexelPair> interior_pair(const TexelMap& surface, const FlowFrames& frames, TexelId t, int dx, int dy) {
  const TexelId n = beside(surface, t, dx, dy);
  if (n < 0) return std::nullopt;
  return TexelPair{t, n, step_mm(surface, frames, t, dx, dy)};
}

Pairs seam_pairs(const TexelMap& surface, const FlowFrames& frames, const RunControl& control) {
  const auto add = [&](TexelId t, Pairs& out) {
    for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
      if (beside(surface, t, dx, dy) >= 0) continue;
      const std::array<Vec2, 1> offset{step_mm(surface, frames, t, dx, dy)};
      std::array<TexelNeighbor, 1> n;
      surface.gather(t, frames, offset, n);
      if (n[0].texel < 0 || n[0].texel == t) continue;
      if (n[0].offset_mm.squaredNorm() > 0.0) out.push_back({t, n[0].texel, n[0].offset_mm});
    }
  };
  return parallel_reduce(
      surface.num_texels(), kChunk, control, Pairs{},
      [&](std::int64_t begin, std::int64_t end) {
        Pairs part;
        for (TexelId t = begin; t < end; ++t) {
          if (surface.is_covered(t)) add(t, part);
        }
        return part;
      },
      [](Pairs a, const Pairs& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      });
}

}  // namespace patinate::analysis
