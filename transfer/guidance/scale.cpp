#include "transfer/guidance/scale.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::transfer {

namespace {

void check_length(const char* what, double length) {
  if (!(length > 0.0) || !std::isfinite(length))
    throw InvalidInput(std::string(what) + ": found " + number_text(length) + "; expected a length > 0");
}

}  // namespace

TransferScale choose_scale(std::optional<double> mm_per_unit, std::optional<double> pixel_mm,
                           double texel_in_mesh_units) {
  check_length("size of a texel", texel_in_mesh_units);
  if (mm_per_unit) check_length("unit of the mesh", *mm_per_unit);
  if (pixel_mm) check_length("size of a pixel", *pixel_mm);
  if (mm_per_unit && pixel_mm) return {*mm_per_unit, *pixel_mm, ScaleSource::Known};
  if (mm_per_unit) return {*mm_per_unit, texel_in_mesh_units * *mm_per_unit, ScaleSource::PixelAssumed};
  const double size = pixel_mm.value_or(1.0);
  return {size / texel_in_mesh_units, size, ScaleSource::MeshScaled};
}

int choose_resolution(int measured_with, double texel_mm, double pixel_mm, int num_tiles) {
  // Texels along an atlas that is chosen automatically (docs/transfer.md, Scale).
  constexpr double kLeast = 256.0, kMost = 4096.0;
  check_length("size of a texel", texel_mm);
  check_length("size of a pixel", pixel_mm);
  if (measured_with < 1 || num_tiles < 1) throw InvalidInput("resolution: texels and tiles must be at least 1");
  const double most = std::max(kLeast, std::floor(kMost / std::sqrt(static_cast<double>(num_tiles))));
  return static_cast<int>(std::clamp(std::round(measured_with * texel_mm / pixel_mm), kLeast, most));
}

}  // namespace patinate::transfer
