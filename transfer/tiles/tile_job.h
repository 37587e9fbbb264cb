/// \file
/// The plan of a transfer by tile.
#pragma once

#include <filesystem>

#include "libcommon/job/job.h"
#include "transfer/tiles/tiled_transfer.h"

namespace patinate::transfer {

/// An item a tile for every pass of every level that is tiled, one for all coarser levels; no process holds more than a
/// tile with what lies around it. What is written is what plan_transfer() writes, to the bit, but for keys.
/// @throws InvalidInput naming what cannot be done by tile.
[[nodiscard]] JobPlan plan_tiled_transfer(TiledTask task, const std::filesystem::path& output);

}  // namespace patinate::transfer
