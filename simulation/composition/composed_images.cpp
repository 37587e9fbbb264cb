#include <Eigen/Geometry>

#include "patinate/atlas/dilate.h"
#include "patinate/image/color.h"
#include "simulation/composition/composer_state.h"

namespace patinate::simulation {

using composition::kTile;

namespace {

/// write(texel, x, y) for every covered texel, and the gutters after that.
template <class T, class Write>
Image<T> filled(const SurfaceAtlas& surface, int channels, const Write& write) {
  const TileGrid& grid = surface.grid();
  Image<T> image(grid.width, grid.height, channels);
  ImageU8 coverage(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const TexelIndex t = grid.index(x, y);
      if (!surface.is_covered(t)) continue;
      coverage.at(x, y) = 255;
      write(t, image.pixel(x, y));
    }
  }
  dilate(image, coverage, -1);
  return image;
}

}  // namespace

std::span<const std::uint32_t> Composer::codes() const {
  state_->bring_back();
  return state_->codes;
}
std::span<const std::uint8_t> Composer::normals() const {
  state_->bring_back();
  return state_->normals;
}

double Composer::height_mm(TexelIndex t) const {
  state_->bring_back();
  return state_->heights.empty() ? 0.0 : state_->heights[t] / state_->quanta_per_mm;
}

std::array<double, 2> Composer::slopes(TexelIndex t) const {
  state_->bring_back();
  if (state_->heights.empty()) return {0.0, 0.0};
  composition::SlopeTile slopes;
  state_->slopes_of(TileGrid::tile_of(t), slopes);
  const double one = composition::kSlopeOne;
  return {slopes.along_t[t % kTile] / one, slopes.along_b[t % kTile] / one};
}

Vec3 Composer::perturbed_normal(TexelIndex t, const Vec3& normal,
                                const Eigen::Matrix<double, 3, 2>& mm_per_texel) const {
  const composition::TexelFrame frame = composition::texel_frame(mm_per_texel);
  const std::array<double, 2> slope = slopes(t);
  return (normal - slope[0] * frame.t - slope[1] * frame.b).normalized();
}

ImageU8 Composer::color_srgb8() const {
  state_->bring_back();
  return filled<std::uint8_t>(*state_->surface, 3, [&](TexelIndex t, std::span<std::uint8_t> out) {
    for (unsigned c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(state_->codes[t] >> (8 * c));
  });
}

ImageF Composer::color_linear() const {
  const ImageU8 codes = color_srgb8();
  std::array<float, 256> linear{};
  for (std::size_t c = 0; c < 256; ++c) linear[c] = linear_from_srgb(static_cast<float>(c) / 255.0f);
  ImageF image(codes.width(), codes.height(), 3);
  for (std::size_t i = 0; i < image.values().size(); ++i) image.values()[i] = linear[codes.values()[i]];
  return image;
}

ImageU8 Composer::specular8() const {
  state_->bring_back();
  return filled<std::uint8_t>(*state_->surface, 1, [&](TexelIndex t, std::span<std::uint8_t> out) {
    out[0] = static_cast<std::uint8_t>(state_->codes[t] >> 24);
  });
}

ImageU8 Composer::normal8() const {
  state_->bring_back();
  return filled<std::uint8_t>(*state_->surface, 3, [&](TexelIndex t, std::span<std::uint8_t> out) {
    const std::uint8_t* tile = &state_->normals[std::size_t{TileGrid::tile_of(t)} * 3 * kTile];
    for (std::size_t c = 0; c < 3; ++c) out[c] = tile[c * kTile + t % kTile];
  });
}

ImageF Composer::height_mm() const {
  return filled<float>(*state_->surface, 1,
                       [&](TexelIndex t, std::span<float> out) { out[0] = static_cast<float>(height_mm(t)); });
}

std::size_t Composer::memory() const {
  const State& s = *state_;
  return s.codes.size() * 4 + s.heights.size() * 4 + s.normals.size() + s.changed.memory() + s.stale_normals.memory() +
         s.base.memory() + s.coats.memory() + s.frames.memory() + s.grain.memory() + s.places.memory() +
         s.pictures.memory();
}

}  // namespace patinate::simulation
