/// \file
/// Synthesis of parts of a surface: a finished coordinate map of which some texels are searched again, while all others
/// stay as they are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/transfer/transfer.h"
#include "transfer/synthesis/amounts.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/prepared.h"
#include "transfer/synthesis/similar_pixels.h"

namespace patinate::transfer {

/// What is done with a region.
enum class RegionWork {
  Search,    ///< The passes of the fast synthesis: pieces that fit the control and what lies around.
  Structure  ///< The same, and borders are refined on every level that shows the source's structure (refinement.h).
};

/// A finished synthesis whose parts can be made again with other controls. It works as synthesize_multi_level() does,
/// on the texels of a region alone; what lies around it is what its texels must fit, on every level. It begins on the
/// level on which the region is a few texels large, so that forms may be as large as the region. Places of coarse
/// levels are those of the finest, halved: the state is the places and controls of the finest level alone.
///
/// A texel begins with the place that it has. One that misses its control by more than "similar" pixels differ
/// (kSimilarTolerance) begins with a pixel of similar control value. A finer level takes over what has moved on the
/// coarser one, so that what fits stays as it is.
///
/// Where pieces turn (turns.h), new pieces of the search follow the frames; refinement turns them.
/// Same places for any number of threads.
class RegionSynthesis {
 public:
  /// Takes as long as what transfer() does before its search, and finds the neighbors of every level.
  /// @param places  Of the finest level; every covered texel has one. @throws Canceled
  RegionSynthesis(PreparedTransfer prepared, PlaceMap places, const RunControl& control = {});
  RegionSynthesis(const RegionSynthesis&) = delete;
  RegionSynthesis& operator=(const RegionSynthesis&) = delete;

  [[nodiscard]] const PreparedTransfer& prepared() const { return prepared_; }
  [[nodiscard]] const DestinationLevel& destination() const { return prepared_.levels[0].destination; }
  [[nodiscard]] const PlaceMap& places() const { return states_[0].places; }
  /// Of a texel, to be changed; synthesize() or update() of a region that holds it is to follow.
  [[nodiscard]] std::span<std::uint16_t> target(TexelId t);
  /// To be changed likewise.
  [[nodiscard]] PlaceMap& places() { return states_[0].places; }

  /// These texels and those whose compared neighborhood reaches them.
  [[nodiscard]] TexelSet with_reach(std::span<const TexelId> texels) const;
  /// Searches a region again. @param seed  Of all its random numbers.
  void synthesize(const TexelSet& region, RegionWork work, std::uint64_t seed, const RunControl& control = {});
  /// After places and targets of a region were set: brings coarse levels into line.
  void update(const TexelSet& region);
  [[nodiscard]] EnergyReport energy(const RunControl& control = {}) const;

 private:
  /// The data of a level that its SynthesisLevel does not hold.
  struct State {
    SimilarPixels similar;
    EnergyScale scale;
    Amounts amounts;
    PlaceMap places;
  };
  /// Of every level, finest first, the texels that hold one of the region.
  [[nodiscard]] std::vector<TexelSet> parts_of(const TexelSet& region) const;
  void halve_targets(const std::vector<TexelSet>& parts);
  void halve_places(const std::vector<TexelSet>& parts);
  /// Texels that miss their control take another pixel.
  void reset_missed(std::size_t l, const TexelSet& part, std::uint64_t seed);
  void search(std::size_t l, const TexelSet& part, std::uint64_t seed, const RunControl& control);
  [[nodiscard]] std::vector<Place> places_of(std::size_t l, const TexelSet& part) const;
  /// Those of a part that lie elsewhere than they did.
  [[nodiscard]] TexelSet moved(std::size_t l, const TexelSet& part, const std::vector<Place>& before) const;
  /// Those of a fine part whose parent is among some of the coarser level.
  [[nodiscard]] TexelSet children(std::size_t l, const TexelSet& part, const TexelSet& parents) const;

  PreparedTransfer prepared_;
  std::vector<SourceStructure> structures_;
  std::vector<State> states_;  ///< By level.
};

}  // namespace patinate::transfer
