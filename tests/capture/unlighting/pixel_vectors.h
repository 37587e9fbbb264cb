/// \file
/// Vectors in the pixels of images.
#pragma once

#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::testing_support {

/// Puts as many components as the image has channels.
inline void put(ImageF& image, int x, int y, const Vec3& v) {
  for (int c = 0; c < image.channels(); ++c) image.at(x, y, c) = static_cast<float>(v[c]);
}

[[nodiscard]] inline Vec3 vector_at(const ImageF& image, int x, int y) {
  return {static_cast<double>(image.at(x, y, 0)), static_cast<double>(image.at(x, y, 1)),
          static_cast<double>(image.at(x, y, 2))};
}

}  // namespace patinate::testing_support
