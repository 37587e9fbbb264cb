/// \file
/// A material's look as the integers that the kernels use.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/image/image.h"
#include "patinate/simulation/scene.h"
#include "simulation/composition/compose_kernel.h"

namespace patinate::simulation::composition {

/// Linear values of the 256 sRGB codes, 1 = 65535.
[[nodiscard]] const std::array<std::uint16_t, 256>& linear16_of_srgb8();
/// sRGB codes of linear values of 16 bit, by value >> kSrgbShift. Gives every code back: srgb8[linear16[c] >>
/// kSrgbShift] = c.
[[nodiscard]] const std::array<std::uint8_t, kSrgbSize>& srgb8_of_linear16();
/// The sRGB codes of a linear color, of which all colors are composed; 0 for what is not finite.
[[nodiscard]] std::array<std::uint8_t, 3> srgb8_of(const Vec3& linear);

/// A picture of a material, linear, 1 = 65535: three planes of H x W.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint16_t> planes;

  [[nodiscard]] bool empty() const { return planes.empty(); }
  /// 3 x 64 values of a tile: texel (x, y) of the atlas shows pixel (x mod width, y mod height).
  void read_tile(int x0, int y0, std::uint16_t* out) const;
};
[[nodiscard]] Picture make_picture(const ImageF& linear);

/// @param quanta_per_mm  Height quanta, kHeightQuanta in a median texel.
/// @throws InvalidInput naming the first value that is not finite or out of the range that MaterialAppearance gives.
[[nodiscard]] QuantizedAppearance quantize(const MaterialAppearance& look, double quanta_per_mm,
                                           std::uint32_t noise_key);
/// Key of material `index`: fixed, so that appearance parameters can change without the noise.
[[nodiscard]] std::uint32_t noise_key(int index);

}  // namespace patinate::simulation::composition
