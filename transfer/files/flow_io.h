/// \file
/// How a history lies on a surface, kept beside the coordinates: channels `source.angle` and `source.mirror`.
#pragma once

#include <memory>

#include "patinate/atlas/texel_map.h"
#include "patinate/image/image.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

inline constexpr const char* kPatchChannels[2] = {"source.angle", "source.mirror"};  ///< As FrameInUv.

/// Of the covered texels the frame in their UVs: angle, and 1 where mirrored. 0 outside.
/// @param strip  A part of the atlas whose first texel is (x, y); its channels 2 and 3 are set.
void put_patch(ImageF& strip, int x, int y, const TexelMap& map, const FlowFrames& frames);

/// Sets the frames of the triangles that have texels in a tile. @throws IoError
void read_flow_tile(const TransferManifest& manifest, const TexelMap& map, int tile, FlowFrames& frames);

/// What read_flow_frames() gives of frames that were written: angles as floats. Nothing of nothing.
[[nodiscard]] std::shared_ptr<const FlowFrames> as_stored(const std::shared_ptr<const FlowFrames>& frames,
                                                          const TexelMap& map);
/// The frames of a finished transfer. @param map  Over its sheet. @returns nothing where its history lies as the UVs
/// do. @throws IoError
[[nodiscard]] std::shared_ptr<const FlowFrames> read_flow_frames(const TransferManifest& manifest, const TexelMap& map);

}  // namespace patinate::transfer
