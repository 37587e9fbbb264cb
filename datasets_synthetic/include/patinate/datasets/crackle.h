/// \file
/// Paint crackle with a known thickness: a painted glass plate that dries, photographed over time in reflected light
/// and, at the end, on a back-light.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// How light that passes falls with thickness h: exp(-a h), 1 / (1 + a h), or 1 - a h.
enum class TransmissionLaw { BeerLambert, Reciprocal, Linear };

/// Settings of crackle(). Lengths on the plate are in mm; the plate is `width` x `height` pixels of `texel_size_mm`.
struct CrackleOptions {
  int width = 512;                 ///< [32, 8192].
  int height = 512;                ///< [32, 8192].
  double texel_size_mm = 0.12;     ///< > 0.
  int num_frames = 24;             ///< [2, 10000].
  double interval_s = 7.5;         ///< Between frames; > 0.
  double thickness_min_mm = 0.10;  ///< > 0.
  double thickness_max_mm = 0.50;  ///< > thickness_min_mm.
  std::string thickness_map = "";  ///< Of plan_crackle(): an image from 0, thinnest, to 1; "" = drawn from the seed.
  double spacing_per_thickness = 17.0;  ///< Crack spacing over thickness; cells are this large at most; > 0.
  double strain = 0.055;                ///< Final width of a crack over the local spacing; [0, 0.5].
  double grain = 0.35;                  ///< How much first cracks follow the plate's grain (vertical); [0, 1].
  double simultaneity = 1.0;  ///< Degree to which thin paint cracks all at once, with junctions of 120 degrees; [0, 1].
  double yellowing = 0.10;    ///< Share of blue that the paint loses until the end; [0, 1].
  TransmissionLaw law = TransmissionLaw::Reciprocal;
  double absorption_per_mm = 5.0;  ///< a; > 0. For Linear a thickness_max_mm < 1.
  double noise = 0.006;            ///< Standard deviation of photographs, in 8-bit sRGB codes / 255; [0, 0.5].
  std::int64_t seed = 1;           ///< >= 0.
};

void describe(OptionVisitor& v, CrackleOptions& o);
/// Ranges, and what must hold between options. @throws InvalidInput
void check_crackle(const CrackleOptions& options);

/// One crack: a polyline, the later ones ending on earlier ones.
struct Crack {
  std::vector<std::array<double, 2>> points_px;  ///< About half a pixel apart.
  int origin = 0;                                ///< Index of the point where it began.
  int level = 0;             ///< 0 = ends on the border only; else 1 + the highest level it ends on.
  bool is_dead_end = false;  ///< A hairline that starts on a crack and stops inside a cell.
  double start_s = 0.0;      ///< When it began.
};

/// The plate and its truth. Same bits for any number of threads.
struct CrackleDataset {
  CrackleOptions options;
  ImageF thickness_mm;        ///< H x W.
  std::vector<Crack> cracks;  ///< In the order in which they began.
  ImageF opening_s;           ///< H x W: time from which the pixel's center lies in a crack; -1 = never.
  Image<std::int32_t> cells;  ///< H x W: piece of paint at the end, from 1; 0 on cracks (a band of 1.5 px at least).
  int num_cells = 0;
  /// The effect of one crack on one pixel near it.
  struct Influence {
    std::int32_t pixel = 0;    ///< y * width + x.
    float distance_px = 0.0f;  ///< From the center line.
    float width_px = 0.0f;     ///< Final width there.
    float start_s = 0.0f;      ///< When the crack's tip passed.
  };
  std::vector<Influence> influences;  ///< By pixel.
  ImageF paint;                       ///< H x W x 3: linear albedo of the fresh paint.
  ImageF backlight;                   ///< H x W: the light-box itself, linear.

  [[nodiscard]] double duration_s() const { return options.interval_s * (options.num_frames - 1); }
};

/// Makes the plate.
///
/// Cracks come one after another [Bohn, Pauchard, Couder 2005, "Hierarchical crack pattern as formed by successive
/// domain divisions"]: each begins where the distance to older cracks is largest compared with the spacing that the
/// local thickness asks for (spacing proportional to thickness), runs across its cell the short way, turns to meet the
/// older crack at a right angle, and stops there. Where the paint is thin cracks come at once, so that none of those
/// that meet is the older one: junctions move to where three equal pulls balance, at 120 degrees [Goehring, Conroy,
/// Akhter, Clegg, Routh 2010, "Evolution of mud-crack patterns during repeated drying cycles"], and cracks between them
/// are wavy. Thin paint has small cells, thick paint large ones with straight sides; thin paint begins first. A crack
/// opens as width (1 - exp(-(t - start) / tau)), never closing. Cost: about 1 s for 512 x 512.
/// @param thickness  H x W in [0, 1], from the thinnest to the thickest paint; empty: drawn from the seed.
/// @throws InvalidInput
[[nodiscard]] CrackleDataset crackle(const CrackleOptions& options, const RunControl& control = {},
                                     const ImageF& thickness = {});

/// Width of a crack at a time, as a share of its final one: 1 - exp(-(t - start) / tau), tau = a quarter of the
/// duration.
[[nodiscard]] double crack_opening(const CrackleDataset& dataset, double time_s, double start_s);
/// Share of every pixel that is crack at a time, [0, 1], anti-aliased over one pixel.
[[nodiscard]] ImageF crack_share(const CrackleDataset& dataset, double time_s);
/// Light through h mm of paint, (0, 1].
[[nodiscard]] double transmittance(const CrackleOptions& options, double thickness_mm);
/// Reflected light at a time, linear RGB, without noise.
[[nodiscard]] ImageF reflected(const CrackleDataset& dataset, double time_s, const RunControl& control = {});
/// Transmitted light at the end, linear gray, without noise: backlight * (share + (1 - share) * transmittance).
[[nodiscard]] ImageF transmitted(const CrackleDataset& dataset);
/// Simulates a camera: makes 8-bit sRGB codes with noise from a linear image; the noise depends on (seed, picture).
[[nodiscard]] ImageU8 photograph(const ImageF& linear, double noise, std::int64_t seed, int picture);

}  // namespace patinate::datasets
