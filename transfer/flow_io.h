/// \file
/// How a history lies on a surface, kept beside the coordinates: channels `source.angle` and `source.mirror`.
#pragma once

#include <memory>

#include "libcommon/atlas/texel_map.h"
#include "libcommon/image/image.h"
#include "transfer/transfer_io.h"

namespace patinate {

inline constexpr const char* kPatchChannels[2] = {"source.angle", "source.mirror"};  ///< As FrameInUv.

/// The coordinates and, of the covered texels, the frame in their UVs: angle, and 1 where mirrored. 0 outside.
/// @param coordinates  H x W x 2. @returns H x W x 4.
[[nodiscard]] ImageF with_patch(const ImageF& coordinates, const TexelMap& map, const FlowFrames& frames);

/// The frames of a finished transfer. @param map  Over its sheet. @returns nothing where its history lies as the UVs do. @throws IoError
[[nodiscard]] std::shared_ptr<const FlowFrames> read_flow_frames(const TransferManifest& manifest, const TexelMap& map);

}  // namespace patinate
