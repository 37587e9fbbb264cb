#include "analysis/grading/relief_marks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "analysis/grading/graded_figure.h"
#include "libcommon/core/median.h"

namespace patinate::analysis {

namespace {

constexpr double kPlaneOutliers = 2.5;  // Robust deviations; of a normal distribution 1 % lie beyond.
constexpr int kPlaneRounds = 5;
constexpr double kNoiseDeviations = 4.0;  // Of single pixels; four connected ones are no chance.
constexpr double kMinHeight_mm = 0.01;    // Thinner than a coat of paint.
constexpr int kMinPixels = 4;

std::vector<std::size_t> pixels_of(const ImageU8& mask) {
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < mask.values().size(); ++i) {
    if (mask.data()[i] != 0) pixels.push_back(i);
  }
  return pixels;
}

double robust_deviation(const ImageF& values, const std::vector<std::size_t>& pixels) {
  std::vector<double> sizes;
  for (const std::size_t i : pixels) sizes.push_back(std::abs(static_cast<double>(values.data()[i])));
  return kSigmaOfMad * median(std::move(sizes));
}

void take_off_plane(ImageF& values, const std::vector<std::size_t>& pixels) {
  const auto width = static_cast<std::size_t>(values.width());
  const auto row_of = [&](std::size_t i) {
    return Eigen::Vector3d(1.0, static_cast<double>(i % width) / values.width(),
                           static_cast<double>(i / width) / values.height());
  };
  std::vector<double> all;
  for (const std::size_t i : pixels) all.push_back(static_cast<double>(values.data()[i]));
  const auto middle = static_cast<float>(median(std::move(all)));
  for (float& v : values.values()) v -= middle;
  for (int round = 0; round < kPlaneRounds; ++round) {
    const double most = kPlaneOutliers * robust_deviation(values, pixels);
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Eigen::Vector3d products = Eigen::Vector3d::Zero();
    for (const std::size_t i : pixels) {
      const double v = static_cast<double>(values.data()[i]);
      if (std::abs(v) > most) continue;
      const Eigen::Vector3d row = row_of(i);
      squares += row * row.transpose();
      products += v * row;
    }
    const Eigen::Vector3d plane = squares.ldlt().solve(products);
    if (!plane.allFinite()) return;  // A mask of one line has no tilt.
    for (std::size_t i = 0; i < values.values().size(); ++i)
      values.data()[i] -= static_cast<float>(plane.dot(row_of(i)));
  }
}

/// Of a mark, from its pixels; `sunk` is positive where it is.
struct Component {
  std::vector<cv::Point> pixels = {};
  double peak = 0.0;  ///< Greatest mean over 3 x 3 pixels.
};

ReliefMark blister_of(const Component& c, double threshold, double edge_px) {
  const auto seen = static_cast<double>(c.pixels.size());
  // A cap that is flat beside its width is a paraboloid: its section shrinks linearly with height.
  const double area = seen / std::max(0.1, 1.0 - threshold / std::max(c.peak, threshold));
  return {.area_px = area, .uncertain_px = 0.5 * (area - seen) + kEdgeUncertainty_px * edge_px};
}

ReliefMark flake_of(const Component& c, const cv::Mat& sunk, double edge_px) {
  std::vector<double> depths;
  for (const cv::Point& p : c.pixels) depths.push_back(static_cast<double>(sunk.at<float>(p)));
  const double depth = median(std::move(depths));
  double area = 0.0;
  for (const cv::Point& p : c.pixels) area += std::clamp(static_cast<double>(sunk.at<float>(p)) / depth, 0.0, 1.0);
  return {.area_px = area, .uncertain_px = kEdgeUncertainty_px * edge_px};
}

double longest_side(const std::vector<cv::Point>& pixels) {
  const cv::RotatedRect box = cv::minAreaRect(pixels);  // Of pixels' middles: half a pixel less on each side.
  return static_cast<double>(std::max(box.size.width, box.size.height)) + 1.0;
}

int edge_pixels(const Component& c, const cv::Mat& labels, int label) {
  return static_cast<int>(std::count_if(c.pixels.begin(), c.pixels.end(), [&](const cv::Point& p) {
    for (const cv::Point& step : {cv::Point(1, 0), cv::Point(-1, 0), cv::Point(0, 1), cv::Point(0, -1)}) {
      const cv::Point q = p + step;
      if (q.x < 0 || q.y < 0 || q.x >= labels.cols || q.y >= labels.rows || labels.at<int>(q) != label) return true;
    }
    return false;
  }));
}

}  // namespace

ImageF height_change(const ImageF& before, const ImageF& now, const ImageU8& mask) {
  ImageF change = now;
  if (!before.empty()) {
    for (std::size_t i = 0; i < change.values().size(); ++i) change.data()[i] -= before.data()[i];
  }
  take_off_plane(change, pixels_of(mask));
  return change;
}

ReliefMarks find_relief_marks(const ImageF& change, const ImageU8& mask, ReliefKind kind) {
  const double sign = kind == ReliefKind::Blister ? 1.0 : -1.0;
  const double threshold = std::max(kMinHeight_mm, kNoiseDeviations * robust_deviation(change, pixels_of(mask)));
  cv::Mat size(change.height(), change.width(), CV_32F), inside(change.height(), change.width(), CV_8U), labels, mean;
  for (int y = 0; y < change.height(); ++y) {
    for (int x = 0; x < change.width(); ++x) {
      size.at<float>(y, x) = static_cast<float>(sign) * change.at(x, y);
      inside.at<std::uint8_t>(y, x) = mask.at(x, y) != 0 && static_cast<double>(size.at<float>(y, x)) > threshold;
    }
  }
  const int count = cv::connectedComponents(inside, labels, 8, CV_32S);
  cv::blur(size, mean, {3, 3});
  std::vector<Component> components(static_cast<std::size_t>(count));
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      Component& c = components[static_cast<std::size_t>(labels.at<int>(y, x))];
      if (labels.at<int>(y, x) == 0) continue;
      c.pixels.emplace_back(x, y);
      c.peak = std::max(c.peak, static_cast<double>(mean.at<float>(y, x)));
    }
  }
  ReliefMarks out{std::vector<int>(change.values().size(), -1), {}};
  for (int k = 1; k < count; ++k) {
    const Component& c = components[static_cast<std::size_t>(k)];
    if (c.pixels.size() < kMinPixels) continue;
    const double edge_px = edge_pixels(c, labels, k);
    ReliefMark mark = kind == ReliefKind::Blister ? blister_of(c, threshold, edge_px) : flake_of(c, size, edge_px);
    mark.longest_px = longest_side(c.pixels);
    for (const cv::Point& p : c.pixels)
      out.labels[static_cast<std::size_t>(p.y) * static_cast<std::size_t>(change.width()) +
                 static_cast<std::size_t>(p.x)] = static_cast<int>(out.marks.size());
    out.marks.push_back(mark);
  }
  return out;
}

}  // namespace patinate::analysis
