#include "capture/handheld/printed_markers.h"

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "capture/handheld/markers_module.h"
#include "libcommon/core/module.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

MarkersModule& markers_module() {
  using Entry = MarkersModule* (*)();
  static MarkersModule& module = *reinterpret_cast<Entry>(module_function("patinate-markers", kMarkersEntry))();
  return module;
}

cv::Mat1b marker_gray(const ImageF& color) {
  const ImageU8 codes = srgb8_from_linear(color);
  cv::Mat1b gray(codes.height(), codes.width());
  for (int y = 0; y < codes.height(); ++y) {
    for (int x = 0; x < codes.width(); ++x) {
      const auto pixel = codes.pixel(x, y);
      gray(y, x) = static_cast<std::uint8_t>((pixel[0] + 2 * pixel[1] + pixel[2] + 2) / 4);
    }
  }
  return gray;
}

/// To a fraction of a pixel, looking no farther than half of the black border is wide: cells inside have corners, too.
void refine(const cv::Mat1b& gray, std::vector<cv::Point2f>& corners) {
  constexpr double kLargestCells = 9.0;  // Across a marker, with its border: 7 x 7.
  const double side = cv::arcLength(corners, true) / 4.0;
  const int half = std::clamp(static_cast<int>(side / kLargestCells / 2.0), 2, 8);
  const cv::TermCriteria until(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 50, 0.01);
  cv::cornerSubPix(gray, corners, cv::Size(half, half), cv::Size(-1, -1), until);
}

}  // namespace

std::vector<PhotoMarks> find_markers(const ImageF& color) {
  const cv::Mat1b gray = marker_gray(color);
  std::vector<PhotoMarks> found;
  for (std::size_t d = 0; d < kMarkerDictionaries.size(); ++d) {
    const std::vector<SeenMarker> seen = markers_module().detect(gray.data, gray.cols, gray.rows, static_cast<int>(d));
    PhotoMarks& marks = found.emplace_back();
    for (const SeenMarker& marker : seen) {
      if (std::count_if(seen.begin(), seen.end(), [&](const SeenMarker& other) { return other.id == marker.id; }) > 1)
        continue;
      std::vector<cv::Point2f> corners;
      for (const auto& [x, y] : marker.corners) corners.emplace_back(x, y);
      refine(gray, corners);
      for (std::size_t k = 0; k < corners.size(); ++k) {
        marks[std::string(kMarkerDictionaries[d]) + " " + std::to_string(marker.id) + " corner " + std::to_string(k)] =
            {static_cast<double>(corners[k].x), static_cast<double>(corners[k].y)};
      }
    }
  }
  return found;
}

std::vector<PhotoMarks> of_one_dictionary(const std::vector<std::vector<PhotoMarks>>& found) {
  std::size_t best = 0, most = 0;
  for (std::size_t d = 0; d < kMarkerDictionaries.size(); ++d) {
    std::map<std::string, std::size_t> num_photos;
    for (const std::vector<PhotoMarks>& of_photo : found) {
      for (const auto& [name, at] : of_photo[d]) ++num_photos[name];
    }
    std::size_t num_pairs = 0;
    for (const auto& [name, n] : num_photos) num_pairs += n * (n - 1) / 2;
    if (num_pairs > most) best = d, most = num_pairs;
  }
  std::vector<PhotoMarks> marks;
  for (const std::vector<PhotoMarks>& of_photo : found) marks.push_back(of_photo[best]);
  return marks;
}

}  // namespace patinate::capture
