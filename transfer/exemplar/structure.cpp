#include "transfer/exemplar/structure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "libcommon/core/portable_math.h"
#include "patinate/image/color.h"
#include "transfer/exemplar/lines.h"
#include "transfer/exemplar/matrices.h"
#include "transfer/exemplar/regions.h"

namespace patinate::transfer {

namespace {

constexpr double kFullShare = 0.08;    // Lines of as much of the surface are what it looks like.
constexpr double kRegionWeight = 0.3;  // Against lines: tone shows regions as well.
constexpr double kMaxLines = 0.25;     // Share of a map: more are regions.

/// L* of a luminance in [0, 1] [CIE 15].
float lightness_of_luminance(float luminance) {
  const double y = std::max(0.0, static_cast<double>(luminance));
  return static_cast<float>(y > 216.0 / 24389.0 ? 116.0 * portable_pow(y, 1.0 / 3.0) - 16.0 : y * 24389.0 / 27.0);
}

cv::Mat distance_to(const cv::Mat& lines) {
  cv::Mat distance;
  cv::distanceTransform(lines == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance;
}

/// The value below which 98 % of the distances inside the mask lie.
double largest_distance(const cv::Mat& distance, const ImageU8& mask) {
  std::vector<float> values;
  for (int y = 0; y < distance.rows; ++y) {
    for (int x = 0; x < distance.cols; ++x) {
      if (is_inside(mask, x, y)) values.push_back(distance.at<float>(y, x));
    }
  }
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 98 / 100);
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

SourceStructure structure_of(const Lines& lines, const ImageU8& mask, const RunControl& control) {
  SourceStructure result;
  result.refused_line_share = lines.refused_share;
  if (lines.empty()) return result;
  result.kind = lines.is_dark ? StructureKind::DarkLines : StructureKind::BrightLines;
  result.share = lines.share;
  result.weight = std::min(1.0, lines.share / kFullShare);
  const cv::Mat to_any = distance_to(matrix_of(lines.all)), to_strong = distance_to(matrix_of(lines.strong));
  result.scale_px = std::max(2.0, largest_distance(to_any, mask));
  result.contrast = lines.thresholds.low;
  const double strong_scale_px = std::max(2.0, largest_distance(to_strong, mask));
  result.channels = ImageF(lines.all.width(), lines.all.height(), kStructureSize);
  for (int y = 0; y < lines.all.height(); ++y) {
    control.throw_if_stopped();
    for (int x = 0; x < lines.all.width(); ++x) {
      const auto any = static_cast<double>(to_any.at<float>(y, x)),
                 strong = static_cast<double>(to_strong.at<float>(y, x)),
                 fill = static_cast<double>(lines.fill.at(x, y));
      const auto sureness = [&](double threshold, bool is_near) {
        return is_near ? std::clamp(fill / threshold - 0.3, 0.0, 1.0) : 0.0;
      };
      const std::array<double, kStructureSize> values{
          2.0 * portable_decayed(any / result.scale_px), 2.0 * portable_decayed(strong / strong_scale_px),
          portable_decayed(6.0 * any / result.scale_px), sureness(lines.thresholds.low, any < 2.0),
          sureness(lines.thresholds.high, strong < 2.0)};
      for (int c = 0; c < kStructureSize; ++c) result.channels.at(x, y, c) = static_cast<float>(values[c]);
    }
  }
  return result;
}

SourceStructure structure_of(const Regions& regions, const ImageU8& mask) {
  SourceStructure result{.channels = {}, .kind = StructureKind::Regions};
  if (regions.is_second.empty()) return result;
  const cv::Mat is_second = matrix_of(regions.is_second);
  const cv::Mat to_second = distance_to(is_second), to_first = distance_to(is_second == 0);
  // Half a pixel is the border.
  const cv::Mat distance = cv::max(to_second, to_first) - 0.5;
  result.share = regions.share;
  result.scale_px = std::max(2.0, largest_distance(distance, mask));
  result.contrast = regions.contrast;
  result.weight = kRegionWeight;
  result.channels = ImageF(distance.cols, distance.rows, kStructureSize);
  for (int y = 0; y < distance.rows; ++y) {
    for (int x = 0; x < distance.cols; ++x) {
      const double side = regions.is_second.at(x, y) != 0 ? 1.0 : -1.0,
                   d = static_cast<double>(distance.at<float>(y, x)) / result.scale_px,
                   above = static_cast<double>(regions.value.at(x, y)) - regions.threshold;
      const std::array<double, kStructureSize> values{1.0 + side * portable_decayed(d),
                                                      1.0 + side * portable_decayed(6.0 * d),
                                                      std::clamp(above / regions.contrast + 0.5, 0.0, 1.0), 0.0, 0.0};
      for (int c = 0; c < kStructureSize; ++c) result.channels.at(x, y, c) = static_cast<float>(values[c]);
    }
  }
  return result;
}

/// Structure of a map that says where lines or regions are. @param map  H x W, [0, 1].
SourceStructure structure_of_map(const ImageF& map, const ImageF& lightness, const ImageU8& mask,
                                 const RunControl& control) {
  ImageU8 is_on(map.width(), map.height());
  double on = 0.0, total = 0.0, light_on = 0.0, light_off = 0.0;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      const bool here = map.at(x, y) >= 0.5f;
      is_on.at(x, y) = here ? 255 : 0;
      if (!is_inside(mask, x, y)) continue;
      total += 1.0;
      on += here ? 1.0 : 0.0;
      (here ? light_on : light_off) += static_cast<double>(lightness.at(x, y));
    }
  }
  if (on == 0.0 || on == total) return {};
  const double contrast = light_on / on - light_off / (total - on);
  SourceStructure result;
  if (on / total <= kMaxLines) {
    result = structure_of({.fill = map,
                           .all = is_on,
                           .strong = is_on,
                           .thresholds = {.low = 0.5, .high = 0.5},
                           .is_dark = contrast <= 0.0,
                           .share = on / total},
                          mask, control);
  } else {
    result = structure_of({.is_second = is_on,
                           .value = map,
                           .threshold = 0.5,
                           .contrast = 1.0,
                           .share = std::min(on, total - on) / total},
                          mask);
  }
  result.contrast = std::max(0.01, std::abs(contrast));
  return result;
}

}  // namespace

ImageF lightness_of(const ImageF& frame) {
  ImageF lightness(frame.width(), frame.height());
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) lightness.at(x, y) = lightness_of_luminance(luminance(frame.pixel(x, y)));
  }
  return lightness;
}

SourceStructure line_structure(const ImageF& lightness, const ImageU8& mask, const RunControl& control) {
  return structure_of(find_lines(lightness, mask, control), mask, control);
}

SourceStructure find_structure(const History& history, const ImageU8& mask, const AppearanceOptions& options,
                               const RunControl& control) {
  if (options.structure == 0.0) return {};
  const ImageF frame = history.read_frame(history.num_frames() - 1), lightness = lightness_of(frame);
  if (!options.structure_map.empty())
    return structure_of_map(history.read_control(options.structure_map), lightness, mask, control);
  SourceStructure lines = line_structure(lightness, mask, control);
  if (!lines.empty()) return lines;
  SourceStructure regions = structure_of(find_regions(frame, mask, control), mask);
  regions.refused_line_share = lines.refused_line_share;
  return regions;
}

std::optional<StructureFacts> facts_of(const SourceStructure& structure) {
  if (structure.empty()) return std::nullopt;
  return StructureFacts{.kind = structure.kind,
                        .share = structure.share,
                        .scale_px = structure.scale_px,
                        .contrast_lab = structure.contrast};
}

}  // namespace patinate::transfer
