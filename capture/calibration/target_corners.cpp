#include "capture/calibration/target_corners.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

/// Corners to a few hundredths of a pixel: where all gradients around point away from [Foerstner 1987], in a window of
/// a third of a square, in a picture so smooth that its gradients are those of the edges and not of the pixels. On
/// rendered boards 10 times as near as what the detectors give.
void refine_corners(const ImageF& gray, std::vector<cv::Point2f>& corners, int columns) {
  double spacing = 1e9;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    if ((i + 1) % static_cast<std::size_t>(columns) != 0)
      spacing = std::min(spacing, cv::norm(corners[i + 1] - corners[i]));
  }
  for (std::size_t i = 0; i + static_cast<std::size_t>(columns) < corners.size(); ++i) {
    spacing = std::min(spacing, cv::norm(corners[i + static_cast<std::size_t>(columns)] - corners[i]));
  }
  const int window = std::clamp(static_cast<int>(std::lround(0.35 * spacing)), 2, 15);
  cv::Mat smooth(gray.height(), gray.width(), CV_32F);
  for (int y = 0; y < gray.height(); ++y) std::copy_n(gray.row(y).data(), gray.width(), smooth.ptr<float>(y));
  cv::GaussianBlur(smooth, smooth, {0, 0}, std::clamp(0.2 * window, 0.7, 2.0));
  const std::vector<cv::Point2f> start = corners;
  cv::cornerSubPix(smooth, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-5});
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!(cv::norm(corners[i] - start[i]) < 2.0)) corners[i] = start[i];
  }
}

}  // namespace

std::vector<Vec3> CalibrationTarget::points() const {
  if (kind == Kind::Points) return points_mm;
  if (columns < 2 || rows < 2 || columns > 200 || rows > 200)
    throw InvalidInput("a target has 2 to 200 columns and rows");
  if (!(spacing_mm > 0) || !std::isfinite(spacing_mm)) throw InvalidInput("a target's spacing must be > 0");
  std::vector<Vec3> points;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x)
      points.emplace_back(spacing_mm * (kind == Kind::Circles ? 2 * x + y % 2 : x), spacing_mm * y, 0.0);
  }
  return points;
}

std::string CalibrationTarget::text() const {
  if (kind == Kind::Points) return "list of " + std::to_string(points_mm.size()) + " points";
  const std::string size = std::to_string(columns) + " x " + std::to_string(rows);
  return kind == Kind::Chessboard ? "chessboard of " + size + " inner corners"
                                  : "asymmetric grid of " + size + " circles";
}

std::optional<std::vector<Vec2>> find_target(const ImageF& gray, const CalibrationTarget& target) {
  if (target.kind == CalibrationTarget::Kind::Points || gray.empty() || gray.channels() != 1) return std::nullopt;
  cv::Mat codes(gray.height(), gray.width(), CV_8U);
  for (int y = 0; y < gray.height(); ++y) {
    for (int x = 0; x < gray.width(); ++x)
      codes.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255.0f * gray.at(x, y));
  }
  std::vector<cv::Point2f> found;
  const cv::Size size(target.columns, target.rows);
  bool is_found = false;
  try {
    if (target.kind == CalibrationTarget::Kind::Chessboard) {
      is_found = cv::findChessboardCornersSB(
          codes, size, found, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY);
      if (!is_found) is_found = cv::findChessboardCorners(codes, size, found);
      if (is_found) refine_corners(gray, found, target.columns);
    } else {
      is_found = cv::findCirclesGrid(codes, size, found, cv::CALIB_CB_ASYMMETRIC_GRID);
    }
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  if (!is_found || found.size() != static_cast<std::size_t>(target.columns) * static_cast<std::size_t>(target.rows))
    return std::nullopt;
  std::vector<Vec2> pixels;
  for (const cv::Point2f& p : found) pixels.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y));
  return pixels;
}

}  // namespace patinate::capture
