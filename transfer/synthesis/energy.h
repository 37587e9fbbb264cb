/// \file
/// The energy that synthesis lowers, and how it is measured afterwards.
///
/// A coordinate map assigns to every covered texel t a source pixel s(t). Its energy is the mean over texels of
///
///     a * C(t) + (1 - a) * K(t)
///     C(t) = sum_k w_k |A(s(n_k(t))) - A(s(t) + d_k(t))|^2 / (sum_k w_k * 2 var A)   coherence, all frames at once
///     K(t) = sum_c g_c (P_c(s(t)) - Q_c(t))^2 / (2 var P_c)                          control mismatch
///
/// with A the appearance, n_k(t) the texel nearest to offset k of the neighborhood on the surface, d_k(t) where it
/// really lies in whole source pixels (texels may be turned, small or stretched against those), P the history's
/// controls and Q the destination's, mapped into P's values; g sums to 1; var P is at least (1/64)^2 of P's range
/// squared. Both parts are 1 for independent random texels. [Efros and Leung 1999; Efros and Freeman 2001, sec. 4]
///
/// Everything that decides is an integer: equal input gives equal coordinates (tested on x86-64).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/transfer/transfer.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/search_kernel.h"
#include "transfer/synthesis/turns.h"

namespace patinate::transfer {

/// Weights of the energy as integers: cost = coherence * coherence_scales[sum of weights] + sum_c difference_c^2 *
/// control_scale[c].
struct EnergyScale {
  std::vector<std::int64_t>
      coherence_scales;  ///< By the sum of weights of the known neighbors, [0, Neighborhood::kLargestSum].
  std::vector<std::int64_t> control_scale;

  /// @param coherence_share  a
  [[nodiscard]] static EnergyScale make(const SourceLevel& source, double coherence_share,
                                        std::span<const double> control_weights);
  /// Cost 1.0 as an integer.
  static constexpr double kOne = 1099511627776.0;  // 2^40
};

/// Values of a control, both included.
struct ControlInterval {
  std::uint16_t low = 0;
  std::uint16_t high = kControlSteps;
};

/// Quarter of the neighborhood that an offset lies in, as the sails of a windmill; those earlier in row order than the
/// texel are quarters 0 and 3. All hold as many offsets.
[[nodiscard]] constexpr unsigned quarter_of(const Offset& o) {
  return o.y < 0 && o.x >= 0 ? 0 : o.x > 0 ? 1 : o.y > 0 ? 2 : 3;
}
inline constexpr unsigned kNumQuarters = 4;
inline constexpr unsigned kAllQuarters = 15;

/// Parameters of `neighborhood` and `scale` for kernels; valid as long as they are.
[[nodiscard]] search_kernel::CostTables cost_tables(const Neighborhood& neighborhood, const EnergyScale& scale);

/// The cost of giving source pixels to one texel, its known neighbors held fixed.
class TexelCost {
 public:
  TexelCost(const SourceLevel& source, const DestinationLevel& destination, const Neighborhood& neighborhood);

  /// Looks up the neighbors of a texel: what neighbor() and adjacent() tell.
  void visit(TexelId texel);
  /// Visits it, and gathers the neighbors that have coordinates and lie within the radius, those of most weight first.
  /// O(neighborhood). @param turn  Of the pieces that are tried.
  void prepare(TexelId texel, const CoordinateMap& coordinates, const EnergyScale& scale, Turn turn = 0);
  /// Cost of a pixel. Stops early and returns something >= bound when it cannot be below `bound`.
  [[nodiscard]] std::int64_t total(std::int32_t source_pixel, std::int64_t bound) const;
  /// Cost of a place beside the middle of its pixel: neighbors are compared with the pixels nearest to where they
  /// lie seen from there, d_k(t) in fractions. A piece that goes on where texels are turned or stretched then costs
  /// nothing; rounding both ends apart would make every thin line in it cost, and plain ground not.
  /// @param beside_x,beside_y  In 1/256 pixel, [-128, 128].
  [[nodiscard]] std::int64_t total_beside(std::int32_t source_pixel, int beside_x, int beside_y,
                                          std::int64_t bound) const;
  [[nodiscard]] std::int64_t control(std::int32_t source_pixel) const;
  [[nodiscard]] std::int64_t coherence(std::int32_t source_pixel) const;
  /// Values of the first control whose part of the cost alone does not exceed `cost`.
  [[nodiscard]] ControlInterval first_control_within(std::int64_t cost) const;
  [[nodiscard]] int num_known() const { return known_.num; }
  /// Quarters of the neighborhood whose neighbors are all known and lie where they should (d_k is offset k): bit q for
  /// quarter q.
  [[nodiscard]] unsigned whole_quarters() const;
  /// Appearances of the neighbors in the order of the neighborhood, kAppearanceSize values each; arbitrary outside of
  /// whole quarters.
  void appearances(std::span<std::int16_t> out) const;
  /// Cost of one unit of sum_k w_k |difference_k|^2, and of one of the first control's difference squared.
  [[nodiscard]] std::int64_t coherence_scale() const { return known_.coherence_scale; }
  [[nodiscard]] std::int64_t first_control_scale() const {
    return cost_tables_.num_controls == 0 ? 0 : cost_tables_.control_scales[0];
  }
  [[nodiscard]] int first_target() const { return target_[0]; }
  /// At offset k of the neighborhood; texel -1 where the surface ends.
  [[nodiscard]] const PixelNeighbor& neighbor(std::size_t k) const { return neighbors_[k]; }
  /// The eight texels beside this one.
  [[nodiscard]] std::span<const PixelNeighbor> adjacent() const {
    return neighbors_.subspan(destination_.neighbors->first_adjacent());
  }

 private:
  const SourceLevel& source_;
  const DestinationLevel& destination_;
  const Neighborhood& neighborhood_;
  TexelNeighborhood::Cursor cursor_;
  TexelId texel_ = -1;
  std::vector<PixelNeighbor> turned_;
  std::span<const PixelNeighbor> neighbors_;
  mutable search_kernel::KnownNeighbors known_;  ///< Room for what is seen from beside a pixel is scratch.
  std::vector<std::int32_t> known_at_;           ///< By offset: which of them is its neighbor; -1 = not known.
  std::span<const std::uint16_t> target_;
  search_kernel::SourceTables source_tables_{};
  search_kernel::CostTables cost_tables_{};
  std::vector<std::int64_t> control_scale_;
};

/// Sums of the report, in whole numbers: figures of parts add up to those of the whole, in any order.
struct EnergyFigures {
  /// Sum of costs: 2^32 * high + low.
  struct Sum {
    std::int64_t high = 0, low = 0;
    void add(std::int64_t cost);
    [[nodiscard]] double mean(std::int64_t count) const;
    friend bool operator==(const Sum&, const Sum&) = default;
  };
  Sum coherence, control;
  std::int64_t num_texels = 0, difference = 0, pairs = 0, coherent_pairs = 0;
  using ByValue = std::vector<std::int64_t>;
  ByValue differences = ByValue(kControlSteps + 1);  ///< Texels by how much they miss the first control,
  ByValue wanted = ByValue(kControlSteps + 1);       ///< by what they ask for,
  ByValue missed = ByValue(kControlSteps + 1);       ///< and by how much those miss it in all.
  std::vector<std::uint8_t> is_used = {};            ///< By source pixel.

  /// @param other  Of the same source.
  void add(const EnergyFigures& other);
  [[nodiscard]] EnergyReport report(const SourceLevel& source, double coherence_share) const;
};
/// Cost of all texels of a level, where something else than the CPU has summed it up.
struct CostSums {
  EnergyFigures::Sum coherence, control;
};
/// Each part with the full weight, so that figures do not depend on rounding by a share.
[[nodiscard]] EnergyScale full_scale(const SourceLevel& source, std::span<const double> control_weights);
/// Energy of the texels of the level. @param turns  Of their pieces; empty: none is turned. @param sums  Of
/// full_scale(); null: they are found here.
[[nodiscard]] EnergyFigures measure_figures(const SourceLevel& source, const DestinationLevel& destination,
                                            const Neighborhood& neighborhood, const CoordinateMap& coordinates,
                                            std::span<const double> control_weights, const RunControl& control = {},
                                            const CostSums* sums = nullptr, std::span<const Turn> turns = {});

/// Every neighbor known, whatever order made the map: figures of different methods can be compared.
[[nodiscard]] EnergyReport measure_energy(const SourceLevel& source, const DestinationLevel& destination,
                                          const Neighborhood& neighborhood, const CoordinateMap& coordinates,
                                          double coherence_share, std::span<const double> control_weights,
                                          const RunControl& control = {}, const CostSums* sums = nullptr,
                                          std::span<const Turn> turns = {});

}  // namespace patinate::transfer
