/// \file
/// Pictures in which nothing is on but what a test turns on.
#pragma once

#include "patinate/image/image.h"
#include "patinate/output/render.h"

namespace patinate::testing_support {

inline const ImageF kWhite(1, 1, 3, 1.0f);

/// No light, no gloss, no ground, no occlusion, before white. @param side  Of the picture, px.
inline RenderOptions bare(int side, int samples) {
  RenderOptions o;
  o.width = o.height = side;
  o.samples = samples;
  o.light = o.ambient = o.ambient_gradient = o.specular = o.light_size_deg = 0.0;
  o.occlusion_samples = 0;
  o.ground = false;
  o.backdrop = Backdrop::White;
  return o;
}

}  // namespace patinate::testing_support
