/// \file
/// A movie as a plan: a picture an item, and a join that encodes them.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "libcommon/job/job.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/output/movie.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// What a movie is made of.
struct MovieFrames {
  std::filesystem::path output;
  std::string label;                                                   ///< Of progress.
  std::string key;                                                     ///< Of the movie.
  std::vector<std::string> keys;                                       ///< Of each picture.
  std::function<ImageU8(int index, const RunControl& control)> codes;  ///< sRGB codes.
  MovieOptions options;
  JobCost cost = {};  ///< Of a picture.
};

/// Answers `plan`, `run` and `join` (run.request()). Pictures are kept as PNGs in OUT.items until the movie is there;
/// those that are finished are not made again, and two processes may make the same at once.
/// @returns nothing unless the movie is there in the end.
/// @throws CannotComplete naming the pictures that a join lacks, or where another movie is in the way.
[[nodiscard]] std::optional<JobStatus> answer_movie(CommandRun& run, const MovieFrames& movie);

}  // namespace patinate::cli
