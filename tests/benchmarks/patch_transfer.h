/// \file
/// Transfers of any size without a search, for benchmarks of what is looked up through them.
#pragma once

#include <filesystem>

#include "patinate/image/image.h"

namespace patinate::benchmarks {

inline constexpr int kPatchSource = 512;  ///< Side of the history, pixels.

/// Patches of 32 x 32 texels, each a piece of the source in its order, as transfers are. @param has_gutters  Each
/// fourth column of patches is no chart.
[[nodiscard]] ImageF patch_coordinates(int side, bool has_gutters);

/// FOLDER/history, of two frames, and FOLDER/transfer, whose coordinates are patches with gutters.
/// @param has_maps  Frames have every map beside color.
void write_patch_transfer(const std::filesystem::path& folder, int side, bool has_maps = false);

/// Gives every frame of a history on disk gloss, normals, height, metalness and tint: 10 channels.
void add_material_maps(const std::filesystem::path& history);

}  // namespace patinate::benchmarks
