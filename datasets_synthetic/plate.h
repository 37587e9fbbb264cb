/// \file
/// A flat plate under a fixed camera and one near lamp, which stands still or moves from photograph to photograph: its
/// polish becomes rougher while patches of patina grow on it. The truth for gloss that is measured without a rig of
/// lamps.
#pragma once

#include <cstdint>

#include "datasets_synthetic/smooth_noise.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/light.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// Settings of GlossyPlate.
struct PlateOptions {
  int size = 192;               ///< Pixels along a side; [32, 2048].
  double side_mm = 128.0;       ///< Side of the plate; > 0. Lamp and camera stand as far off as their numbers say.
  int num_frames = 16;          ///< [2, 10000].
  double interval_h = 1.0;      ///< Hours between photographs; > 0.
  double roughness = 0.35;      ///< Roughness of the polish at the start; [0.15, 0.9].
  double roughness_end = 0.55;  ///< And at the end.
  double specular = 0.05;       ///< F0 of the polish, a lacquer; [0, 1]. Not of metal.
  bool metal = false;           ///< Bare copper instead of a lacquer: no albedo, F0 of its color.
  bool moving = false;          ///< The lamp stands elsewhere at every photograph.
  double lamp_x_mm = -70.0;     ///< Where the lamp stands at the first photograph: right of the plate's middle,
  double lamp_y_mm = 50.0;      ///< above it in the photograph,
  double lamp_z_mm = 380.0;     ///< and over the plate; > 0.
  double texture = 1.0;         ///< How uneven colors are; [0, 2].
  double noise = 0.004;         ///< Standard deviation of photographs, in 8-bit sRGB codes / 255; [0, 0.5].
  std::int64_t seed = 1;        ///< >= 0.
};
void describe(OptionVisitor& v, PlateOptions& o);

/// Appearance of a place at a time.
struct PlateLook {
  Vec3 albedo = Vec3::Zero();
  double patina = 0.0;            ///< Share of the place that it covers, [0, 1].
  Vec3 polish_f0 = Vec3::Zero();  ///< Reflectance of the polish that is not covered, not weighted by its share.
  double polish_roughness = 0.0;
  static constexpr double kPatinaF0 = 0.04, kPatinaRoughness = 0.7;
};

/// The plate and its truth; x right, y down, in pixels. Immutable; safe to use from several threads.
class GlossyPlate {
 public:
  /// @throws InvalidInput if an option is out of range.
  explicit GlossyPlate(const PlateOptions& options);

  [[nodiscard]] PlateLook look(double x, double y, int frame) const;
  /// In the plate's frame, mm: x right, y up, z to the camera, the origin in the plate's middle.
  [[nodiscard]] Vec3 position(double x, double y) const;
  [[nodiscard]] Vec3 camera() const { return {20.0, -10.0, 450.0}; }
  /// At the given place; moving, around the middle by the golden angle from photograph to photograph.
  [[nodiscard]] Light lamp(int frame) const;
  [[nodiscard]] const PlateOptions& options() const { return options_; }

 private:
  PlateOptions options_;
  double texel_mm_;
  SmoothNoise broad_, grain_, patches_;
};

/// Linear photograph without noise, not clipped: albedo / pi and GGX lobes with the energy of further scattering, as
/// `render` draws them, times what the lamp sheds, intensity / d^2. Pixel centers alone. Same bits for any number of
/// threads.
[[nodiscard]] ImageF plate_photo(const GlossyPlate& plate, int frame, const RunControl& control = {});

}  // namespace patinate::datasets
