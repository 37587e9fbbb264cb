/// \file
/// A movie as a plan: a picture an item, and a join that encodes them.
#pragma once

#include <optional>

#include "libcommon/job/job.h"
#include "tools/patinate/command_line/command_run.h"
#include "tools/patinate/services/output_work.h"

namespace patinate::cli {

/// Answers `plan`, `run` and `join` (run.request()). Pictures are kept as PNGs in OUT.items until the movie is there;
/// those that are finished are not made again, and two processes may make the same at once.
/// @returns nothing unless the movie is there in the end.
/// @throws CannotComplete naming the pictures that a join lacks, or where another movie is in the way.
[[nodiscard]] std::optional<JobStatus> answer_movie(CommandRun& run, const MovieFrames& movie);

}  // namespace patinate::cli
