#include <string>
#include <vector>

#include "capture/project/frame_times.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// A file name in each line; each is a date of EXIF too.
PATINATE_FUZZ_TARGET(frame_times) {
  std::vector<capture::DatedPhoto> photos;
  std::vector<double> times;
  std::string line;
  for (char c : fuzz::text_of(bytes)) {
    if (c != '\n') {
      line += c;
      continue;
    }
    photos.push_back({.file = line, .date_time = line, .digitized = line});
    times.push_back(static_cast<double>(times.size()));
    if (const auto stamp = capture::time_in_exif(line)) (void)capture::stamp_text(*stamp);
    line.clear();
  }
  if (photos.empty()) return;
  (void)capture::check_stated_times(photos, times, TimeUnit::Hours);
  const capture::FrameTimes found = capture::find_frame_times(photos, TimeUnit::Hours);
  fuzz::require(found.times.size() == photos.size(), "every photograph has a time");
  for (double t : found.times) fuzz::require(t >= 0.0, "times begin with the earliest");
}
