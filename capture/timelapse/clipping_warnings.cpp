#include "capture/timelapse/clipping_warnings.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/text.h"
#include "patinate/core/json.h"

namespace patinate::capture {

namespace {

/// What is clipped in all photographs, one way.
struct ClippedSeries {
  std::int64_t num_clipped = 0, num_pixels = 0;
  std::vector<std::string> photos;

  void add(std::int64_t clipped, std::int64_t pixels, const CapturePhoto& photo) {
    num_clipped += clipped;
    num_pixels += pixels;
    if (clipped > 0) photos.push_back(photo.name());
  }
  [[nodiscard]] double share() const {
    return static_cast<double>(num_clipped) / static_cast<double>(std::max<std::int64_t>(1, num_pixels));
  }
  [[nodiscard]] std::string count_text() const {
    return std::to_string(num_clipped) + (num_clipped == 1 ? " pixel" : " pixels") + " of " + photos.front() +
           (photos.size() == 1 ? "" : " and " + std::to_string(photos.size() - 1) + " more photographs");
  }
};

}  // namespace

std::vector<HistoryWarning> clipping_warnings(const CaptureProject& project, const std::filesystem::path& folder) {
  ClippedSeries outside, beyond;
  for (std::size_t i = 0; i < project.frames.size(); ++i) {
    const CapturePhoto& photo = project.frames[i];
    if (!may_be_clipped(project, photo)) continue;
    const Json json = load_json(folder / clipped_file(static_cast<int>(i)));
    const auto count = [&](const char* name) { return json.at(name).get<std::int64_t>(); };
    outside.add(count("outside"), count("pixels"), photo);
    beyond.add(count("beyond"), count("pixels"), photo);
  }
  std::vector<HistoryWarning> warnings;
  if (outside.num_clipped > 0) {
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "the colors of " + outside.count_text() + " (" + fixed_percent_text(outside.share()) +
                                ") lie outside of Rec. 709; what would be negative is 0",
                        .cure = "",
                        .share = outside.share(),
                        .photos = outside.photos});
  }
  if (beyond.num_clipped > 0) {
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "the light of " + beyond.count_text() +
                                " is more than half floats hold; it is 65504, and counts as saturated",
                        .cure = "",
                        .share = beyond.share(),
                        .photos = beyond.photos});
  }
  return warnings;
}

}  // namespace patinate::capture
