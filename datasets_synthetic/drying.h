/// \file
/// A wet patch on stone that dries: first its film of water goes, soonest at the rim or where it is thin, then its
/// pores, so that it turns from dark and glossy to light and dull.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "datasets_synthetic/smooth_noise.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// Where the film goes first.
enum class DryingOrder {
  Rim,       ///< An even film; water leaves fastest at the rim.
  Thickness  ///< Puddles; water leaves evenly, so that the film goes first where it is thin.
};
inline constexpr std::array<std::string_view, 2> kDryingOrderNames{"rim", "thickness"};

/// Settings of DryingPatch.
struct DryingOptions {
  int width = 320;             ///< Width of the photographs; [32, 4096].
  int height = 256;            ///< [32, 4096].
  double texel_size_mm = 0.5;  ///< Length on the stone that a pixel shows; > 0.
  int num_frames = 30;         ///< [2, 10000].
  double interval_min = 5.0;   ///< Minutes between photographs; > 0.
  DryingOrder order = DryingOrder::Rim;
  double film_mm = 0.25;           ///< Water on the stone, where there is most; > 0.
  double evaporation_mm_h = 0.15;  ///< How fast it leaves; with `rim` in the middle of the patch; > 0.
  double pores_min = 15.0;         ///< Time constant in which pores dry once the film is gone; > 0.
  double texture = 1.0;            ///< How uneven the stone's color is; 0 = one color; [0, 2].
  double gloss = 1.0;              ///< The lamp's reflection in the film, times that of water; 0 = none; [0, 10].
  double noise = 0.006;            ///< Standard deviation of photographs, in 8-bit sRGB codes / 255; [0, 0.5].
  std::int64_t seed = 1;           ///< >= 0.

  [[nodiscard]] double duration_min() const { return interval_min * (num_frames - 1); }
};
void describe(OptionVisitor& v, DryingOptions& o);

/// Appearance of a place at a time.
struct DryingLook {
  Vec3 albedo = Vec3::Zero();
  double wetness = 0.0;    ///< Share of the pores that hold water; [0, 1].
  double film = 0.0;       ///< Share of the place that is under a film; [0, 1].
  double specular = 0.0;   ///< F0 of the mirror.
  double roughness = 1.0;  ///< GGX.
};

/// Albedo of a surface of albedo `dry` in [0, 1] under a film of water, without the light that the film reflects:
/// (1 - r)(1 - p) dry / (1 - p dry), where r = 0.066 of diffuse light is reflected on the way in and p = 1 - (1 - r) /
/// n^2 on the way out, n = 1.333 [Lekner and Dorf 1988, "Why some things are darker when wet"].
[[nodiscard]] double wet_albedo(double dry);

/// The patch and its truth; x right, y down, in pixels. Immutable; safe to use from several threads.
class DryingPatch {
 public:
  /// @throws InvalidInput if an option is out of range.
  explicit DryingPatch(const DryingOptions& options);

  /// How far inside the patch a place is: 1 in its middle, 0 at its rim, less outside.
  [[nodiscard]] double depth(double x, double y) const;
  /// Water on it at the start, mm; 0 outside.
  [[nodiscard]] double film_mm(double x, double y) const;
  /// When the film is gone, min; -1 outside. Film over evaporation; with DryingOrder::Rim the latter grows toward the
  /// rim as depth^(-1/2), as at the edge of a flat drop [Deegan et al. 2000, "Contact line deposits in an evaporating
  /// drop"].
  [[nodiscard]] double onset_min(double x, double y) const;
  /// The stone's albedo where it is dry.
  [[nodiscard]] Vec3 dry_albedo(double x, double y) const;
  /// Unit, z toward the camera: the film is rippled by what lies below it.
  [[nodiscard]] Vec3 film_normal(double x, double y) const;
  /// Wetness is that of the start, which rises within 3 % of the patch's radius from its rim, times exp(-(t - onset) /
  /// pores_min) after onset; albedo is the mean of dry_albedo() and its wet_albedo() by wetness. The mirror is that of
  /// water, 0.02, by the share under the film, which grains pierce from 0.04 mm on, and its roughness goes from 0.22
  /// to 0.9.
  [[nodiscard]] DryingLook look(double x, double y, double time_min) const;
  [[nodiscard]] const DryingOptions& options() const { return options_; }

 private:
  DryingOptions options_;
  double radius_;  ///< Radius of the patch, pixels.
  SmoothNoise outline_, ragged_, puddles_, stone_, grain_, ripples_;
};

/// Linear photograph from above, without noise: albedo in even light, and a lamp's reflection in what is under the
/// film. Pixel centers alone. Same bits for any number of threads.
[[nodiscard]] ImageF drying_photo(const DryingPatch& patch, double time_min, const RunControl& control = {});

}  // namespace patinate::datasets
