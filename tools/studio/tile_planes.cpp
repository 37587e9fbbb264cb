#include "tools/studio/tile_planes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "libcommon/core/parallel.h"
#include "patinate/atlas/dilate.h"

namespace patinate::studio {

namespace {

constexpr std::uint32_t kWhole = 0xFFFFFFFFu;

/// For every texel the nearest covered one, as dilate() finds it: it copies all channels of a texel, here the number of
/// one.
ImageU8 nearest_covered(const simulation::SurfaceAtlas& surface) {
  const simulation::TileGrid& grid = surface.grid();
  ImageU8 index(grid.width, grid.height, 4), coverage(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const simulation::TexelIndex t = grid.index(x, y);
      if (!surface.is_covered(t)) continue;
      coverage.at(x, y) = 255;
      std::memcpy(&index.at(x, y), &t, sizeof(t));
    }
  }
  dilate(index, coverage, -1);
  return index;
}

}  // namespace

ScreenLayout::ScreenLayout(const simulation::SurfaceAtlas& surface)
    : grid_(surface.grid()), width_(surface.grid().width), height_(surface.grid().height) {
  const ImageU8 nearest = nearest_covered(surface);
  std::vector<std::pair<simulation::TileIndex, ScreenTile>> shown;
  first_source_.assign(num_tiles(), kWhole);
  for (ScreenTile tile = 0; tile < num_tiles(); ++tile) {
    std::array<simulation::TexelIndex, 64> sources{};
    const int x0 = static_cast<int>(tile) % columns() * 8, y0 = static_cast<int>(tile) / columns() * 8;
    bool is_whole = true;
    for (int i = 0; i < 64; ++i) {
      const int x = x0 + i % 8, y = y0 + i / 8;
      simulation::TexelIndex& source = sources[i];
      source = simulation::kNoTexel;
      if (x < width_ && y < height_) std::memcpy(&source, nearest.pixel(x, y).data(), sizeof(source));
      is_whole = is_whole && source == grid_.index(x, y);
      const simulation::TileIndex from = simulation::TileGrid::tile_of(source);
      if (source != simulation::kNoTexel && from != simulation::TileGrid::tile_of(grid_.index(x0, y0)) &&
          (shown.empty() || shown.back() != std::pair(from, tile)))
        shown.emplace_back(from, tile);
    }
    if (is_whole) continue;
    first_source_[tile] = static_cast<std::uint32_t>(sources_.size());
    sources_.insert(sources_.end(), sources.begin(), sources.end());
  }
  std::sort(shown.begin(), shown.end());
  shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
  gutter_begin_.assign(grid_.num_tiles() + 1, 0);
  for (const auto& [from, tile] : shown) {
    ++gutter_begin_[from + 1];
    gutter_tiles_.push_back(tile);
  }
  for (std::size_t i = 1; i < gutter_begin_.size(); ++i) gutter_begin_[i] += gutter_begin_[i - 1];
}

std::array<simulation::TexelIndex, 64> ScreenLayout::sources(ScreenTile tile) const {
  std::array<simulation::TexelIndex, 64> out{};
  if (first_source_[tile] != kWhole) {
    std::copy_n(sources_.begin() + first_source_[tile], 64, out.begin());
    return out;
  }
  const simulation::TexelIndex first =
      grid_.index(static_cast<int>(tile) % columns() * 8, static_cast<int>(tile) / columns() * 8);
  for (simulation::TexelIndex i = 0; i < 64; ++i) out[i] = first + i;
  return out;
}

std::vector<ScreenTile> ScreenLayout::showing(std::span<const simulation::TileIndex> changed) const {
  std::vector<ScreenTile> tiles;
  for (const simulation::TileIndex t : changed) {
    const int x = grid_.x(t * simulation::TileGrid::kTileTexels), y = grid_.y(t * simulation::TileGrid::kTileTexels);
    if (x < width_ && y < height_) tiles.push_back(tile_at(x, y));
    tiles.insert(tiles.end(), gutter_tiles_.begin() + gutter_begin_[t], gutter_tiles_.begin() + gutter_begin_[t + 1]);
  }
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  return tiles;
}

std::size_t ScreenLayout::memory() const {
  return (first_source_.size() + sources_.size() + gutter_begin_.size() + gutter_tiles_.size()) * sizeof(std::uint32_t);
}

std::uint8_t ReliefRange::code(double height_mm) const {
  return static_cast<std::uint8_t>(
      std::floor(255.0 * std::clamp((height_mm - low_mm) / (high_mm - low_mm), 0.0, 1.0) + 0.5));
}

TilePlanes::TilePlanes(const ScreenLayout& layout) : layout_(&layout) {
  for (std::vector<std::uint8_t>& plane : planes_) plane.assign(layout.num_tiles() * kTileBytes, 0);
}

namespace {

using TileBytes = std::array<std::uint8_t, TilePlanes::kTileBytes>;

/// Codes are R, G, B, specular from the lowest byte, which is how they travel.
void read_surface(const simulation::Composer& composer, const std::array<simulation::TexelIndex, 64>& sources,
                  TileBytes& out) {
  static_assert(std::endian::native == std::endian::little);
  const std::span<const std::uint32_t> codes = composer.codes();
  for (std::size_t i = 0; i < 64; ++i) {
    const std::uint32_t code = sources[i] == simulation::kNoTexel ? 0 : codes[sources[i]];
    std::memcpy(&out[4 * i], &code, 4);
  }
}

void read_relief(const simulation::Composer& composer, const std::array<simulation::TexelIndex, 64>& sources,
                 const ReliefRange& range, TileBytes& out) {
  const std::span<const std::uint8_t> normals = composer.normals();
  for (std::size_t i = 0; i < 64; ++i) {
    const simulation::TexelIndex t = sources[i];
    if (t == simulation::kNoTexel) continue;
    const std::uint8_t* normal = &normals[std::size_t{simulation::TileGrid::tile_of(t)} * 192 + t % 64];
    for (std::size_t c = 0; c < 3; ++c) out[4 * i + c] = normal[64 * c];
    out[4 * i + 3] = range.code(composer.height_mm(t));
  }
}

/// @returns whether they differed.
bool replace(std::uint8_t* old, const TileBytes& now) {
  if (std::memcmp(old, now.data(), now.size()) == 0) return false;
  std::memcpy(old, now.data(), now.size());
  return true;
}

}  // namespace

TilePlanes::Changes TilePlanes::update(const simulation::Composer& composer, std::span<const ScreenTile> tiles,
                                       const ReliefRange& range, const RunControl& control) {
  constexpr std::int64_t kChunk = 512;
  std::vector<std::uint8_t> changed(tiles.size());  // bit 0: surface, bit 1: relief
  parallel_for(static_cast<std::int64_t>(tiles.size()), kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const std::array<simulation::TexelIndex, 64> sources = layout_->sources(tiles[i]);
      TileBytes surface{}, relief{};
      read_surface(composer, sources, surface);
      read_relief(composer, sources, range, relief);
      const bool has_surface = replace(&planes_[Surface][tiles[i] * kTileBytes], surface),
                 has_relief = replace(&planes_[Relief][tiles[i] * kTileBytes], relief);
      changed[i] = static_cast<std::uint8_t>((has_surface ? 1 : 0) | (has_relief ? 2 : 0));
    }
  });
  Changes changes;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if ((changed[i] & 1) != 0) changes.surface.push_back(tiles[i]);
    if ((changed[i] & 2) != 0) changes.relief.push_back(tiles[i]);
  }
  return changes;
}

std::span<const std::uint8_t> TilePlanes::tile(Plane plane, ScreenTile tile) const {
  return {&planes_[plane][tile * kTileBytes], kTileBytes};
}

std::string TilePlanes::rows(Plane plane) const { return rows_of_tiles(*layout_, planes_[plane]); }

std::string rows_of_tiles(const ScreenLayout& layout, std::span<const std::uint8_t> tiles) {
  const auto width = static_cast<std::size_t>(layout.width()), height = static_cast<std::size_t>(layout.height());
  std::string out(width * height * 4, '\0');
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; x += 8) {
      const std::size_t tile = y / 8 * static_cast<std::size_t>(layout.columns()) + x / 8;
      std::memcpy(&out[4 * (y * width + x)], &tiles[tile * TilePlanes::kTileBytes + y % 8 * 32],
                  4 * std::min<std::size_t>(8, width - x));
    }
  }
  return out;
}

}  // namespace patinate::studio
