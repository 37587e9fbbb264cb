/// \file
/// Improves a patch of the surface by copying parts of other pieces of the source into it, along the best borders.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "libcommon/core/random.h"
#include "patinate/core/run_control.h"
#include "transfer/synthesis/amounts.h"
#include "transfer/synthesis/nearby_uses.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/seam_cost.h"
#include "transfer/synthesis/similar_pixels.h"
#include "transfer/synthesis/surface_patch.h"

namespace patinate::transfer {

/// Data that all patches share.
struct CutTask {
  const SourceLevel& source;
  const DestinationLevel& destination;
  const SeamFeatures& features;
  const ControlCost& control_cost;
  const SimilarPixels& similar;
  const Amounts& amounts;
  const NearbyUses& nearby;
  int num_random = 256;  ///< Places of similar control value that are looked at for a patch.
  int num_tried = 4;     ///< The best of all looked at: as many cuts.
};

/// A piece of the source, by what a patch's center shows of it.
struct PieceCenter {
  FixedPoint point;
  Turn turn = 0;

  /// Where the piece shows what lies at `offset` from the center.
  [[nodiscard]] FixedPoint at(const FixedPoint& offset) const {
    const FixedPoint step = turned(offset, turn);
    return {point.x + step.x, point.y + step.y};
  }
};

/// One for each thread.
class PatchCut {
 public:
  explicit PatchCut(const CutTask& task) : task_(task) {}

  /// Lays the most promising pieces of the source over the patch, one after the other. A minimum cut finds the part of
  /// a piece that has the cheapest border [Boykov and Kolmogorov 2004]. The patch takes this part if the sum of the
  /// costs of seams, control and amounts falls. The sum is exact; the cut is not where pieces are distorted.
  /// @param patch  With edges. @param places  Of all texels; those outside of the patch do not change.
  /// @returns by how much the sum has fallen, >= 0: the new places are then in improved().
  /// @throws Canceled between two cuts.
  [[nodiscard]] std::int64_t improve(const SurfacePatch& patch, const PlaceMap& places, RandomStream random,
                                     const RunControl& control);
  /// In the order of the patch's texels.
  [[nodiscard]] std::span<const Place> improved() const { return current_; }

  /// The two steps of improve(): takes the patch as it is, ...
  void begin(const SurfacePatch& patch, const PlaceMap& places);
  /// ... and lays one piece over it, so that the patch's center gets the place `center`. @returns as improve().
  [[nodiscard]] std::int64_t lay(const SurfacePatch& patch, const PieceCenter& center);

 private:
  /// The place of the patch's center if a piece of the source is laid over it.
  struct Candidate {
    PieceCenter center;
    std::int64_t score = 0;
  };
  void find_candidates(const SurfacePatch& patch, RandomStream random);
  void consider(const PieceCenter& center);
  [[nodiscard]] std::int64_t score(const PieceCenter& center, std::int64_t bound) const;
  void settle(Candidate& candidate) const;
  [[nodiscard]] std::vector<PieceCenter> common_centers(const SurfacePatch& patch) const;
  [[nodiscard]] std::int32_t unary(TexelId texel, const Place& place, std::int32_t from) const;

  const CutTask& task_;
  std::vector<Place> current_;
  std::vector<Place> outside_;            ///< By edge: the place of its texel outside.
  std::vector<std::int32_t> seam_cost_;   ///< By edge, of the current places.
  std::vector<std::int32_t> unary_cost_;  ///< By texel.

  /// Texels that candidates are compared at: of the rim, and all over the patch.
  struct RimSample {
    FixedPoint offset;
    std::int32_t pixel = 0;
  };
  struct ControlSample {
    FixedPoint offset;
    TexelId texel = 0;
  };
  std::vector<RimSample> rim_;
  std::vector<RimSample> telling_rim_;  ///< The same, those first that few places of the source are like.
  std::vector<ControlSample> spread_;
  std::int64_t rim_weight_ = 0, spread_weight_ = 0;
  std::vector<Candidate> best_;  ///< Ascending by score, never two within kApart_px.
};

}  // namespace patinate::transfer
