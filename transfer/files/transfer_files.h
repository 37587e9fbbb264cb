/// \file
/// The files of a transfer folder one by one, for who makes them tile by tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

inline constexpr const char* kSourceMaskFile = "source_mask.png";

[[nodiscard]] UvLayoutRule rule_of(const TransferTask& task);
/// Of a control: relative to the folder, with `<UDIM>` where there are tiles.
[[nodiscard]] std::string control_file(const TransferTask& task, std::size_t index);
/// Relative to the folder. @param tile  Of the sheet.
[[nodiscard]] std::filesystem::path control_tile_file(const TransferTask& task, std::size_t control, int tile);
[[nodiscard]] std::filesystem::path coordinate_tile_file(const TransferTask& task, int tile);

/// Puts the part of the sheet that begins at (x, y) into a strip.
using FillStrip = std::function<void(int x, int y, ImageF& strip)>;
/// A few rows at a time: an atlas may be larger than what there is beside it. @param fill  Called by several threads.
void write_control_tile(const std::filesystem::path& folder, const TransferTask& task, std::size_t control, int tile,
                        const FillStrip& fill, const RunControl& run);
/// @param place_of  Called by several threads.
void write_coordinate_tile(const std::filesystem::path& folder, const TransferTask& task, int tile, const TexelMap& map,
                           const std::function<SourcePlace(TexelId t)>& place_of, const RunControl& run);
/// Mesh and source mask.
void write_surface_files(const std::filesystem::path& folder, const TransferTask& task);

}  // namespace patinate::transfer
