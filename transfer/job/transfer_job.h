/// \file
/// A transfer as a job: resumable, whole or absent.
#pragma once

#include <filesystem>
#include <string_view>

#include "libcommon/job/job.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/transfer/transfer_io.h"
#include "transfer/files/transfer_edits.h"

namespace patinate::transfer {

/// The folder of formats.md: coordinates.exr, control.exr, mesh.obj, transfer.json.
/// @param edits  Applied to the finished transfer, in their order (transfer_editor.h).
/// @throws InvalidInput if an edit names a control that is not followed
[[nodiscard]] JobPlan plan_transfer(TransferTask task, const std::filesystem::path& output, TransferEdits edits = {});

/// Everything that coordinates depend on: by content, never by path.
[[nodiscard]] JobInputs transfer_inputs(const TransferTask& task, std::string_view stage = "transfer");

}  // namespace patinate::transfer
