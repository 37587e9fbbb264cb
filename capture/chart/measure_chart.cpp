#include "capture/chart/measure_chart.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

constexpr double kPatchRadius = 0.22;  ///< Share of the distance to the next patch, whose half side is 0.43 of it.
constexpr double kMaxSaturated = 0.1;  ///< Share of a patch's pixels: no more are left out of a mean at its bright end.
constexpr double kLeastPixels = 12.0;  ///< Pixels of a sample.
/// Relative difference of a quarter of a patch. Light that falls by half over the whole chart changes a patch by a
/// tenth of this.
constexpr double kMaxUneven = 0.3;
/// Light of white: then the black patch is below code 6 of sRGB, and half a code is a tenth of it.
constexpr double kMinWhite = 0.04;
constexpr double kMinCode = 7.6e-4;  ///< Linear light of code 2.5 of 255 in sRGB: colors outside of a camera's gamut.
constexpr double kFaint = 0.01;      ///< Added to light that is divided by: a patch may be black in a channel.

double middle_mean(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t cut = values.size() / 10;
  double sum = 0.0;
  for (std::size_t i = cut; i < values.size() - cut; ++i) sum += values[i];
  return sum / static_cast<double>(values.size() - 2 * cut);
}

/// Distance of a patch's middle to the nearest other one, in pixels.
double spacing_px(const std::vector<Eigen::Vector2d>& middles, std::size_t patch) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < middles.size(); ++i) {
    if (i != patch) nearest = std::min(nearest, (middles[i] - middles[patch]).norm());
  }
  return nearest;
}

struct Channels {
  std::array<std::vector<double>, 3> values;
  void add(std::span<const float> rgb) {
    for (std::size_t c = 0; c < 3; ++c) values[c].push_back(static_cast<double>(rgb[c]));
  }
};

PatchLight measure_patch(const ImageF& linear, const SensorView& sensor, const Eigen::Vector2d& at, double radius) {
  PatchLight patch;
  const double half = 0.5 * std::hypot(linear.width(), linear.height());
  patch.x = (at.x() - 0.5 * (linear.width() - 1)) / half;
  patch.y = (at.y() - 0.5 * (linear.height() - 1)) / half;
  const int left = static_cast<int>(std::ceil(at.x() - radius)), right = static_cast<int>(std::floor(at.x() + radius));
  const int top = static_cast<int>(std::ceil(at.y() - radius)), bottom = static_cast<int>(std::floor(at.y() + radius));
  patch.is_shown = left >= 0 && top >= 0 && right < linear.width() && bottom < linear.height();
  if (!patch.is_shown) return patch;
  Channels all;
  std::array<Channels, 4> quarters;
  double num_saturated = 0.0;
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      if (std::hypot(x - at.x(), y - at.y()) > radius) continue;
      const auto codes = sensor.photo->pixel(x, y);
      if (*std::max_element(codes.begin(), codes.end()) >= sensor.level) num_saturated += 1.0;
      all.add(linear.pixel(x, y));
      quarters[(x < at.x() ? 0U : 1U) + (y < at.y() ? 0U : 2U)].add(linear.pixel(x, y));
    }
  }
  if (all.values[0].empty()) return patch;
  patch.saturated = num_saturated / static_cast<double>(all.values[0].size());
  for (std::size_t c = 0; c < 3; ++c) patch.light[c] = middle_mean(all.values[c]);
  const double least = *std::min_element(patch.light.begin(), patch.light.end());
  patch.is_clipped = patch.saturated > kMaxSaturated || (sensor.has_codes && least < kMinCode);
  const double bright = *std::max_element(patch.light.begin(), patch.light.end());
  for (const Channels& quarter : quarters) {
    if (quarter.values[0].empty()) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double difference = std::abs(middle_mean(quarter.values[c]) - patch.light[c]);
      patch.uneven = std::max(patch.uneven, difference / (bright + kFaint));
    }
  }
  return patch;
}

std::string named(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string list;
  for (std::size_t i = 0; i < std::min(kMost, names.size()); ++i) list += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kMost ? list + " and " + std::to_string(names.size() - kMost) + " more" : list;
}

std::string problem_of(const ChartSight& sight, const SensorView& sensor, const ChartTable& table) {
  std::vector<std::string> outside, uneven;
  std::size_t white = 0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const PatchLight& patch = sight.patches[i];
    if (!patch.is_shown) outside.push_back(table[i].name);
    if (patch.is_shown && patch.uneven > kMaxUneven) uneven.push_back(table[i].name);
    if (table[i].lab[0] > table[white].lab[0]) white = i;
  }
  if (!outside.empty()) return "shows only a part of its chart: " + named(outside) + " lie outside of the picture";
  const PatchLight& brightest = sight.patches[white];
  if (brightest.saturated > kMaxSaturated)
    return "is too bright for its chart: the patch " + table[white].name + " is saturated; expose less";
  const double most = *std::max_element(brightest.light.begin(), brightest.light.end());
  if (!(most > 0.0) || (sensor.has_codes && most < kMinWhite))
    return "is too dark for its chart: the patch " + table[white].name + " has " + percent_text(std::max(0.0, most)) +
           " of the largest code's light, under " + percent_text(kMinWhite) + "; expose more";
  if (!uneven.empty())
    return "shows its chart partly hidden, dirty or in a shadow's edge: " + named(uneven) + " are of two colors";
  return "";
}

}  // namespace

ChartSight measure_chart(const ImageF& linear, const SensorView& sensor, const Eigen::Matrix3d& photo_from_chart,
                         const ChartTable& table) {
  std::vector<Eigen::Vector2d> middles;
  for (const ChartPatch& patch : table)
    middles.push_back((photo_from_chart * Eigen::Vector3d(patch.x, patch.y, 1.0)).hnormalized());
  ChartSight sight;
  bool is_small = false;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double radius = kPatchRadius * spacing_px(middles, i);
    is_small = is_small || !(std::numbers::pi * radius * radius >= kLeastPixels);
    sight.patches.push_back(measure_patch(linear, sensor, middles[i], radius));
  }
  sight.problem = is_small ? "shows its chart too small: the middle of a patch has less than 12 pixels"
                           : problem_of(sight, sensor, table);
  return sight;
}

}  // namespace patinate::capture
