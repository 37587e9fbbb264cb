// The module `patinate-markers`: see markers_module.h.
#include "capture/handheld/markers_module.h"

#include <opencv2/aruco.hpp>

namespace patinate::capture {

namespace {

// The largest of each size holds the smaller ones' markers.
constexpr std::array<cv::aruco::PREDEFINED_DICTIONARY_NAME, kMarkerDictionaries.size()> kNames{
    cv::aruco::DICT_4X4_250, cv::aruco::DICT_5X5_250,        cv::aruco::DICT_6X6_250,
    cv::aruco::DICT_7X7_250, cv::aruco::DICT_ARUCO_ORIGINAL, cv::aruco::DICT_APRILTAG_36h11};

class Markers final : public MarkersModule {
 public:
  [[nodiscard]] std::vector<SeenMarker> detect(const std::uint8_t* gray, int width, int height,
                                               int dictionary) override {
    const cv::Mat1b image(height, width, const_cast<std::uint8_t*>(gray));  // NOLINT: it is only read.
    std::vector<int> ids;
    std::vector<std::vector<cv::Point2f>> corners;
    cv::aruco::detectMarkers(image, cv::aruco::getPredefinedDictionary(kNames.at(static_cast<std::size_t>(dictionary))),
                             corners, ids);
    std::vector<SeenMarker> seen(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) {
      seen[i].id = ids[i];
      for (std::size_t k = 0; k < 4; ++k) seen[i].corners[k] = {corners[i][k].x, corners[i][k].y};
    }
    return seen;
  }
};

}  // namespace

}  // namespace patinate::capture

extern "C" [[gnu::visibility("default")]] patinate::capture::MarkersModule* patinate_markers_1() {
  static patinate::capture::Markers module;
  return &module;
}
