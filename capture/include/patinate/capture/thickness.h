/// \file
/// Relative thickness of a layer from a photograph of the light that it lets through [OTMH 3.1], and the filter that
/// fills its cracks without blurring what surrounds them: the dominant mode of the local histogram.
#pragma once

#include <optional>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

inline constexpr double kModeFilterWindow_px = 20.0;  ///< Window if neither a caller nor the layer determines it.

/// Settings of mode_filter().
struct ModeFilterOptions {
  /// Gaussian window; >= 0.5. Larger than the widest crack. Not given: kModeFilterWindow_px; of a layer's thickness the
  /// window that the layer asks for (choose_layer_window()).
  std::optional<double> spatial_sigma_px = {};
  double range_sigma = 0.02;  ///< Histogram smoothing, in units of the image's value; > 0. At least one bin is used.
  int num_bins = 128;         ///< [16, 4096] over the image's range of values. Peaks are refined between bins.
};
void describe(OptionVisitor& v, ModeFilterOptions& o);

/// Dominant mode of the local histogram at every pixel [Kass and Solomon 2010, "Smoothed local histogram filters", sec.
/// 3].
///
/// out(p) = argmax_v sum_q G_spatial(|p - q|) G_range(v - in(q)). Unlike a bilateral filter it does not average across
/// gaps: where the paint varies by less than range_sigma in the window, a crack covering less than half of it changes
/// nothing. On sloping paint the share a crack may cover falls with slope x spatial_sigma_px / range_sigma.
///
/// Layers of the histogram are sampled spatial_sigma_px / 2.5 apart (linear weights in and out, whose variance is taken
/// off the Gaussian's), as the window passes no finer detail; they are made and used band by band.
/// @param in    H x W x 1, finite inside `mask`.
/// @param mask  H x W, 0 = ignored; may be empty.
/// @returns     H x W x 1; 0 outside the mask.
/// @throws InvalidInput if sizes differ, the mask is empty everywhere, a value is not finite, or an option is out of
/// range. Cost: O(H W num_bins), not rising with spatial_sigma_px; at most about 100 MB beside the images. Same bits
/// for any number of threads.
[[nodiscard]] ImageF mode_filter(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options = {},
                                 const RunControl& control = {});

/// mode_filter() with what each window's histogram says about its mode.
struct ModeFilterResult {
  ImageF values;  ///< mode_filter().
  /// Part of the window (weighted, inside the mask) within 2.5 range_sigma of the mode: [0, 1]. 1 where all is one
  /// value; below one half cracks, slopes or noise are more than what the mode stands for.
  ImageF share;
  /// Share of the second mode: the highest peak behind a valley from the first one; 0 if there is none.
  ImageF second_share;
  ImageF second_value;  ///< Value of the second mode, to a bin; the first mode's if there is no second.
};
/// Same contract as mode_filter(); about half as long again.
[[nodiscard]] ModeFilterResult mode_filter_shares(const ImageF& in, const ImageU8& mask,
                                                  const ModeFilterOptions& options = {},
                                                  const RunControl& control = {});

/// How transmitted light T becomes thickness. All three fall with T.
enum class ThicknessCurve {
  Reciprocal,   ///< 1 / T: a layer that scatters and absorbs little [Kubelka and Munk 1931: T = 1 / (1 + S d)].
  BeerLambert,  ///< -log T: a layer that absorbs and scatters little.
  Linear,       ///< 1 - T.
};

struct ThicknessOptions {
  ThicknessCurve curve = ThicknessCurve::Reciprocal;  ///< Why: docs/decisions/0001-thickness-from-transmission.md.
  ModeFilterOptions mode_filter = {};  ///< Its values are T: 1 = as bright as the blank, or the largest code.
  int num_refinements = 1;             ///< [0, 10]. See fill_cracks(); 0 keeps edges of the layer sharp.
  bool with_deviation = false;         ///< Fill ThicknessMap::deviation: three times the work.
};
void describe(OptionVisitor& v, ThicknessOptions& o);

/// Every pixel gets the value that the layer around it has, cracks or not: the mode filter, refined.
///
/// On sloping or curved paint the mode of a window is flat in patches, with steps between them. So the filter is run
/// again on what is left of `in` after the last result, blurred by 3/4 of spatial_sigma_px, is taken off; a crack
/// differs from that trend as much as before, the slope is gone. A narrower blur would follow grain and what lies
/// beside cracks. Steps of the layer itself are softened to 3/4 of spatial_sigma_px. Same contract as mode_filter().
[[nodiscard]] ImageF fill_cracks(const ImageF& in, const ImageU8& mask, const ThicknessOptions& options = {},
                                 const RunControl& control = {});

/// Holes are warned of from this part of a layer on: then ThicknessMap::low is theirs.
inline constexpr double kNamedHoleShare = 0.001;

/// What the windows of the mode filter say about a layer. Shares are of the layer, [0, 1]; light is T.
struct LayerEvidence {
  double share = 1.0;  ///< Part of its window that a pixel's commonest value covers, within 2.5 range_sigma; median.
  double weak_share = 0.0;  ///< Share of the layer where the most frequent value covers less than half and no second
                            ///< one competes: cracks, slope or noise prevail.
  double two_modes =
      0.0;  ///< Share of the layer where a second value covers at least half as much as the most frequent one.
  double noise = 0.0;  ///< Standard deviation of T between neighbors: the photograph's noise and the layer's grain.
  double hole_share = 0.0;     ///< Brighter places, apart by two modes, that the filter took for the layer.
  double hole_width_px = 0.0;  ///< Diameter of a circle of the largest one's area.
  double hole_light = 0.0;     ///< Median in them; 0 without holes.
  double brightest = 0.0;      ///< 99.9th percentile over the layer, cracks and all; 0 without holes.
  /// Window, tried, that fills them and leaves the rest of the layer as it is; 0 = none up to a sixth of its side.
  double filling_sigma_px = 0.0;
};

/// The window of the mode filter that a layer asks for, and how well it tells the layer.
struct LayerWindow {
  double sigma_px = kModeFilterWindow_px;
  bool is_chosen =
      false;       ///< True if the window was chosen from the layer; false if it was given, or the layer is too small.
  int gap_px = 0;  ///< Side of the squares that were left out: as wide as its cracks.
  /// Robust standard deviation of the light in these squares from what the filter foretells without them, over the
  /// light: how well the layer's trend is known where cracks are. 0 where it was not asked.
  double foretold_to = 0.0;
};

/// A chess board's black squares, as wide as the layer's cracks, are left out and foretold from the white ones by
/// fill_cracks(); the median over the squares of |median light - foretold| is what a window misses: the trend where it
/// is too wide, the layer itself where it is narrower than the cracks. From kModeFilterWindow_px on windows 1.5 times
/// narrower and wider are tried until the best has worse neighbors, from 6 px up to a sixth of the layer's side; of the
/// best and the next wider one the wider is taken if it is within the best one's standard error.
/// @param transmittance  T, H x W x 1, finite inside `mask`. @param mask  H x W; may be empty.
/// @returns the default window, not chosen, where there are fewer than 50 squares.
/// Cost: that of three to six fill_cracks().
[[nodiscard]] LayerWindow choose_layer_window(const ImageF& transmittance, const ImageU8& mask,
                                              const ThicknessOptions& options, const RunControl& control = {});

/// A thickness map; only ratios to other values of the same map mean something.
struct ThicknessMap {
  ImageF values;     ///< H x W x 1, finite; larger is thicker; 0 outside.
  double low = 0.0;  ///< Robust range: 0.1 % and 99.9 % percentiles inside the mask.
  double high = 0.0;
  ImageU8 known;  ///< H x W; 0 outside the mask and where the blank is black.
  LayerEvidence evidence = {};
  LayerWindow window = {};
  /// Standard deviation of `values` by noise and grain (layer_deviation.h); empty unless asked for.
  ImageF deviation = {};
};

/// T = photo / blank (or the photo), cracks filled by fill_cracks(), in the window that the layer asks for where none
/// is given, then the curve.
/// T is limited to [1/1024, 1]: less is not told from black. Where the blank is darker than 1/1024, T is unknown: such
/// pixels count as outside.
/// @param photo  H x W x 1, linear transmitted light, finite inside `mask`.
/// @param blank  The same without the layer; empty when there is none: T then has an unknown factor, which is taken
/// as 1.
/// @param mask   0 = outside; may be empty.
/// @throws InvalidInput if sizes differ, the mask or the blank leaves nothing, a value is not finite, or an option is
/// out of range.
[[nodiscard]] ThicknessMap thickness_from_transmission(const ImageF& photo, const ImageF& blank, const ImageU8& mask,
                                                       const ThicknessOptions& options = {},
                                                       const RunControl& control = {});

/// The curve at one T. @param transmittance  > 0.
[[nodiscard]] double thickness_of(double transmittance, ThicknessCurve curve);

}  // namespace patinate::capture
