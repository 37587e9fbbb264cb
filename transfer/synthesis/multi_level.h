/// \file
/// The fast synthesis: the reference's energy, lowered from coarse to fine by parallel passes over candidate sets.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "patinate/transfer/transfer.h"
#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/search_device.h"
#include "transfer/synthesis/similar_pixels.h"

namespace patinate::transfer {

/// Where texels are large the control decides, where they are small the texture.
inline constexpr double kFirstCoherence = 0.2;

/// What is done with the places of a level after its passes.
struct LevelRefinement {
  /// @param index  Of the level, 0 = the finest. Empty: nothing.
  std::function<void(std::size_t index, const SynthesisLevel& level, const SimilarPixels& similar, PlaceMap& places,
                     const RunControl& control)>
      refine = {};
  double num_passes = 0.0;     ///< It takes about as long as so many passes; for progress only.
  std::size_t num_levels = 0;  ///< The finest ones; on the others nothing is done.
};

/// Starts on the coarsest level from pixels of similar control value. Each pass visits the texels in four interleaved
/// sets; a texel takes the best of: what it has, where its eight neighbors' sources lead (to fractions of a pixel, so
/// that pieces keep their shape on turned and stretched texels), what looks like those (k-coherence), and a few pixels
/// of similar control value. The lowest energy is not the best texture: it is smooth and repeats a few favorites, so
/// that continued pieces and rarely used sources are preferred, by factors on the cost (a cost of zero stays zero), and
/// texels that continue all their neighbors are left alone; only the very last pass goes by the energy, everywhere. A
/// texel is visited again only if it or one beside it has changed since. A set is decided from the state before it, so
/// that order and threads do not matter. [Lefebvre and Hoppe 2005, "Parallel controllable texture synthesis"; Tong et
/// al. 2002]
///
/// Where pieces turn against the frames (turns.h), which a pass does not know, only refinement goes on behind the first
/// level that is refined.
///
/// Cost: on each level one visit of all texels and about half as many again, two on the finest; up to about 50 costs a
/// visit, fewer in coherent regions. Same bits for any number of threads and instruction set.
/// @returns the places on the finest level synthesized.
/// @param levels  Finest first. Neighbors are found level by level, and each level but the finest is used up when the
/// next one has begun: all at once would take twice as much.
/// @param device  Runs the passes, with the same bits; may be null. When it fails, the CPU goes on.
/// @param kept  Takes what the device has of the finest level, for what is measured of it; null if it has failed.
[[nodiscard]] PlaceMap synthesize_multi_level(std::vector<SynthesisLevel>& levels, const Neighborhood& neighborhood,
                                              double coherence_share, std::span<const double> control_weights,
                                              std::uint64_t seed, const MultiLevelOptions& options = {},
                                              const RunControl& control = {}, const LevelRefinement& refinement = {},
                                              const SearchDevice* device = nullptr,
                                              std::unique_ptr<SearchDevice::Level>* kept = nullptr);

}  // namespace patinate::transfer
