#include <string>
#include <vector>

#include "capture/project/frame_times.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// A file name in each line; each is a date of EXIF too.
PATINATE_FUZZ_TARGET(frame_times) {
  std::vector<std::filesystem::path> names;
  std::vector<std::string> dates;
  std::string line;
  for (char c : fuzz::text_of(bytes)) {
    if (c != '\n') {
      line += c;
      continue;
    }
    names.emplace_back(line);
    dates.push_back(line);
    line.clear();
  }
  for (const std::string& date : dates) {
    (void)capture::time_in_name(date);
    (void)capture::time_in_exif(date);
  }
  if (names.empty()) return;
  const capture::FrameTimes times = capture::find_frame_times(names, dates, TimeUnit::Hours);
  fuzz::require(times.times.size() == names.size(), "every photograph has a time");
  for (double t : times.times) fuzz::require(t >= 0.0, "times begin with the earliest");
}
