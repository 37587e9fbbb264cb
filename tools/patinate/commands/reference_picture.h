/// \file
/// Pixels of a reference, and which of them shows each texel of an atlas.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/geometry/camera.h"
#include "patinate/image/image.h"

namespace patinate::cli {

struct ReferencePicture {
  ImageF values;  ///< H x W x 1: how aged; any unit.
  ImageF color;   ///< H x W x 3, linear.
  ImageU8 mask;   ///< 0 = not known; may be empty.
};

/// For every texel, the pixel y * width + x that shows it; -1 = none.
using PixelOfTexel = std::vector<std::int64_t>;

/// A picture of the atlas, whatever its size.
[[nodiscard]] PixelOfTexel pixels_on_uvs(const TexelMap& map, int width, int height);
/// The pixel whose surface point is nearest: within two of the larger of pixel and texel, and of a normal that differs
/// by less than 60 degrees.
/// @param position  H x W x 3, mm. @param normal  H x W x 3; 0 = no surface; may be empty.
[[nodiscard]] PixelOfTexel pixels_at_positions(const TexelMap& map, const ImageF& position, const ImageF& normal,
                                               const ImageU8& mask, const RunControl& control);
/// Texels that a camera sees: those that nothing hides, at less than 75 degrees.
/// @param camera  In mm.
[[nodiscard]] PixelOfTexel pixels_in_view(const TexelMap& map, const Camera& camera, const RunControl& control);

/// The values "luminance", "saturation" (0 gray to 1 pure) of linear color. @throws InvalidInput for other names.
[[nodiscard]] ImageF color_channel(const ImageF& color, const std::string& channel);
/// CIEDE2000 of every pixel. @param a,b  Linear, same size.
[[nodiscard]] ImageF color_change(const ImageF& a, const ImageF& b);

}  // namespace patinate::cli
