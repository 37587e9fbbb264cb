/// \file
/// A source's structure level by level, and how often borders are refined there.
#pragma once

#include <cstddef>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/transfer/transfer.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/multi_level.h"
#include "transfer/synthesis/refinement.h"

namespace patinate::transfer {

/// On every level that is refined; no rounds for drafts. The best quality refines sources without structure as well.
[[nodiscard]] RefinementOptions refinement_options(const SourceStructure& structure, TransferQuality quality);

/// How many levels are refined, the finest among them: those that show cells of the structure's size.
[[nodiscard]] std::size_t num_refined_levels(const SourceStructure& structure, TransferQuality quality);

/// On `first`, which is the finest that is synthesized, and on the coarser ones that are refined; without channels
/// where the source has no structure.
/// @param num_levels  At most so many.
[[nodiscard]] std::vector<SourceStructure> structure_levels(SourceStructure structure, TransferQuality quality,
                                                            std::size_t first, std::size_t num_levels,
                                                            const RunControl& control);

/// What synthesize_multi_level() does after the passes of a level: refine_places(), where there are rounds.
/// @param structures,weights  Must outlive it.
[[nodiscard]] LevelRefinement refinement_of(const std::vector<SourceStructure>& structures,
                                            const TransferOptions& options, const std::vector<double>& weights);

}  // namespace patinate::transfer
