/// \file
/// A painted image as control map.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "patinate/atlas/sheet.h"
#include "patinate/controls/control_map.h"

namespace patinate {

/// An image laid over the atlas by UV: the whole image spans [0, 1]^2; bilinear when its size differs from the atlas'.
/// Values in [0, 1] stay as they are; if any is outside, they are normalized by their least and greatest, kept as low
/// and high.
/// @param image  h x w x 1, finite.
/// @throws InvalidInput if it is empty, has several channels, or holds NaN or infinity.
[[nodiscard]] ControlMap image_map(const TexelMap& map, const ImageF& image);

/// Images laid over the tiles of a sheet, bilinear when their size differs: one for all of them, or one each.
/// @param images  h x w x 1. @throws InvalidInput if one is empty, has several channels, or their number is another.
[[nodiscard]] ImageF lay_over_tiles(const Sheet& sheet, std::span<const ImageF> images);

/// The files that stand for a map over tiles: `path` itself if it is there and its name has no `<UDIM>`, else one a
/// tile, as tile_path() names them.
[[nodiscard]] std::vector<std::filesystem::path> tile_map_files(const std::filesystem::path& path,
                                                                const std::vector<std::string>& tile_names);

}  // namespace patinate
