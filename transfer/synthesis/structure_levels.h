/// \file
/// A source's structure level by level, and how often borders are refined there.
#pragma once

#include <cstddef>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/transfer/transfer.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/multi_level.h"
#include "transfer/synthesis/tile_grid.h"

namespace patinate::transfer {

/// Rounds of refinement on every level that shows the structure; 0 for drafts.
[[nodiscard]] int refinement_rounds(TransferQuality quality);

/// How many levels show cells of this size, the finest among them.
/// @param scale_px  SourceStructure::scale_px on the finest level.
[[nodiscard]] std::size_t levels_with_structure(double scale_px);

/// On `first`, which is the finest that is synthesized, and on the coarser ones that still show it; none of an empty
/// one.
/// @param num_levels  At most so many.
[[nodiscard]] std::vector<SourceStructure> structure_levels(SourceStructure structure, std::size_t first,
                                                            std::size_t num_levels, const RunControl& control);

/// What synthesize_multi_level() does after the passes of a level: refine_places(), where there are rounds.
/// @param structures,weights,grid  Must outlive it. @param grid  Null: one tile.
[[nodiscard]] LevelRefinement refinement_of(const std::vector<SourceStructure>& structures,
                                            const TransferOptions& options, const std::vector<double>& weights,
                                            const TileGrid* grid);

}  // namespace patinate::transfer
