/// \file
/// Takes the background off the mask of a time-lapse. Inside of ingest only.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "capture/timelapse/ingest_work.h"

namespace patinate::capture {

/// When all frames are written: what shows background in any of them is taken off `mask`, with a rim of three pixels
/// (one of the reduced photograph, if that is more) in which both are mixed. Nothing happens when the option is off.
/// @param mask  What is inside so far; may be empty.
/// @returns What is to be warned of: photographs that alone take much off.
/// @throws IoError naming the photograph when it has no plain background, or when nothing of the object is left.
[[nodiscard]] std::vector<HistoryWarning> take_background_off(const IngestWork& work,
                                                              const std::filesystem::path& folder, ImageU8& mask,
                                                              const RunControl& control);

/// Removes the background before the frames are finished, without warnings: for what is decided inside the mask.
/// @param read_frame  The roi of frame i, linear.
void take_background_off_early(const IngestWork& work, const std::function<ImageF(int)>& read_frame, ImageU8& mask,
                               const RunControl& control);

}  // namespace patinate::capture
