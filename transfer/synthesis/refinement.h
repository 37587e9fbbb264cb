/// \file
/// Graph-cut refinement of the coordinate map: borders of copied pieces are moved to where they break no structure.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/amounts.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/nearby_uses.h"
#include "transfer/synthesis/patch_cut.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/seam_cost.h"
#include "transfer/synthesis/similar_pixels.h"
#include "transfer/synthesis/surface_patch.h"

namespace patinate::transfer {

/// Sums of seam costs in blocks of 8 x 8 texels of a level, row by row.
class BlockCosts {
 public:
  /// All must outlive this. @param beside  Neighbors, of which those beside a texel are looked at.
  BlockCosts(const DestinationLevel& destination, const TexelNeighborhood& beside, const SeamFeatures& features);

  [[nodiscard]] std::size_t size() const { return costs_.size(); }
  /// Measures the cost of the pairs of texels in each block. @param texels  Those that count.
  void measure(const TexelSet& texels, const PlaceMap& places, const RunControl& control);
  struct Sum {
    std::int64_t cost = 0, num_texels = 0;  ///< Texels that count.
  };
  /// Of the 3 x 3 blocks around one.
  [[nodiscard]] Sum around(std::size_t block) const;
  /// A texel near the middle of a block; -1 = none.
  [[nodiscard]] TexelId texel_in(std::size_t block) const;

 private:
  [[nodiscard]] std::int64_t texel_cost(TexelId t, TexelNeighborhood::Cursor& cursor, const PlaceMap& places) const;

  const TexelMap& map_;
  const FrameTurns* turns_;
  const TexelNeighborhood& beside_;
  const SeamFeatures& features_;
  int columns_, rows_;
  std::vector<std::int64_t> costs_;
  std::vector<std::int32_t> num_texels_;  ///< By block.
};

struct RefinementOptions {
  int num_rounds = 10;         ///< [0, 256].
  double control_share = 0.5;  ///< Weight of control mismatch against borders; >= 0.
};

/// Refines the borders of a level, round by round.
class LevelRefiner {
 public:
  /// All arguments must outlive this. @param structure  Structure of the level's source, without its margin.
  /// @param texels  The texels that may get other places.
  LevelRefiner(const SynthesisLevel& level, const SourceStructure& structure, const SimilarPixels& similar,
               std::span<const double> control_weights, std::uint64_t seed, const RefinementOptions& options,
               const TexelSet& texels, const RunControl& control);
  LevelRefiner(const LevelRefiner&) = delete;
  LevelRefiner& operator=(const LevelRefiner&) = delete;

  /// The eight beside each texel.
  [[nodiscard]] const TexelNeighborhood& beside() const { return beside_; }
  void round(int index, PlaceMap& places, const RunControl& control);

 private:
  static constexpr int kPatient = 256;
  /// Texels of the windows that are found at once, for each thread. A texel takes about 300 bytes in its patch: those
  /// of all windows of a large atlas would take more memory than everything else.
  static constexpr std::size_t kBatchTexels = 1024;
  static constexpr std::uint8_t kBeside = 1, kMember = 2;  ///< Marks of a window of this round.

  /// A window of a round.
  struct Window {
    std::size_t block = 0;
    SurfacePatch patch;
    bool has_gained = false;
  };
  /// A block that may become a window, by its cost and patience.
  struct Wish {
    std::int64_t priority;
    std::size_t block;
  };
  /// All blocks whose borders can be seen, those of most cost first.
  [[nodiscard]] std::vector<Wish> find_wishes() const;
  /// The next windows of a round, greedily, none within a texel of another: their patches have about kBatchTexels for
  /// each thread.
  /// @param wishes  Those that were looked at are removed from its front.
  [[nodiscard]] std::vector<Window> choose_windows(int index, std::span<const Wish>& wishes, PatchFinder& finder,
                                                   const RunControl& control);
  void improve(int index, Window& window, PlaceMap& places, const RunControl& control) const;
  /// To the nearest texel that is taken, or to the rim.
  [[nodiscard]] int room_px(const SurfacePatch& patch) const;
  /// Over seams a texel may see one that does not see it.
  [[nodiscard]] bool sees_a_member(const SurfacePatch& patch) const;
  /// A smaller patch lies a little differently, and may again hold a texel that must not be moved.
  [[nodiscard]] bool holds_what_stays(const SurfacePatch& patch) const;
  /// With the texels beside it: they are held fixed.
  void take(const SurfacePatch& patch);

  const SynthesisLevel& level_;
  const TexelSet& texels_;
  bool has_structure_;
  TexelNeighborhood beside_;
  SeamFeatures features_;
  ControlCost control_cost_;
  Amounts amounts_;
  NearbyUses nearby_;
  CutTask task_;
  std::uint64_t seed_;
  std::vector<int> halves_;
  BlockCosts costs_;
  std::vector<int> patience_;           ///< By block: falls where nothing is gained.
  std::vector<std::uint8_t> is_taken_;  ///< By texel.
};

/// Spreads what pieces are sheared by: a place becomes the mean of where it lies and where its neighbors of the same
/// piece would have it, sweep by sweep, each from the state before it. A seam is free up to half a pixel, so that
/// fractions creep in a few steps and lines there have kinks. Pieces that lie on whole pixels stay there.
/// @param region  Texels that are moved; null: all.
void smooth_places(const SynthesisLevel& level, const TexelNeighborhood& beside, int num_sweeps, PlaceMap& places,
                   const RunControl& control = {}, const TexelSet* region = nullptr);

/// Lowers the sum of seam costs (seam_cost.h), of control mismatch, and of what is there too often (amounts.h, counted
/// before each round), window by window where borders cost most (patch_cut.h). Every round chooses windows that do not
/// touch and improves each from the state before the round; random numbers come from seed, round and window, and counts
/// are fixed, so that threads do not matter. In the end places are smoothed. [Kwatra et al.
/// 2003, "Graphcut textures"; Pritch, Kav-Venaki and Peleg 2009, "Shift-map image editing"]
/// @param structure  Of the level's source, without its margin.
/// @param places     What is refined.
/// @param region     Texels that are moved, windows lie inside of it; null: all.
void refine_places(const SynthesisLevel& level, const SourceStructure& structure, const SimilarPixels& similar,
                   std::span<const double> control_weights, std::uint64_t seed, const RefinementOptions& options,
                   PlaceMap& places, const RunControl& control = {}, const TexelSet* region = nullptr);

}  // namespace patinate::transfer
