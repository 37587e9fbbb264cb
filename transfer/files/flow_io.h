/// \file
/// How a history lies on a surface, kept beside the coordinates: channels `source.angle` and `source.mirror`.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/image/image.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

inline constexpr const char* kPatchChannels[2] = {"source.angle", "source.mirror"};  ///< Patch channels as FrameInUv.

/// For covered texels the frame in their UVs, turned as their pieces are: angle, and 1 where mirrored. 0 outside.
/// @param strip  A part of the atlas whose first texel is (x, y); its channels 2 and 3 are set.
/// @param place_of  As results have it.
void put_patch(ImageF& strip, int x, int y, const TexelMap& map, const FlowFrames& frames,
               const std::function<SourcePlace(TexelId t)>& place_of);

/// How a history lies on a surface.
struct LaidFlow {
  std::shared_ptr<const FlowFrames> frames = nullptr;  ///< Null: as the UVs run.
  std::vector<std::int16_t> turns = {};                ///< Turns of each texel, as SourcePlace's; empty: all 0.
};
/// Flow of a result that was written, by read_flow(): angles as floats.
[[nodiscard]] LaidFlow as_stored(const std::shared_ptr<const FlowFrames>& frames, std::span<const std::int16_t> turns,
                                 const TexelMap& map);
/// Flow of a finished transfer. Files keep frame and turn as one angle: a triangle's frame is that of its first texel.
/// @param map  Over its sheet. @throws IoError
[[nodiscard]] LaidFlow read_flow(const TransferManifest& manifest, const TexelMap& map);

}  // namespace patinate::transfer
