/// \file
/// Pictures of materials, laid over surfaces in mm: docs/algorithms/composition.md.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "patinate/simulation/scene.h"
#include "simulation/composition/quantized_appearance.h"
#include "simulation/composition/texel_places.h"
#include "simulation/composition/tile_cache.h"

namespace patinate::simulation::composition {

/// A picture seen on a surface from the side that each place faces, along x, y and z, repeated, its top to the world's
/// y (seen along y: to -z). Where two sides meet they are blended so that the picture keeps its contrast: deviations
/// from its mean over the root of the sum of squared weights [Heitz and Neyret 2018, sec. 3]. Its pixels are averaged
/// over a texel, so that a finer atlas is sharper and not another.
class LaidPicture {
 public:
  /// @param source    With a picture and its width in mm, > 0. @param texel_mm  > 0.
  LaidPicture(const ColorSource& source, double texel_mm);
  /// Linear, [0, 1] where the picture is. @param normal  Unit, or 0: as if all sides were faced alike.
  [[nodiscard]] Vec3 color(const Vec3& point_mm, const Vec3& normal) const;

 private:
  /// @param x_mm,y_mm  From the picture's upper left corner, repeated.
  [[nodiscard]] Vec3 sample(double x_mm, double y_mm) const;

  double width_mm_, height_mm_;
  ImageF image_;  ///< Image of pixels no smaller than a texel.
  Vec3 mean_{0, 0, 0};
};

/// The pictures of all materials of a scene.
class MaterialPictures {
 public:
  /// @param places  Outlives this.
  explicit MaterialPictures(const TexelPlaces& places) : places_(&places) {}
  /// Keeps what is known where a picture stays.
  void set(std::span<const MaterialAppearance> looks);

  [[nodiscard]] bool has(std::size_t material) const { return !fields_[material].image.empty(); }
  /// 3 x 64 values of a tile, linear, 1 = 65535.
  void read_tile(std::size_t material, TileIndex tile, std::uint16_t* out);
  [[nodiscard]] std::size_t memory() const;

 private:
  struct Field {
    ImageF image = {};
    double image_mm = 0.0;
    Picture by_texel = {};                  ///< Without a width: a pixel a texel.
    std::optional<LaidPicture> in_mm = {};  ///< With one.
    TileCache codes = {};                   ///< Codes of it: sRGB codes, 3 planes.
  };

  const TexelPlaces* places_;
  std::vector<Field> fields_;
};

}  // namespace patinate::simulation::composition
