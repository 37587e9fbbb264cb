/// \file
/// The fast synthesis: the reference's energy, lowered from coarse to fine by parallel passes over candidate sets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/core/zeroed_vector.h"
#include "patinate/transfer/transfer.h"
#include "transfer/synthesis/amounts.h"
#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/search_device.h"
#include "transfer/synthesis/similar_pixels.h"

namespace patinate::transfer {

inline constexpr search_kernel::Preferences kEnergyAlone{};
[[nodiscard]] search_kernel::Preferences preferences_of(const MultiLevelOptions& options);

/// How often sources are used, and what looks there are, at the beginning of a pass.
struct PlaceCounts {
  std::vector<std::int64_t> uses;  ///< By small cell of the source.
  Amounts::Counts amounts;
};

/// A part of a level that is searched, while the rest stays as it is.
struct SearchedPart {
  const TexelSet& texels;
  const Amounts& amounts;  ///< Of the level's source: they take longer to make than a small part to search.
};

/// Improves the places on one level, pass by pass. The atlas is worked on in squares: what lies together on the surface
/// is together in memory.
class Improver {
 public:
  /// @param device  Runs the passes over whole levels; may be null. @param part  Null: the whole level.
  Improver(const SynthesisLevel& level, const Neighborhood& neighborhood, const SimilarPixels& similar,
           const EnergyScale& scale, int num_random, std::uint64_t seed, const SearchDevice* device,
           const SearchedPart* part = nullptr);

  /// false: there is none, or it has failed.
  [[nodiscard]] bool has_device() const { return device_ != nullptr; }

  [[nodiscard]] PlaceCounts count(const PlaceMap& places, const RunControl& control) const;
  /// Four interleaved sets, each decided from the state before it. A texel near which nothing has changed since its
  /// last turn is skipped.
  /// @param is_whole  Every texel has its turn; the first pass is whole.
  /// @param counts    Of the level before the pass; looked at where the preferences do. Empty: as for the pass before.
  void pass(const search_kernel::Preferences& preferences, bool is_whole, std::uint32_t stream,
            const PlaceCounts& counts, PlaceMap& places, const RunControl& control);

  /// State of the level on the device, after the last pass; null where there is none, or it has failed.
  [[nodiscard]] std::unique_ptr<SearchDevice::Level> take_device_level() { return std::move(on_device_); }

 private:
  static constexpr int kNumSets = search_kernel::kInterleavedSets;
  static constexpr int kSquare = 64;  ///< Texels. Even, so that a set begins alike in all.

  struct Change {
    std::int32_t pixel;
    PlaceMap::Beside beside;
    std::uint16_t in_square;  ///< y * kSquare + x.
  };
  static_assert(sizeof(Change) == 8);

  /// @returns false, with nothing changed, where there is no device or it has failed.
  bool passed_on_device(const DevicePass& pass, PlaceMap& places, const RunControl& control);
  [[nodiscard]] search_kernel::SourceTables source_with(const SimilarPixels& similar) const;
  /// Calls visit(t, in_square) for the texels of a set whose turn it is.
  template <class Visit>
  void for_each_due(int square, int set, bool is_whole, const Visit& visit) const;
  void apply(int square, const Change& change, TexelNeighborhood::Cursor& cursor, PlaceMap& places);
  /// By several threads at once: all write the same.
  void mark(TexelId t);
  /// Those with texels.
  [[nodiscard]] std::vector<int> find_squares() const;

  const SynthesisLevel& level_;
  const TexelMap& map_;
  const Neighborhood& neighborhood_;
  const SimilarPixels& similar_;
  const EnergyScale& scale_;
  int num_random_;
  std::uint64_t seed_;
  const SearchDevice* device_;  ///< Null from when it has failed.
  std::unique_ptr<SearchDevice::Level> on_device_;
  const TexelSet& texels_;
  Amounts amounts_;
  std::vector<std::uint8_t> reuse_;  ///< By pixel.
  int squares_x_;
  std::vector<int> squares_;
  ZeroedVector<std::uint8_t> changed_near_;  ///< The last turn in which this texel or one beside it changed.
  int turn_ = 0;
};

/// Where texels are large the control decides, where they are small the texture.
inline constexpr double kFirstCoherence = 0.2;

/// Rises from the coarsest level to the finest.
[[nodiscard]] double coherence_of_level(std::size_t level, std::size_t coarsest, double coherence_share,
                                        const MultiLevelOptions& options);
/// Pixels that look alike, taken over from the coarser level where there are many. @param coarser  Null: the coarsest.
[[nodiscard]] SimilarPixels similar_of_level(const SourceLevel& source, const SourceLevel* coarser,
                                             const SimilarPixels& of_coarser, const RunControl& control);
/// Stream of random numbers of a pass.
[[nodiscard]] std::uint32_t stream_of(std::size_t level, int pass);

/// Refinement of a level's places after its passes.
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
