#include "analysis/grading/panel_mask.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

ImageU8 without_edge(const ImageU8& mask, double edge_px) {
  cv::Mat inside = cv::Mat::zeros(mask.height() + 2, mask.width() + 2, CV_8U), distance;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) inside.at<std::uint8_t>(y + 1, x + 1) = mask.at(x, y);
  }
  cv::distanceTransform(inside, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  ImageU8 out(mask.width(), mask.height());
  for (int y = 0; y < mask.height(); ++y) {
    // The middle of the outermost pixel is half a pixel from the edge.
    for (int x = 0; x < mask.width(); ++x)
      out.at(x, y) = static_cast<double>(distance.at<float>(y + 1, x + 1)) - 0.5 >= edge_px ? mask.at(x, y) : 0;
  }
  return out;
}

ImageU8 polygon_mask(int width, int height, double pixel_mm, const std::vector<double>& corners_mm) {
  if (corners_mm.size() < 6 || corners_mm.size() % 2 != 0)
    throw InvalidInput("a region: found " + std::to_string(corners_mm.size()) +
                       " numbers; expected x and y of three corners or more");
  // Pixel centers lie half a pixel inside; four bits of a fraction.
  constexpr int kBits = 4;
  std::vector<cv::Point> points;
  for (std::size_t k = 0; k < corners_mm.size(); k += 2) {
    const double x = corners_mm[k] / pixel_mm, y = corners_mm[k + 1] / pixel_mm;
    if (!(x > -1.0 && y > -1.0 && x < width + 1.0 && y < height + 1.0))
      throw InvalidInput("a region: the corner " + short_number_text(corners_mm[k]) + "," +
                         short_number_text(corners_mm[k + 1]) + " lies outside of the picture, which is " +
                         short_number_text(width * pixel_mm) + " x " + short_number_text(height * pixel_mm) + " mm");
    points.emplace_back(static_cast<int>(std::lround((x - 0.5) * (1 << kBits))),
                        static_cast<int>(std::lround((y - 0.5) * (1 << kBits))));
  }
  if (cv::contourArea(points) < 0.5 * (1 << kBits) * (1 << kBits))
    throw InvalidInput("a region: its corners enclose less than half a pixel");
  cv::Mat drawn = cv::Mat::zeros(height, width, CV_8U);
  cv::fillPoly(drawn, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(255), cv::LINE_8, kBits);
  ImageU8 mask(width, height);
  std::copy(drawn.begin<std::uint8_t>(), drawn.end<std::uint8_t>(), mask.data());
  return mask;
}

}  // namespace patinate::analysis
