#include "analysis/grading/labeled_rust.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMinMarked = 20;  // Fewer do not say how much a color varies.
constexpr double kRim = 0.02;           // Share of marked pixels at each end that is taken for mistakes.
constexpr double kBeyond_deg = 5.0;     // Rust that was not marked varies a little more.
constexpr double kBeyondLightness = 5.0;
constexpr double kBeyondShare = 0.8;  // Of chroma and of change.
constexpr double kGrayChroma = 8.0;   // CIELAB; below it a hue is noise.

std::array<double, 3> lab_at(const ImageF& image, int x, int y) {
  const auto c = image.pixel(x, y);
  return lab_from_linear(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]));
}

bool is_inner(const ImageU8& labels, int x, int y) {
  for (int j = y - 1; j <= y + 1; ++j) {
    for (int i = x - 1; i <= x + 1; ++i) {
      if (!labels.contains(i, j) || labels.at(i, j) == 0) return false;
    }
  }
  return true;
}

/// The value that a share of all lies below.
double at_share(std::vector<double> values, double share) {
  return value_at_rank(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

}  // namespace

RustRule labeled_rust_rule(RustRule rule, const ImageF& before, const ImageF& marked, const ImageU8& labels) {
  if (labels.width() != marked.width() || labels.height() != marked.height())
    throw InvalidInput("the labels: have " + size_text(labels.width(), labels.height()) +
                       " pixels; the photographs have " + size_text(marked.width(), marked.height()));
  std::vector<double> lightness, chroma, change;
  std::vector<std::array<double, 2>> colors;
  double a = 0.0, b = 0.0;
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      if (!is_inner(labels, x, y)) continue;
      const std::array<double, 3> lab = lab_at(marked, x, y);
      lightness.push_back(lab[0]);
      chroma.push_back(std::hypot(lab[1], lab[2]));
      colors.push_back({lab[1], lab[2]});
      a += lab[1];
      b += lab[2];
      if (before.empty()) continue;
      const std::array<double, 3> was = lab_at(before, x, y);
      change.push_back(std::hypot(lab[0] - was[0], lab[1] - was[1], lab[2] - was[2]));
    }
  }
  if (lightness.size() < kMinMarked)
    throw InvalidInput("the labels: mark " + std::to_string(lightness.size()) +
                       " pixels off their edges; mark spots with " + std::to_string(kMinMarked) + " or more");
  rule.least_lightness = std::max(0.0, at_share(lightness, kRim) - kBeyondLightness);
  rule.most_lightness = std::min(100.0, at_share(lightness, 1.0 - kRim) + kBeyondLightness);
  if (!change.empty()) rule.least_change = std::max(1.0, kBeyondShare * at_share(change, kRim));
  if (at_share(chroma, 0.5) < kGrayChroma) {
    rule.least_chroma = 0.0;
    rule.low_hue_deg = -180.0;
    rule.high_hue_deg = 180.0;
    return rule;
  }
  rule.least_chroma = kBeyondShare * at_share(chroma, kRim);
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const double middle = std::atan2(b, a) * kDegrees;
  std::vector<double> hues;  // From the middle, so that none lies at the ends of the circle.
  for (const auto& color : colors)
    hues.push_back(std::remainder(std::atan2(color[1], color[0]) * kDegrees - middle, 360.0));
  rule.low_hue_deg = middle + at_share(hues, kRim) - kBeyond_deg;
  rule.high_hue_deg = middle + at_share(hues, 1.0 - kRim) + kBeyond_deg;
  return rule;
}

}  // namespace patinate::analysis
