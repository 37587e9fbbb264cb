/// \file
/// When photographs were taken: by what is stated, by EXIF, or by dates in their names.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/project/time_stamp.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

/// A photograph as far as its time is concerned.
struct DatedPhoto {
  std::filesystem::path file;
  std::string date_time = "";  ///< Date time as ImageInfo says them.
  std::string digitized = "";
  bool is_kept = true;  ///< False: excluded; it only says when the series begins.
};

/// Time that a photograph states, and where: "2020-05-28 18:20:05 (EXIF DateTimeOriginal)"; "" = nothing.
[[nodiscard]] std::string photo_time_text(const std::filesystem::path& file, const ImageInfo& info);

struct FrameTimes {
  std::vector<double> times;  ///< Times of the photographs that are kept, in their order; in `unit`, from the earliest
                              ///< of all photographs on; all different.
  std::string source;         ///< "EXIF DateTimeOriginal", "EXIF DateTimeDigitized" or "dates in file names".
  std::string span;           ///< "2023-03-26 01:30:00 +01:00 to 2023-03-26 04:00:00 +02:00".
  std::vector<HistoryWarning> warnings;  ///< Where sources disagree, with both values.
};

/// Sources in their order: EXIF DateTimeOriginal, EXIF DateTimeDigitized, dates in file names. A source counts only if
/// it gives every photograph that is kept a time of its own. Of those that agree with the first one the finest is
/// taken; of those that do not, a warning says so. Where the offset from UTC changes and is known of every photograph,
/// it is taken off.
///
/// Sources agree if one shift of at most 26 hours (time zones) explains what lies between them, to their resolutions
/// and 2 s (a name is given when a file is written).
/// @throws InvalidInput saying what was tried, which photograph it failed for, and what to give instead.
[[nodiscard]] FrameTimes find_frame_times(const std::vector<DatedPhoto>& photos, TimeUnit unit);

/// A warning for each source of find_frame_times() that contradicts stated times: by another order, or by more than
/// half of the shortest step and 2 % of the span.
/// @param times  As many as photographs, in `unit`.
[[nodiscard]] std::vector<HistoryWarning> check_stated_times(const std::vector<DatedPhoto>& photos,
                                                             const std::vector<double>& times, TimeUnit unit);

}  // namespace patinate::capture
