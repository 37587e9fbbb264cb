#include "transfer/synthesis/refined_region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>

#include "tests/support/meshes.h"
#include "transfer/synthesis/source_levels.h"

namespace patinate::transfer {
namespace {

constexpr int kTilesSide = 96, kReach = 9;

/// Four tiles of a level, with the zones along their borders.
struct FourTiles {
  std::shared_ptr<const TexelMap> map;
  TileGrid grid;
  TexelNeighborhood beside;
  std::vector<std::vector<BorderTexel>> border;

  explicit FourTiles(const Mesh& mesh)
      : map(std::make_shared<TexelMap>(mesh, kTilesSide, kTilesSide)),
        grid(make_sheet({"a", "b", "c", "d"}, kTilesSide / 2 - 2 * make_sheet({"a", "b"}, 16).margin())),
        beside(*map, {}, place_source(*map, nullptr, 1.0, 0).frames, map->median_texel_size_mm()) {
    for (int tile = 0; tile < grid.num_tiles(); ++tile)
      border.push_back(find_border_texels(*map, grid, 0, tile, beside, kReach));
  }
  [[nodiscard]] int tile_of(TexelId t) const {
    return grid.tile_of(0, static_cast<int>(t % kTilesSide), static_cast<int>(t / kTilesSide));
  }
  [[nodiscard]] BorderZones zones() const { return {grid, 0, {border.begin(), border.end()}}; }
  template <class Visit>
  void for_each_beside(TexelId t, const Visit& visit) const {
    TexelNeighborhood::Cursor cursor(beside);
    for (const PixelNeighbor& n : cursor.at(t)) {
      if (n.texel >= 0) visit(TexelId{n.texel});
    }
  }
};

TEST(BorderZones, OfAPlaneAreTheTexelsWithinReachOfTheirNearestOtherTile) {
  const FourTiles four(testing_support::unit_plane(kTilesSide));
  ASSERT_EQ(four.grid.width(0), kTilesSide);
  for (int tile = 0; tile < 4; ++tile) {
    const auto& border = four.border[tile];
    std::map<TexelId, std::int64_t> found;
    for (const BorderTexel& b : border) found[b.texel] = b.other;
    const TexelRect rect = four.grid.rect(0, tile);
    for (int y = rect.y0; y < rect.y1; ++y) {
      for (int x = rect.x0; x < rect.x1; ++x) {
        // Between a texel and the tile beside or below: whole squares of eight neighbors.
        const int right = x < kTilesSide / 2 ? kTilesSide / 2 - 1 - x : x - kTilesSide / 2;
        const int down = y < kTilesSide / 2 ? kTilesSide / 2 - 1 - y : y - kTilesSide / 2;
        const auto at = found.find(TexelId{y} * kTilesSide + x);
        ASSERT_EQ(at != found.end(), std::min(right, down) <= kReach) << x << " " << y;
        if (at == found.end() || std::abs(right - down) <= 1) continue;  // Three tiles meet there.
        EXPECT_EQ(at->second, right < down ? tile ^ 1 : tile ^ 2) << x << " " << y;
      }
    }
    EXPECT_TRUE(std::is_sorted(border.begin(), border.end(),
                               [](const BorderTexel& a, const BorderTexel& b) { return a.texel < b.texel; }));
  }
}

/// What makes the order of regions unimportant: who is moved is seen by nobody who is moved in another region.
TEST(RefinedRegions, NoMemberSeesATexelOfAnotherRegion) {
  for (const Mesh& mesh : {testing_support::unit_plane(kTilesSide), testing_support::patchwork_plane(kTilesSide, 5),
                           testing_support::quilt_plane(kTilesSide, 3)}) {
    const FourTiles four(mesh);
    const BorderZones zones = four.zones();
    std::map<TexelId, int> zone_of;
    std::vector<RefinedRegion> regions;
    for (int tile = 0; tile < 4; ++tile) {
      for (const BorderZone& zone : zones.zones_of(tile)) {
        EXPECT_LT(zone.lower, zone.higher);
        for (const TexelId t : zone.texels) {
          EXPECT_TRUE(four.tile_of(t) == zone.lower || four.tile_of(t) == zone.higher);
          EXPECT_TRUE(zone_of.emplace(t, regions.size()).second) << "in two zones";
        }
        regions.push_back(zones.region_of(*four.map, zone, four.beside));
      }
    }
    std::size_t num_border = 0, num_members = 0;
    for (const auto& border : four.border) num_border += border.size();
    EXPECT_EQ(zone_of.size(), num_border) << "each border texel is in one zone";
    for (const auto& [t, zone] : zone_of) {
      for (std::size_t r = 0; r < regions.size(); ++r) {
        if (!regions[r].has(t)) continue;
        EXPECT_EQ(r, static_cast<std::size_t>(zone));
        ++num_members;
        four.for_each_beside(t, [&, at = t, mine = zone](TexelId n) {
          const auto other = zone_of.find(n);
          EXPECT_TRUE(other == zone_of.end() || other->second == mine) << at << " sees " << n;
        });
      }
    }
    EXPECT_GT(num_members, num_border / 2);
    for (int tile = 0; tile < 4; ++tile) {
      const RefinedRegion region = region_of_tile(*four.map, four.grid, 0, tile, four.beside);
      for (TexelId t = 0; t < kTilesSide * kTilesSide; ++t) {
        if (!four.map->is_covered(t) || !region.has(t)) continue;
        ASSERT_EQ(four.tile_of(t), tile);
        four.for_each_beside(t, [&](TexelId n) { EXPECT_EQ(four.tile_of(n), tile); });
      }
    }
  }
}

}  // namespace
}  // namespace patinate::transfer
