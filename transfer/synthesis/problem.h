/// \file
/// What texture synthesis is given, the energy that it lowers, and how that energy is measured afterwards.
///
/// A coordinate map assigns to every covered texel t a source pixel s(t). Its energy is the mean over texels of
///
///     a * C(t) + (1 - a) * K(t)
///     C(t) = sum_k w_k |A(s(n_k(t))) - A(s(t) + o_k)|^2 / (sum_k w_k * 2 var A)      coherence, all frames at once
///     K(t) = sum_c g_c (P_c(s(t)) - Q_c(t))^2 / (2 var P_c)                          control mismatch
///
/// with A the appearance, o_k the offsets of the neighbourhood, n_k(t) the texel at o_k on the surface, P the history's controls and
/// Q the destination's, mapped into P's values; g sums to 1. Both parts are 1 for independent random texels.
/// [Efros and Leung 1999; Efros and Freeman 2001, sec. 4]
///
/// Everything that decides is an integer: equal input gives equal coordinates on every machine.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "libcommon/atlas/texel_map.h"
#include "libcommon/atlas/texel_neighborhood.h"
#include "libcommon/core/run_control.h"
#include "transfer/appearance/appearance_space.h"

namespace patinate {

inline constexpr int kControlSteps = 4095;  ///< Controls are integers in [0, 4095].

using ControlImage = Image<std::uint16_t>;  ///< H x W x C.

struct Offset {
  int x = 0, y = 0;
};

/// Neighbours that are compared: a disc around the texel (without it), with weights that fall outward.
struct Neighborhood {
  std::vector<Offset> offsets;
  std::vector<std::int16_t> weights;  ///< > 0; at most 16 each, 1024 in all.
  int radius_px = 0;

  /// @param radius_px  [1, 5]
  [[nodiscard]] static Neighborhood square(int radius_px);
};

/// The history at one level: what can be copied.
struct SourceLevel {
  AppearanceImage appearance;
  ControlImage controls;
  std::vector<std::uint8_t> is_usable;   ///< Per pixel: its whole neighbourhood lies in the mask.
  std::vector<std::int32_t> usable;      ///< The usable pixels, ascending by first control, then by index.
  double appearance_variance = 1.0;
  std::vector<double> control_variances;

  [[nodiscard]] int width() const { return appearance.width(); }
  [[nodiscard]] int height() const { return appearance.height(); }
  /// Usable pixels of similar control values, never empty. One control: those within `tolerance` of the target, or the
  /// nearest. Several: those of the target's cell in a grid over the first two, or of the nearest cell that holds any.
  [[nodiscard]] std::span<const std::int32_t> similar(std::span<const std::uint16_t> target, int tolerance) const;
  /// Grid over the first two controls: `grid_pixels[grid_begin[c] .. grid_begin[c + 1])` of the cell that `grid_cell` leads to.
  static constexpr int kGridSide = 64;
  std::vector<std::int32_t> grid_cell, grid_begin, grid_pixels;
};

/// @throws InvalidInput if no pixel is usable.
[[nodiscard]] SourceLevel make_source_level(AppearanceImage appearance, ControlImage controls, const ImageU8& mask,
                                            double appearance_variance, const Neighborhood& neighborhood);

/// The surface at one level: what is to be covered.
struct DestinationLevel {
  std::shared_ptr<const TexelMap> map;
  std::shared_ptr<const TexelNeighborhood> neighbors;
  ControlImage controls;                 ///< Mapped into the source's values.
  std::vector<TexelId> texels;           ///< The covered ones, ascending.

  [[nodiscard]] std::span<const std::uint16_t> target(TexelId t) const {
    const auto n = static_cast<std::size_t>(controls.channels());
    return controls.values().subspan(static_cast<std::size_t>(t) * n, n);
  }
};

/// @param source_pixel_mm  Surface length of one source pixel of this level.
[[nodiscard]] DestinationLevel make_destination_level(std::shared_ptr<const TexelMap> map, ControlImage controls,
                                                      const Neighborhood& neighborhood, double source_pixel_mm,
                                                      const RunControl& control = {});

/// Source pixel (y * width + x) per texel of the atlas; -1 = none (yet).
using CoordinateMap = std::vector<std::int32_t>;

/// Weights of the energy as integers: cost = coherence * coherence_scale(sum of weights) + sum_c difference_c^2 * control_scale[c].
struct EnergyScale {
  double coherence_share = 0.5;          ///< a
  double appearance_variance = 1.0;
  std::vector<std::int64_t> control_scale;

  [[nodiscard]] static EnergyScale make(const SourceLevel& source, double coherence_share, std::span<const double> control_weights);
  [[nodiscard]] std::int64_t coherence_scale(int sum_of_weights) const;
  /// Cost 1.0 as an integer.
  static constexpr double kOne = 1099511627776.0;  // 2^40
};

/// The cost of giving source pixels to one texel, its known neighbours held fixed.
class TexelCost {
 public:
  TexelCost(const SourceLevel& source, const DestinationLevel& destination, const Neighborhood& neighborhood);

  /// Gathers the neighbours that have coordinates. O(neighbourhood).
  void prepare(TexelId texel, const CoordinateMap& coordinates, const EnergyScale& scale);
  /// Of the whole energy. Stops early and returns something >= bound when it cannot be below `bound`.
  [[nodiscard]] std::int64_t total(std::int32_t source_pixel, std::int64_t bound) const;
  [[nodiscard]] std::int64_t control(std::int32_t source_pixel) const;
  [[nodiscard]] std::int64_t coherence(std::int32_t source_pixel) const;
  [[nodiscard]] int num_known() const { return num_known_; }
  /// Texel at neighbour k, -1 where the surface ends.
  [[nodiscard]] TexelId neighbor(std::size_t k) const { return neighbors_[k]; }

 private:
  const SourceLevel& source_;
  const DestinationLevel& destination_;
  const Neighborhood& neighborhood_;
  std::vector<TexelId> neighbors_;
  std::vector<std::int16_t> appearance_;   ///< Known neighbours', packed.
  std::vector<std::int16_t> weight_;
  std::vector<std::int32_t> delta_;        ///< Their offset in the source, in values.
  std::span<const std::uint16_t> target_;
  std::vector<std::int64_t> control_scale_;
  std::int64_t coherence_scale_ = 0;
  int num_known_ = 0;
};

/// The figures that transfer.json reports.
struct EnergyReport {
  double energy = 0.0;          ///< a C + (1 - a) K, mean over texels.
  double coherence = 0.0;       ///< C, mean.
  double control_mismatch = 0.0;  ///< K, mean.
  double control_error_mean = 0.0;  ///< Mean |P - Q| of the first control, in [0, 1].
  double control_error_p95 = 0.0;
  double coherent_share = 0.0;  ///< Adjacent texel pairs with s(t + d) - s(t) = d.
  double used_share = 0.0;      ///< Usable source pixels that appear in the result.
};

/// Every neighbour known, whatever order made the map: figures of different methods can be compared.
[[nodiscard]] EnergyReport measure_energy(const SourceLevel& source, const DestinationLevel& destination,
                                          const Neighborhood& neighborhood, const CoordinateMap& coordinates,
                                          double coherence_share, std::span<const double> control_weights,
                                          const RunControl& control = {});

}  // namespace patinate
