/// \file
/// What a synthesis searches: made of a transfer's input, before any texel has a place.
#pragma once

#include <cstddef>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/transfer/transfer.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/multi_level.h"

namespace patinate::transfer {

/// A transfer up to its search.
struct PreparedTransfer {
  TransferOptions used;             ///< With a value for everything that was left open.
  SourceStructure structure;        ///< Of the history, at its full size.
  double explained_variance = 0.0;  ///< TransferResult's.
  std::vector<double> weights;      ///< Of the controls.
  std::size_t first = 0;            ///< How often the history is halved on the finest level.
  int source_width = 0;             ///< Of the history, pixels.
  Neighborhood neighborhood;
  std::vector<SynthesisLevel> levels;  ///< Finest first, at least one; without neighbors.
  double progress_share = 0.0;         ///< Of a whole transfer's progress, which preparing has reported.
};

/// @throws InvalidInput as transfer()
[[nodiscard]] PreparedTransfer prepare_transfer(const TransferInput& input, const TransferOptions& asked,
                                                const RunControl& control);

/// The structure of each level that is refined, finest first; without channels where the source has none, but all of
/// its borders are refined.
[[nodiscard]] std::vector<SourceStructure> refined_structures(const PreparedTransfer& prepared,
                                                              const RunControl& control);

/// Refinement after the passes of a level: refine_places(), where there are rounds.
/// @param structures,weights  Must outlive it. @param region  Texels of each level, finest first, that it may move;
/// null: all. Must outlive it.
[[nodiscard]] LevelRefinement refinement_of(const std::vector<SourceStructure>& structures,
                                            const TransferOptions& options, const std::vector<double>& weights,
                                            const std::vector<TexelSet>* region = nullptr);

}  // namespace patinate::transfer
