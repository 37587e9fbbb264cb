/// \file
/// The mesh of a transfer by tile: nothing of it is held texel by texel.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "patinate/controls/control_kinds.h"
#include "patinate/history/history.h"
#include "patinate/transfer/control_matching.h"
#include "patinate/transfer/transfer.h"
#include "tools/patinate/services/destination.h"

namespace patinate::cli {

/// make_destination() without counting a texel: what would be chosen by them has to be said.
/// @throws UsageError naming what has to be said; IoError naming the mesh's file.
[[nodiscard]] Destination make_tiled_destination(const MeshSource& source, const AtlasOptions& options,
                                                 bool is_resolution_given, std::optional<double> pixel_mm,
                                                 CommandRun& run);

/// Controls whose values are made later, tile by tile. @throws as make_part_control().
[[nodiscard]] std::vector<transfer::TransferControl> make_tiled_controls(std::span<const transfer::ControlSpec> specs,
                                                                         const HistoryReader& history,
                                                                         const TexelMap& map,
                                                                         const ControlKindOptions& kinds);

}  // namespace patinate::cli
