/// \file
/// Cracks that a layer has at the start, from a map of them.
#pragma once

#include "patinate/image/image.h"
#include "patinate/simulation/layer_atlas.h"

namespace patinate::simulation {

/// Cracks along the center lines of what is marked, as they are connected there, so that widths do not count; lines go
/// on to the borders of charts. Where a line ends, a tip goes on from it as those of grown cracks do. Texels without
/// the layer stay as they are. @param marked  As the atlas's pixels, not 0 = a crack. LayerAtlas::renew_tops() is the
/// caller's.
void lay_cracks(const ImageU8& marked, int layer, LayerAtlas& layers);

}  // namespace patinate::simulation
