#include "simulation/transport/met_texels.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "libcommon/core/parallel.h"
#include "simulation/transport/exchange.h"
#include "simulation/transport/splat.h"

namespace patinate::simulation {

namespace {

/// Whether a middle lies in the tiles that a stencil of a texel touches.
bool is_any_near(const MetTexels& met, const TileGrid& grid, int x, int y, int reach) {
  constexpr int kSide = TileGrid::kTileSide;
  const int left = std::max(0, x - reach) / kSide, right = std::min(grid.width - 1, x + reach) / kSide,
            top = std::max(0, y - reach) / kSide, bottom = std::min(grid.height - 1, y + reach) / kSide;
  for (int ty = top; ty <= bottom; ++ty) {
    for (int tx = left; tx <= right; ++tx) {
      if (met.tiles()[TileGrid::tile_of(grid.index(tx * kSide, ty * kSide))] != 0) return true;
    }
  }
  return false;
}

/// Whether the splat in the middle of this texel reaches a texel that was met.
bool is_reached(const MetTexels& met, const SplatShape& shape, const TileGrid& grid, TexelIndex texel,
                std::vector<SplatPart>& parts) {
  if (met.has(texel)) return true;
  const int size = shape.size_at(texel);
  if (size == 0) return false;
  const SplatStencil& stencil = SplatShape::stencil_of(size);
  const int x = grid.x(texel), y = grid.y(texel);
  if (!shape.is_plain(x, y, stencil.reach)) {
    parts.clear();
    shape.append(texel, parts);
    return std::any_of(parts.begin(), parts.end(), [&](const SplatPart& part) { return met.has(part.texel); });
  }
  return is_any_near(met, grid, x, y, stencil.reach) &&
         std::any_of(stencil.parts.begin(), stencil.parts.end(),
                     [&](const SplatStencil::Part& part) { return met.has(grid.index(x + part.x, y + part.y)); });
}

}  // namespace

ImageU8 reached_texels(const MetTexels& met, const ExchangeOptions& options, const SurfaceAtlas& surface,
                       const RunControl& control) {
  constexpr std::int64_t kRows = 16;
  const TileGrid& grid = surface.grid();
  const std::optional<SplatShape> shape = splat_shape(options, surface);
  ImageU8 reached(grid.width, grid.height, 1);
  parallel_for(grid.height, kRows, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<SplatPart> parts;
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const TexelIndex texel = grid.index(x, y);
        if (!surface.is_covered(texel)) continue;
        const bool is = shape ? is_reached(met, *shape, grid, texel, parts) : met.has(texel);
        reached.at(x, y) = is ? 255 : 0;
      }
    }
  });
  return reached;
}

}  // namespace patinate::simulation
