#include "transfer/synthesis/structure_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libcommon/image/filters.h"

namespace patinate::transfer {

namespace {

constexpr double kPlainScale_px = 16.0;  // Half of a window that a source without cells is cut in.

/// The next coarser level's.
SourceStructure halved(const SourceStructure& fine, const RunControl& control) {
  SourceStructure structure = fine;
  if (!fine.empty())
    structure.channels = downscale_area(fine.channels, std::max(1, fine.channels.width() / 2),
                                        std::max(1, fine.channels.height() / 2), control);
  structure.scale_px /= 2.0;
  return structure;
}

}  // namespace

RefinementOptions refinement_options(const SourceStructure& structure, TransferQuality quality) {
  constexpr std::array kRounds{0, 10, 32};
  // Without lines nothing is lost where a control is followed more closely: three times as closely keeps the control
  // error of the search on rust and copper, in pieces four times as large.
  constexpr RefinementOptions kPlain{.num_rounds = 10, .control_share = 1.5};
  if (!structure.empty()) return {.num_rounds = kRounds[static_cast<std::size_t>(quality)]};
  return quality == TransferQuality::Best ? kPlain : RefinementOptions{.num_rounds = 0};
}

std::size_t num_refined_levels(const SourceStructure& structure, TransferQuality quality) {
  constexpr double kLeastScale_px = 4.0;  // Cells of less than eight pixels are not told from texture.
  if (refinement_options(structure, quality).num_rounds == 0) return 0;
  std::size_t levels = 1;
  for (double scale_px = structure.empty() ? kPlainScale_px : structure.scale_px; scale_px >= 2.0 * kLeastScale_px;
       scale_px /= 2.0)
    ++levels;
  return levels;
}

std::vector<SourceStructure> structure_levels(SourceStructure structure, TransferQuality quality, std::size_t first,
                                              std::size_t num_levels, const RunControl& control) {
  if (structure.empty()) {
    structure = {.channels = {}, .scale_px = std::ldexp(kPlainScale_px, static_cast<int>(first))};
  }
  for (std::size_t l = 0; l < first; ++l) structure = halved(structure, control);
  const std::size_t count = std::min(num_refined_levels(structure, quality), std::max<std::size_t>(1, num_levels));
  std::vector<SourceStructure> levels;
  while (levels.size() < count) levels.push_back(levels.empty() ? structure : halved(levels.back(), control));
  return levels;
}

LevelRefinement refinement_of(const std::vector<SourceStructure>& structures, const TransferOptions& options,
                              const std::vector<double>& weights) {
  if (structures.empty()) return {};
  const RefinementOptions refined = refinement_options(structures.front(), options.quality);
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const auto refine = [=, &structures, &weights](std::size_t l, const SynthesisLevel& level,
                                                 const SimilarPixels& similar, PlaceMap& places,
                                                 const RunControl& control) {
    if (l >= structures.size()) return;
    refine_places(level, structures[l], similar, weights, seed + l, refined, places, control);
  };
  return {.refine = refine, .num_passes = static_cast<double>(refined.num_rounds), .num_levels = structures.size()};
}

}  // namespace patinate::transfer
