/// \file
/// A transfer as a job: resumable, whole or absent.
#pragma once

#include <filesystem>
#include <string_view>

#include "libcommon/job/job.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

/// The folder of formats.md: coordinates.exr, control.exr, mesh.obj, transfer.json.
[[nodiscard]] JobPlan plan_transfer(TransferTask task, const std::filesystem::path& output);

/// Everything that coordinates depend on: by content, never by path.
[[nodiscard]] JobInputs transfer_inputs(const TransferTask& task, std::string_view stage = "transfer");

}  // namespace patinate::transfer
