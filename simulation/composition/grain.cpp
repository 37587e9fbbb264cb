#include "simulation/composition/grain.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "patinate/controls/noise.h"

namespace patinate::simulation::composition {

namespace {

constexpr int kOctaves = 3;         ///< See docs/algorithms/composition.md, Grain.
constexpr double kFine = 8.0;       ///< The coarse half's length over the fine half's.
constexpr double kMinTexels = 2.0;  ///< Shorter waves cannot be shown.

}  // namespace

void Grain::set_lengths(const std::vector<double>& lengths_mm) {
  fields_.resize(lengths_mm.size());
  for (std::size_t m = 0; m < lengths_mm.size(); ++m) {
    Field& field = fields_[m];
    if (field.length == lengths_mm[m]) continue;
    field = Field{.length = lengths_mm[m]};
    if (field.length > 0.0) field.values = TileCache(places_->surface().grid().num_tiles(), kTile);
  }
}

double Grain::value(std::size_t material, TexelIndex t) const {
  double value = 0.5;
  values(material, std::span(&t, 1), std::span(&value, 1));
  return value;
}

void Grain::values(std::size_t material, std::span<const TexelIndex> texels, std::span<double> out) const {
  std::array<Vec3, kTile> at;
  std::array<double, kTile> coarse, fine;
  const SurfaceAtlas& surface = places_->surface();
  for (std::size_t n = 0; n < texels.size(); ++n) at[n] = places_->point(texels[n]);
  const double length = fields_[material].length, least = kMinTexels * surface.median_texel_size_mm();
  const auto seed = static_cast<std::int64_t>(2 * material + 1);
  const std::span<const Vec3> places = std::span(at).first(texels.size());
  noise_at(places, {.wavelength_mm = length, .octaves = kOctaves, .seed = seed}, least, coarse);
  noise_at(places, {.wavelength_mm = length / kFine, .octaves = kOctaves, .seed = seed + 1}, least, fine);
  constexpr double kHalf = 0.70710678118654752;  // Two of them are as strong as one.
  for (std::size_t n = 0; n < texels.size(); ++n) {
    out[n] =
        surface.is_covered(texels[n]) ? std::clamp(0.5 + kHalf * ((coarse[n] - 0.5) + (fine[n] - 0.5)), 0.0, 1.0) : 0.5;
  }
}

const std::uint8_t* Grain::tile(std::size_t material, TileIndex tile) {
  return fields_[material].values.tile(tile, [&](std::span<std::uint8_t> bytes) {
    std::array<TexelIndex, kTile> texels;
    std::array<double, kTile> noise;
    for (std::uint32_t l = 0; l < kTile; ++l) texels[l] = tile * kTile + l;
    values(material, texels, noise);
    for (std::size_t l = 0; l < kTile; ++l) bytes[l] = static_cast<std::uint8_t>(255.0 * noise[l] + 0.5);
  });
}

std::size_t Grain::memory() const {
  std::size_t bytes = 0;
  for (const Field& field : fields_) bytes += field.values.memory();
  return bytes;
}

}  // namespace patinate::simulation::composition
