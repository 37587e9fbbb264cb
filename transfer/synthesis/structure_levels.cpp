#include "transfer/synthesis/structure_levels.h"

#include <algorithm>
#include <array>
#include <utility>

#include "libcommon/image/filters.h"
#include "transfer/synthesis/refinement.h"

namespace patinate::transfer {

namespace {

/// The next coarser level's.
SourceStructure halved(const SourceStructure& fine, const RunControl& control) {
  SourceStructure structure = fine;
  structure.channels = downscale_area(fine.channels, std::max(1, fine.channels.width() / 2),
                                      std::max(1, fine.channels.height() / 2), control);
  structure.scale_px /= 2.0;
  return structure;
}

}  // namespace

int refinement_rounds(TransferQuality quality) {
  constexpr std::array kRounds{0, 10, 32};
  return kRounds[static_cast<std::size_t>(quality)];
}

std::size_t levels_with_structure(double scale_px) {
  constexpr double kLeastScale_px = 4.0;  // Cells of less than eight pixels are not told from texture.
  std::size_t levels = 1;
  for (; scale_px >= 2.0 * kLeastScale_px; scale_px /= 2.0) ++levels;
  return levels;
}

std::vector<SourceStructure> structure_levels(SourceStructure structure, std::size_t first, std::size_t num_levels,
                                              const RunControl& control) {
  if (structure.empty()) return {};
  for (std::size_t l = 0; l < first; ++l) structure = halved(structure, control);
  const std::size_t count = std::min(levels_with_structure(structure.scale_px), std::max<std::size_t>(1, num_levels));
  std::vector<SourceStructure> levels{std::move(structure)};
  while (levels.size() < count) levels.push_back(halved(levels.back(), control));
  return levels;
}

LevelRefinement refinement_of(const std::vector<SourceStructure>& structures, const TransferOptions& options,
                              const std::vector<double>& weights, const TileGrid* grid) {
  const int num_rounds = structures.empty() ? 0 : refinement_rounds(options.quality);
  if (num_rounds == 0) return {};
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const auto refine = [=, &structures, &weights](std::size_t l, const SynthesisLevel& level,
                                                 const SimilarPixels& similar, PlaceMap& places,
                                                 const RunControl& control) {
    if (l >= structures.size()) return;
    refine_places(level, structures[l], similar, weights, seed + l, {.num_rounds = num_rounds}, places, control,
                  {grid != nullptr && l < grid->num_tiled_levels() ? grid : nullptr, l});
  };
  return {.refine = refine, .num_passes = static_cast<double>(num_rounds), .num_levels = structures.size()};
}

}  // namespace patinate::transfer
