/// \file
/// Graph-cut refinement of the coordinate map: borders of copied pieces are moved to where they break no structure.
#pragma once

#include <cstdint>
#include <span>

#include "patinate/core/run_control.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/similar_pixels.h"

namespace patinate::transfer {

struct RefinementOptions {
  int num_rounds = 10;         ///< [0, 256].
  double control_share = 0.5;  ///< What control mismatch weighs against borders; >= 0.
};

/// Lowers the sum of seam costs (seam_cost.h), of control mismatch, and of what is there too often (amounts.h, counted
/// before each round), window by window where borders cost most (patch_cut.h). Every round chooses windows that do not
/// touch and improves each from the state before the round; random numbers come from seed, round and window, and counts
/// are fixed, so that threads do not matter. [Kwatra et al. 2003, "Graphcut textures"; Pritch, Kav-Venaki and Peleg
/// 2009, "Shift-map image editing"]
/// @param structure  Of the level's source, without its margin.
/// @param places     What is refined.
void refine_places(const SynthesisLevel& level, const SourceStructure& structure, const SimilarPixels& similar,
                   std::span<const double> control_weights, std::uint64_t seed, const RefinementOptions& options,
                   PlaceMap& places, const RunControl& control = {});

}  // namespace patinate::transfer
