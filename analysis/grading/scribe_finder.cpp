#include "analysis/grading/scribe_finder.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "analysis/grading/panel_mask.h"
#include "libcommon/core/median.h"
#include "libcommon/metrics/color_curves.h"

namespace patinate::analysis {

namespace {

constexpr double kMaxWidth_mm = 2.0;       // Cutters of ISO 17872 leave 0.2 to 1 mm; chips at the edges add to it.
constexpr float kMinLineContrast = 4.0f;   // L*; twice what the eye tells between two areas side by side.
constexpr float kNoiseContrast = 4.0f;     // Times the median answer, which is noise: lines cover far less than half.
constexpr double kMinScribeLength = 0.25;  // Of the panel's shorter side.
constexpr double kMinScribeSlenderness = 10.0;  // Length over width.
constexpr double kMinOfLongest = 0.5;           // Length over the longest's: arms of a cross are cut alike.
constexpr double kEnd = 0.5;                    // Share of the usual contrast that is left where the line ends.
constexpr double kMaxGap_mm = 1.0;

cv::Mat lightness_of(const ImageF& color) {
  cv::Mat out(color.height(), color.width(), CV_32F);
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      const auto c = color.pixel(x, y);
      out.at<float>(y, x) = static_cast<float>(
          lab_from_linear(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]))[0]);
    }
  }
  return out;
}

float median_where(const cv::Mat& values, const cv::Mat& inner) {
  std::vector<double> chosen;
  for (int y = 0; y < values.rows; ++y) {
    for (int x = 0; x < values.cols; ++x) {
      if (inner.at<std::uint8_t>(y, x) != 0) chosen.push_back(static_cast<double>(values.at<float>(y, x)));
    }
  }
  return chosen.empty() ? 0.0f : static_cast<float>(median(std::move(chosen)));
}

/// A straight line in pixels, and its direction.
struct Line {
  double x, y, dx, dy;
};

/// Through the pixels of `lines` within `reach` of the segment.
Line fitted(const cv::Vec4i& segment, const cv::Mat& lines, double reach) {
  const double dx = segment[2] - segment[0], dy = segment[3] - segment[1], length = std::hypot(dx, dy);
  std::vector<cv::Point2f> points;
  for (int y = 0; y < lines.rows; ++y) {
    for (int x = 0; x < lines.cols; ++x) {
      if (lines.at<std::uint8_t>(y, x) == 0) continue;
      const double across = ((x - segment[0]) * dy - (y - segment[1]) * dx) / length,
                   along = ((x - segment[0]) * dx + (y - segment[1]) * dy) / length;
      if (std::abs(across) <= reach && along >= 0.0 && along <= length)
        points.emplace_back(static_cast<float>(x), static_cast<float>(y));
    }
  }
  cv::Vec4f line;
  cv::fitLine(points, line, cv::DIST_HUBER, 0, 0.01, 0.001);
  return {static_cast<double>(line[2]), static_cast<double>(line[3]), static_cast<double>(line[0]),
          static_cast<double>(line[1])};
}

/// What answers across the line at one place.
struct Section {
  double sum = 0.0, most = 0.0;  ///< L* times pixels; L*.
};

Section section_at(const cv::Mat& answer, const cv::Mat& inner, const Line& line, double along, int reach) {
  Section section;
  for (int k = -reach; k <= reach; ++k) {
    const int x = static_cast<int>(std::lround(line.x + along * line.dx - k * line.dy)),
              y = static_cast<int>(std::lround(line.y + along * line.dy + k * line.dx));
    if (x < 0 || y < 0 || x >= answer.cols || y >= answer.rows || inner.at<std::uint8_t>(y, x) == 0) continue;
    const double value = static_cast<double>(answer.at<float>(y, x));
    section.sum += value;  // Noise answers, too: its median was taken off, so that it sums to about 0.
    section.most = std::max(section.most, value);
  }
  return section;
}

/// Where the line begins and ends, seen from its middle, and its width, in pixels.
struct Extent {
  double begin = 0.0, end = 0.0, width = 0.0;
};

Extent extent_of(const cv::Mat& answer, const cv::Mat& inner, const Line& line, double half_length, int reach,
                 int max_gap) {
  std::vector<double> sums, peaks;
  for (double along = -half_length; along <= half_length; along += 1.0) {
    const Section section = section_at(answer, inner, line, along, reach);
    sums.push_back(section.sum);
    peaks.push_back(section.most);
  }
  const double usual = median(std::move(sums)), peak = median(std::move(peaks));
  Extent extent{.width = peak > 0.0 ? usual / peak : 0.0};
  for (const int way : {-1, 1}) {
    int last = 0;
    for (int step = 0; step - last <= max_gap; ++step) {
      if (section_at(answer, inner, line, way * step, reach).sum >= kEnd * usual) last = step;
    }
    (way < 0 ? extent.begin : extent.end) = way * (last + 0.5);
  }
  return extent;
}

double length_of(const Scribe& s) { return std::hypot(s.x1 - s.x0, s.y1 - s.y0); }

/// Distance of a place from the line through a scribe's ends, mm.
double distance_across(const Scribe& s, double x_mm, double y_mm) {
  return std::abs((x_mm - s.x0) * (s.y1 - s.y0) - (y_mm - s.y0) * (s.x1 - s.x0)) / length_of(s);
}

/// The lines that answer, from the longest on; a segment along a line that was found is part of it.
std::vector<Scribe> lines_of(const cv::Mat& answer, const cv::Mat& inner, double pixel_mm, double least_px) {
  const int reach = std::max(2, static_cast<int>(std::ceil(kMaxWidth_mm / pixel_mm)));
  const int max_gap = std::max(2, static_cast<int>(std::lround(kMaxGap_mm / pixel_mm)));
  const float noise = median_where(answer, inner), threshold = std::max(kMinLineContrast, kNoiseContrast * noise);
  const cv::Mat lines = (answer >= threshold) & inner;
  std::vector<cv::Vec4i> segments;
  constexpr double kStep_rad = CV_PI / 720.0;
  cv::HoughLinesP(lines, segments, 1.0, kStep_rad, static_cast<int>(0.5 * least_px), least_px, max_gap);
  const auto length = [](const cv::Vec4i& s) { return std::hypot(s[2] - s[0], s[3] - s[1]); };
  std::stable_sort(segments.begin(), segments.end(),
                   [&](const cv::Vec4i& a, const cv::Vec4i& b) { return length(a) > length(b); });
  const cv::Mat above_noise = answer - static_cast<double>(noise);
  const auto mm = [&](double pixel) { return (pixel + 0.5) * pixel_mm; };
  std::vector<Scribe> found;
  for (const cv::Vec4i& segment : segments) {
    const bool is_part = std::any_of(found.begin(), found.end(), [&](const Scribe& s) {
      return std::max(distance_across(s, mm(segment[0]), mm(segment[1])),
                      distance_across(s, mm(segment[2]), mm(segment[3]))) <= kMaxWidth_mm;
    });
    if (is_part) continue;
    const Line line = fitted(segment, lines, reach);
    const Extent extent = extent_of(above_noise, inner, line, 0.4 * length(segment), reach, max_gap);
    const double extended = extent.end - extent.begin;
    if (extended < least_px || extended < kMinScribeSlenderness * extent.width) continue;
    found.push_back({mm(line.x + extent.begin * line.dx), mm(line.y + extent.begin * line.dy),
                     mm(line.x + extent.end * line.dx), mm(line.y + extent.end * line.dy),
                     std::max(1.0, extent.width) * pixel_mm});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Scribe& a, const Scribe& b) { return length_of(a) > length_of(b); });
  std::erase_if(found, [longest = found.empty() ? 0.0 : length_of(found.front())](const Scribe& s) {
    return length_of(s) < kMinOfLongest * longest;
  });
  return found;
}

}  // namespace

std::vector<Scribe> find_scribes(const ImageF& color, const ImageU8& mask, double pixel_mm) {
  const int margin = std::max(2, static_cast<int>(std::ceil(kMaxWidth_mm / pixel_mm)));
  ImageU8 inside = without_edge(mask, margin);
  const cv::Mat inner(mask.height(), mask.width(), CV_8U, inside.data());
  const cv::Rect box = cv::boundingRect(inner);
  if (box.empty()) return {};
  const double least_px = kMinScribeLength * std::min(box.width, box.height);
  cv::Mat light = lightness_of(color);
  const float plain = median_where(light, inner);
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x) {
      if (mask.at(x, y) == 0) light.at<float>(y, x) = plain;
    }
  }
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {2 * margin + 1, 2 * margin + 1});
  std::vector<Scribe> best;
  for (const int kind : {cv::MORPH_BLACKHAT, cv::MORPH_TOPHAT}) {  // Darker than the paint, and brighter.
    cv::Mat answer;
    cv::morphologyEx(light, answer, kind, square);
    std::vector<Scribe> found = lines_of(answer, inner, pixel_mm, least_px);
    if (!found.empty() && (best.empty() || length_of(found.front()) > length_of(best.front()))) best = std::move(found);
  }
  return best;
}

}  // namespace patinate::analysis
