#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "libcommon/core/mapped_file.h"
#include "transfer/synthesis/refinement.h"
#include "transfer/synthesis/structure_levels.h"
#include "transfer/tiles/prepared_tiles.h"
#include "transfer/tiles/tile_controls.h"

namespace patinate::transfer {

namespace {

/// What find_border_texels() found for all tiles of a level.
class StoredBorders {
 public:
  StoredBorders(const std::filesystem::path& folder, std::size_t level, int num_tiles) {
    for (int i = 0; i < num_tiles; ++i) files_.emplace_back(folder / tile_file::borders(level, i));
  }
  [[nodiscard]] BorderZones zones(const TileGrid& grid, std::size_t level) const {
    std::vector<std::span<const BorderTexel>> by_tile;
    for (const MappedFile& f : files_) by_tile.push_back(f.all<BorderTexel>());
    return {grid, level, std::move(by_tile)};
  }

 private:
  std::vector<MappedFile> files_;
};

/// Regions' patience, one after another.
void write_patience(const std::filesystem::path& file, std::deque<RegionRefiner>& regions) {
  std::vector<int> all;
  for (RegionRefiner& r : regions) all.insert(all.end(), r.patience().begin(), r.patience().end());
  write_array(file, std::span<const int>(all));
}

void read_patience(const std::filesystem::path& file, std::deque<RegionRefiner>& regions) {
  const MappedFile mapped(file);
  std::size_t first = 0;
  for (RegionRefiner& r : regions) {
    const auto values = mapped.values<int>(first * sizeof(int), r.patience().size());
    std::copy(values.begin(), values.end(), r.patience().begin());
    first += r.patience().size();
  }
}

std::vector<TexelId> texels_of(const std::vector<BorderZone>& zones) {
  std::vector<TexelId> texels;
  for (const BorderZone& z : zones) texels.insert(texels.end(), z.texels.begin(), z.texels.end());
  std::sort(texels.begin(), texels.end());
  return texels;
}

}  // namespace

/// What a round needs of a part of a level.
struct TiledTransfer::LoadedLevel {
  SynthesisLevel synthesis;
  SimilarPixels similar = {};
  NeighborFinder find;
  std::optional<LevelRefiner> refiner;  ///< None where the level shows no structure.

  /// @param texels  Whose borders are refined.
  LoadedLevel(const Prepared& p, const TileGrid& grid, std::size_t level, int round, const TexelPart& texels,
              const Folder& folder, const RunControl& control)
      : synthesis(p.level_of(level, p.map_on(level, control), targets_of(p, grid, level, texels, folder), control)),
        find([this, control](const TexelPart& of) {
          return LevelRefiner::neighbors_beside(synthesis.destination, of, control);
        }) {
    if (level >= p.structures.size()) return;
    similar = read_similar(folder, level);
    refiner.emplace(synthesis, p.structures[level], similar, p.weights,
                    static_cast<std::uint64_t>(p.options.seed) + level,
                    refinement_options(p.structures[level], p.options.quality), find(texels));
    for (int r = 0; r <= round; ++r) {  // Prices grow from round to round.
      Amounts::Counts counts;
      for (int tile = 0; tile < grid.num_tiles(); ++tile)
        counts.add(read_amounts(folder / tile_file::amounts(level, r, tile)));
      refiner->amounts().set(counts);
    }
  }
  LoadedLevel(const LoadedLevel&) = delete;
  LoadedLevel& operator=(const LoadedLevel&) = delete;

 private:
  static std::shared_ptr<const LevelPart> targets_of(const Prepared& p, const TileGrid& grid, std::size_t level,
                                                     const TexelPart& texels, const Folder& folder) {
    auto part = std::make_shared<LevelPart>();
    part->rect = texels.rect;
    part->others = texels.others;
    StoredTargets(folder, grid, level, static_cast<int>(p.weights.size())).load(texels.rect, texels.others, *part);
    return part;
  }
};

void TiledTransfer::write_borders(std::size_t level, int tile, const Folder& folder, const RunControl& control) {
  const Prepared& p = prepare(folder, control);
  std::vector<BorderTexel> border;
  if (level < p.structures.size()) {
    auto part = std::make_shared<LevelPart>();
    part->rect = grid_.rect(level, tile);
    const auto map = p.map_on(level, control);
    const SynthesisLevel synthesis = p.level_of(level, map, part, control);
    border = find_border_texels(*map, grid_, level, tile,
                                LevelRefiner::neighbors_beside(synthesis.destination, {part->rect, {}}, control),
                                LevelRefiner::largest_half_px(p.structures[level]));
  }
  write_array(folder / tile_file::borders(level, tile), std::span<const BorderTexel>(border));
}

void TiledTransfer::refine_borders(std::size_t level, int round, int tile, const Folder& folder,
                                   const RunControl& control) {
  const RunControl silent = control.silent();
  const Prepared& p = prepare(folder, silent);
  const StoredBorders borders(folder, level, grid_.num_tiles());
  const BorderZones all = borders.zones(grid_, level);
  const std::vector<BorderZone> zones = all.zones_of(tile);
  const TexelPart part{{}, texels_of(zones)};
  PlaceMap places(grid_.num_texels(level), p.sources[level].width(), true);
  const LoadedLevel loaded(p, grid_, level, round, part, folder, silent);
  const TexelMap& map = *loaded.synthesis.destination.map;
  TiledPlaces stored = stored_places(folder, grid_, level, num_passes(level) + round);
  stored.load(part.others, places, {});
  stored.load(find_rim(map, part, loaded.find), places, {});
  std::deque<RegionRefiner> regions;
  for (const BorderZone& zone : zones)
    regions.emplace_back(*loaded.refiner, all.region_of(map, zone, loaded.refiner->beside()));
  if (round > 0) read_patience(folder / tile_file::zone_patience(level, round - 1, tile), regions);
  refine_regions(regions, round, places, silent);
  write_patience(folder / tile_file::zone_patience(level, round, tile), regions);
  write_moved(folder / tile_file::moved(level, round, tile), part.others, places);
  control.report(1.0);
}

void TiledTransfer::refine(std::size_t level, int round, int tile, const Folder& folder, const RunControl& control) {
  const RunControl silent = control.silent();
  const Prepared& p = prepare(folder, silent);
  const TexelRect rect = grid_.rect(level, tile);
  const int before = num_passes(level) + round;
  const LoadedLevel loaded(p, grid_, level, round, {rect, {}}, folder, silent);
  const DestinationLevel& destination = loaded.synthesis.destination;
  const TexelMap& map = *destination.map;
  PlaceMap places(grid_.num_texels(level), p.sources[level].width(), true);
  TiledPlaces stored = stored_places(folder, grid_, level, before);
  stored.load(rect, tile, places, {});
  std::deque<RegionRefiner> regions;
  if (loaded.refiner) {
    const std::vector<TexelId> rim = find_rim(map, {rect, {}}, loaded.find);
    stored.load(rim, places, {});
    const auto is_seen = [&](TexelId t) {
      const int x = static_cast<int>(t % map.width()), y = static_cast<int>(t / map.width());
      return rect.contains(x, y) || std::binary_search(rim.begin(), rim.end(), t);
    };
    for (int other = 0; other < grid_.num_tiles(); ++other)
      read_moved(folder / tile_file::moved(level, round, other), places, is_seen);
    regions.emplace_back(*loaded.refiner, region_of_tile(map, grid_, level, tile, loaded.refiner->beside()));
    if (round > 0) read_patience(folder / tile_file::patience(level, round - 1, tile), regions);
    refine_regions(regions, round, places, silent);
  }
  write_places(folder / tile_file::places(level, before + 1, tile), map, rect, places, {});
  write_patience(folder / tile_file::patience(level, round, tile), regions);
  if (round + 1 < num_rounds(level)) {
    write_amounts(folder / tile_file::amounts(level, round + 1, tile),
                  Amounts(loaded.synthesis.source).count(destination, places, silent));
  }
  control.report(1.0);
}

SimilarPixels read_similar(const std::filesystem::path& folder, std::size_t level) {
  const MappedFile file(folder / tile_file::similar(level));
  const auto all = file.all<std::int32_t>();
  SimilarPixels similar(all.size() / kNumSimilar);
  std::copy_n(all.begin(), similar.size() * kNumSimilar, similar.data()->data());
  return similar;
}

}  // namespace patinate::transfer
