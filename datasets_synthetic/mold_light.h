/// \file
/// Photographs of the mold: what camera and lights make of it.
#pragma once

#include <vector>

#include "datasets_synthetic/mold.h"

namespace patinate::datasets {

/// The surface of a step in the scanner's frame, with normals: of the scan itself when neither scanner nor photographs
/// are noisy, else finer than photographs can tell.
[[nodiscard]] Mesh mold_surface(const Mold& mold, const MoldRig& rig, int step, const RunControl& control = {});

/// One step's photographs before the camera's response: linear, H x W x 3, not clipped.
struct MoldPhotos {
  std::vector<ImageF> lit;  ///< One a light; the ambient light is in them.
  ImageF dark;              ///< All lights off.
  std::vector<ImageU8>
      in_light;  ///< One a light: 255 where the pixel's center sees the object and the light reaches it.
};
/// A pixel is the mean of four rays; without noise it is what its center sees.
/// @param surface  mold_surface() of the step. Same bits for any number of threads.
[[nodiscard]] MoldPhotos mold_photos(const Mold& mold, const MoldRig& rig, int step, const Mesh& surface,
                                     const RunControl& control = {});

/// Object that the pixels of the reference step's photographs show; 0 beside it.
struct MoldView {
  ImageU8 mask;        ///< 255 where there is object.
  ImageF position_mm;  ///< x 3, in the reference step's scanner frame.
  ImageF normal;       ///< x 3.
  ImageF object_mm;    ///< x 2: x and y in the object's own frame.
};
[[nodiscard]] MoldView mold_view(const MoldRig& rig, const Mesh& reference_surface, const RunControl& control = {});

}  // namespace patinate::datasets
