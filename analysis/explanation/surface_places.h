/// \file
/// Places that stand for equal parts of a surface, on its atlas.
#pragma once

#include <vector>

#include "patinate/atlas/texel_map.h"

namespace patinate::analysis {

struct SurfacePlaces {
  std::vector<TexelId> texels;  ///< Ascending.
  std::vector<Vec3> positions_mm;
  double area_mm2 = 0.0;  ///< Area of all covered texels inside the mask.

  /// @param image  H x W x 1 on the atlas.
  [[nodiscard]] std::vector<double> values_of(const ImageF& image) const;
};

/// Every so many square millimeters of the covered texels, row by row, one place: charts that are magnified in the
/// atlas get no more than their share.
/// @param mask  0 = not looked at; may be empty. @param count  Of places, > 0; fewer where there are fewer texels.
[[nodiscard]] SurfacePlaces surface_places(const TexelMap& map, const ImageU8& mask, int count);

}  // namespace patinate::analysis
