/// \file
/// Shares of named colors in a picture: what growers, conservators and inspectors count.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::analysis {

struct ColorClass {
  std::string name;
  std::array<double, 3> code{};  ///< sRGB, [0, 1].
};
/// "g1=#576a26". @throws InvalidInput
[[nodiscard]] ColorClass parse_color_class(const std::string& text);

/// Share of the pixels whose sRGB code is nearest to each class (Euclidean; the first of equally near ones). Codes, not
/// CIELAB: published class curves are counted so, and the figures then mean the same.
/// @param rgb  H x W x 3, linear. @param mask  H x W, 0 = outside; may be empty.
/// @throws InvalidInput if sizes differ, there is no class, or the mask covers nothing.
[[nodiscard]] std::vector<double> class_shares(const ImageF& rgb, const ImageU8& mask,
                                               const std::vector<ColorClass>& classes);

}  // namespace patinate::analysis
