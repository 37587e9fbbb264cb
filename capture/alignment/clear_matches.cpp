#include "capture/alignment/clear_matches.h"

#include <opencv2/features2d.hpp>

namespace patinate::capture {

std::vector<int> clear_matches(const cv::Mat& from, const cv::Mat& to, float ratio) {
  std::vector<std::vector<cv::DMatch>> found;
  cv::BFMatcher(cv::NORM_L2).knnMatch(from, to, found, 2);
  std::vector<int> best;
  for (const auto& match : found) {
    const bool is_clear = match.size() == 2 && match[0].distance < ratio * match[1].distance;
    best.push_back(is_clear ? match[0].trainIdx : -1);
  }
  return best;
}

}  // namespace patinate::capture
