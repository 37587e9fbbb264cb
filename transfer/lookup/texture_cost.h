/// \file
/// What it takes to write a texture of a transfer.
#pragma once

#include <filesystem>

#include "libcommon/job/job.h"
#include "patinate/transfer/transfer_reader.h"

namespace patinate::transfer {

/// Of all tiles at one time, in a process of its own. @param file  Its extension decides.
[[nodiscard]] JobCost texture_cost(const TransferFolder& transfer, const std::filesystem::path& file);

}  // namespace patinate::transfer
