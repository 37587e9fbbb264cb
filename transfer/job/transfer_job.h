/// \file
/// A transfer as a job: resumable, whole or absent.
#pragma once

#include <filesystem>

#include "libcommon/job/job.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

/// The folder of formats.md: coordinates.exr, control.exr, mesh.obj, transfer.json.
[[nodiscard]] JobPlan plan_transfer(TransferTask task, const std::filesystem::path& output);

}  // namespace patinate::transfer
