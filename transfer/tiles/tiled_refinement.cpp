#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "libcommon/core/mapped_file.h"
#include "transfer/synthesis/refinement.h"
#include "transfer/tiles/prepared_tiles.h"
#include "transfer/tiles/tile_controls.h"

namespace patinate::transfer {

void TiledTransfer::refine(std::size_t level, int round, int tile, const Folder& folder, const RunControl& control) {
  const RunControl silent = silenced(control);
  const Prepared& p = prepare(folder, silent);
  const TexelRect rect = grid_.rect(level, tile);
  const int before = num_passes(level) + round;
  const bool is_last = round + 1 == num_rounds(level);
  PlaceMap places(grid_.num_texels(level), p.sources[level].width(), true);
  TiledPlaces stored = stored_places(folder, grid_, level, before);
  stored.load(rect, tile, places, {});
  const auto map = p.map_on(level, silent);
  auto part = std::make_shared<LevelPart>();
  part->rect = rect;
  StoredTargets(folder, grid_, level, static_cast<int>(p.weights.size())).load(rect, {}, *part);
  const SynthesisLevel synthesis = p.level_of(level, map, part);
  const DestinationLevel& destination = synthesis.destination;
  std::vector<int> patience;
  if (level < p.structures.size()) {
    const NeighborFinder find = [&](const TexelPart& of) {
      return LevelRefiner::neighbors_beside(destination, of, silent);
    };
    stored.load(find_rim(*map, rect, find), places, {});
    const SimilarPixels similar = read_similar(folder, level);
    LevelRefiner shared(synthesis, p.structures[level], similar, p.weights,
                        static_cast<std::uint64_t>(p.options.seed) + level, {}, find({rect, {}}));
    for (int r = 0; r <= round; ++r) {  // Prices grow from round to round.
      Amounts::Counts counts;
      for (int other = 0; other < grid_.num_tiles(); ++other)
        counts.add(read_amounts(folder / tile_file::amounts(level, r, other)));
      shared.amounts().set(counts);
    }
    RegionRefiner region(shared, seen_region(*map, level, tile, shared.beside(), folder));
    if (round > 0) {
      const MappedFile file(folder / tile_file::patience(level, round - 1, tile));
      const auto values = file.all<int>();
      std::copy(values.begin(), values.end(), region.patience().begin());
    }
    region.measure(places, silent);
    region.round(round, places, silent);
    patience.assign(region.patience().begin(), region.patience().end());
  }
  write_places(folder / tile_file::places(level, before + 1, tile), *map, rect, places, {});
  write_array(folder / tile_file::patience(level, round, tile), std::span<const int>(patience));
  if (!is_last) {
    write_amounts(folder / tile_file::amounts(level, round + 1, tile),
                  Amounts(synthesis.source).count(destination, places, silent));
  }
  control.report(1.0);
}

RefinedRegion TiledTransfer::seen_region(const TexelMap& map, std::size_t level, int tile,
                                         const TexelNeighborhood& beside, const Folder& folder) const {
  RefinedRegion region = region_of_tile(map, grid_, level, tile, beside);
  const StoredLinks links(folder, level, grid_.num_tiles());
  const TexelRect& rect = region.rect;
  const auto at = [&](TexelId t) {
    return std::pair(static_cast<int>(t % map.width()), static_cast<int>(t / map.width()));
  };
  for (int y = rect.y0; y < rect.y1; ++y) {
    const TexelId row = TexelId{y} * map.width();
    links.for_each(row + rect.x0, row + rect.x1, [&](const TexelLink& link) {
      const auto [x, own_y] = at(link.target);
      const auto [sx, sy] = at(link.source);
      if (!rect.contains(sx, sy)) region.note(x, own_y, grid_.tile_of(level, sx, sy));
    });
  }
  return region;
}

SimilarPixels read_similar(const std::filesystem::path& folder, std::size_t level) {
  const MappedFile file(folder / tile_file::similar(level));
  const auto all = file.all<std::int32_t>();
  SimilarPixels similar(all.size() / kNumSimilar);
  std::copy_n(all.begin(), similar.size() * kNumSimilar, similar.data()->data());
  return similar;
}

}  // namespace patinate::transfer
