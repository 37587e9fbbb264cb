#include "capture/stability/static_light.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/stability/static_light_fit.h"
#include "capture/stability/uneven_light.h"
#include "libcommon/core/median.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

constexpr int kNumWindows = 12;            ///< Along the longer side.
constexpr int kMinSide = 4 * kNumWindows;  ///< px: windows are means of sixteen.
constexpr std::size_t kFewestFrames = 6;   ///< Frames: three in each half.
constexpr std::size_t kMinWindows = 36;    ///< Inside the mask: five for each of the seven numbers.
constexpr double kExplained = 0.3;         ///< Share that find_uneven_light() asks for, too.
constexpr double kLampAgrees = 0.7;        ///< Both halves of the series (docs/algorithms/flat_field.md).
constexpr double kReflectionAgrees = 0.9;  ///< Both halves of the series (docs/algorithms/flat_field.md).
constexpr double kSeen = 0.05;             ///< Share of the mean light: less is no patch that one sees.
constexpr double kInside = 0.9;            ///< Share of the half sides.
constexpr double kNarrowest = 0.18;        ///< Half sides: a window is a sixth of one.
constexpr double kTooMuch = 0.001;         ///< Share of the samples: noise.

PicturePoint place_of(double x, double y, int width, int height) {
  const double half = 0.5 * std::max(width, height);
  return {(x - 0.5 * width) / half, (y - 0.5 * height) / half};
}

bool is_usable(const float* pixel) {
  const auto [low, high] = std::minmax_element(pixel, pixel + 3);
  return *low > kNearBlack && *high < kNearWhite;
}

/// Number of a window's pixels inside the mask.
int count_inside(const ImageU8& mask, int x0, int y0, int x1, int y1) {
  int num = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) num += mask.empty() || mask.at(x, y) != 0 ? 1 : 0;
  }
  return num;
}

/// Means of the windows of which half lies inside the mask, as far as half can be used in a frame.
WindowSeries windows_of(const std::vector<ImageF>& frames, const ImageU8& mask) {
  const int w = frames.front().width(), h = frames.front().height();
  const int side = std::max(1, (std::max(w, h) + kNumWindows - 1) / kNumWindows);
  WindowSeries series;
  series.values.resize(3 * frames.size());
  for (int y0 = 0; y0 < h; y0 += side) {
    for (int x0 = 0; x0 < w; x0 += side) {
      const int x1 = std::min(w, x0 + side), y1 = std::min(h, y0 + side);
      if (2 * count_inside(mask, x0, y0, x1, y1) < (x1 - x0) * (y1 - y0)) continue;
      series.places.push_back(place_of(0.5 * (x0 + x1), 0.5 * (y0 + y1), w, h));
      for (std::size_t f = 0; f < frames.size(); ++f) {
        std::array<double, 3> sum{};
        int num = 0;
        for (int y = y0; y < y1; ++y) {
          for (int x = x0; x < x1; ++x) {
            const float* pixel = frames[f].data() + 3 * (std::int64_t{y} * w + x);
            if ((!mask.empty() && mask.at(x, y) == 0) || !is_usable(pixel)) continue;
            for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(pixel[c]);
            ++num;
          }
        }
        const bool is_known = 2 * num >= (x1 - x0) * (y1 - y0);
        for (std::size_t c = 0; c < 3; ++c) series.values[3 * f + c].push_back(is_known ? sum[c] / num : std::nan(""));
      }
    }
  }
  return series;
}

/// The frames [begin, end) of a series.
WindowSeries part_of(const WindowSeries& series, std::size_t begin, std::size_t end) {
  const auto at = [&](std::size_t frame) { return series.values.begin() + static_cast<std::ptrdiff_t>(3 * frame); };
  return {series.places, {at(begin), at(end)}};
}

/// Whether every frame and channel has enough windows to find seven numbers from.
bool is_enough(const WindowSeries& series) {
  return series.places.size() >= kMinWindows &&
         std::all_of(series.values.begin(), series.values.end(), [](const std::vector<double>& values) {
           return 2 * std::count_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); }) >=
                  static_cast<std::ptrdiff_t>(values.size());
         });
}

template <class Of>
std::vector<double> over(const WindowSeries& series, const Of& value) {
  std::vector<double> values;
  std::transform(series.places.begin(), series.places.end(), std::back_inserter(values), value);
  return values;
}

/// 1 - variance of the difference / sum of the variances: 1 = equal, 0 = unrelated.
double common(const std::vector<double>& a, const std::vector<double>& b) {
  const double n = static_cast<double>(a.size());
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n,
               mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double both = 0.0, each = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    both += (a[i] - mean_a) * (b[i] - mean_b);
    each += (a[i] - mean_a) * (a[i] - mean_a) + (b[i] - mean_b) * (b[i] - mean_b);
  }
  return 2.0 * both / std::max(each, 1e-12);
}

double window_ratio(std::vector<double> light) {
  const double last = static_cast<double>(light.size() - 1);
  const double low = value_at_rank(light, static_cast<std::size_t>(kLeftOutEnd * last));
  return value_at_rank(light, static_cast<std::size_t>((1.0 - kLeftOutEnd) * last)) / low;
}

double mean_light(const WindowSeries& series) {
  double sum = 0.0, num = 0.0;
  for (const std::vector<double>& values : series.values) {
    for (double v : values) {
      if (std::isnan(v)) continue;
      sum += v;
      num += 1.0;
    }
  }
  return sum / std::max(1.0, num);
}

/// The whole series, and its halves.
struct Evidence {
  WindowSeries whole, first, second;
};

bool is_lamp(const Evidence& e, const LightFit& fit) {
  const auto log_light = [&](const LightFit& f) {
    return over(e.whole, [&](const PicturePoint& p) { return std::log(f.lamp.at(p)); });
  };
  const auto light = over(e.whole, [&](const PicturePoint& p) { return fit.lamp.at(p); });
  const double none = fit_light(e.whole, {}).variance;
  if (window_ratio(light) < kUnevenRatio || 1.0 - fit.variance / none < kExplained) return false;
  const FitParts parts{.lamp = true};
  return common(log_light(fit_light(e.first, parts)), log_light(fit_light(e.second, parts))) >= kLampAgrees;
}

/// Part of all samples that a reflection leaves nothing of.
double share_below(const std::vector<ImageF>& frames, const ImageU8& mask, const LampReflection& reflection) {
  double num = 0.0, num_below = 0.0;
  for (const ImageF& frame : frames) {
    for (int y = 0; y < frame.height(); ++y) {
      for (int x = 0; x < frame.width(); ++x) {
        if (!mask.empty() && mask.at(x, y) == 0) continue;
        const double r = reflection.at(place_of(x + 0.5, y + 0.5, frame.width(), frame.height()));
        const float* pixel = frame.data() + 3 * (std::int64_t{y} * frame.width() + x);
        num += 1.0;
        num_below += static_cast<double>(*std::min_element(pixel, pixel + 3)) < r ? 1.0 : 0.0;
      }
    }
  }
  return num_below / std::max(1.0, num);
}

bool is_reflection(const Evidence& e, const LightFit& fit, const FitParts& parts, const std::vector<ImageF>& frames,
                   const ImageU8& mask) {
  const auto reflection = [&](const LightFit& f) {
    return over(e.whole, [&](const PicturePoint& p) { return f.reflection.at(p); });
  };
  const std::vector<double> all = reflection(fit);
  if (*std::max_element(all.begin(), all.end()) < kSeen * mean_light(e.whole)) return false;
  // At the edge of the picture, or as small as a window, it may be any odd place of the surface.
  const PicturePoint& middle = fit.reflection.middle;
  if (std::max(std::abs(middle.x), std::abs(middle.y)) > kInside) return false;
  if (fit.reflection.inverse_width2 * kNarrowest * kNarrowest > 1.0) return false;
  if (share_below(frames, mask, fit.reflection) > kTooMuch) return false;
  return common(reflection(fit_light(e.first, parts)), reflection(fit_light(e.second, parts))) >= kReflectionAgrees;
}

/// Whether the surface is seen to be replaced once the light is taken out: a reflection is a detail that stays.
bool is_replaced_below(const std::vector<ImageF>& frames, const ImageU8& mask, const LightFit& light) {
  if (share_below(frames, mask, light.reflection) > kTooMuch) return false;
  std::vector<ImageF> surface = frames;
  for (ImageF& frame : surface) take_light_out(frame, {.lamp = light.lamp, .reflection = light.reflection});
  return is_surface_replaced(surface, mask);
}

}  // namespace

double LampLight::at(const PicturePoint& p) const {
  const double dx = p.x - below.x, dy = p.y - below.y;
  return std::pow(1.0 + (dx * dx + dy * dy) * inverse_height2, -1.5);
}

double LampReflection::at(const PicturePoint& p) const {
  const double dx = p.x - middle.x, dy = p.y - middle.y, spread = 1.0 + (dx * dx + dy * dy) * inverse_width2;
  return strength / (spread * spread);
}

StaticLight find_static_light(const std::vector<ImageF>& frames, const ImageU8& mask) {
  if (frames.size() < kFewestFrames || std::max(frames.front().width(), frames.front().height()) < kMinSide) return {};
  Evidence e{.whole = windows_of(frames, mask), .first = {}, .second = {}};
  if (!is_enough(e.whole)) return {};
  const LightFit all = fit_light(e.whole, {.lamp = true, .reflection = true});
  if (!is_surface_replaced(frames, mask) && !is_replaced_below(frames, mask, all)) return {};
  e.first = part_of(e.whole, 0, frames.size() / 2);
  e.second = part_of(e.whole, frames.size() / 2, frames.size());
  StaticLight result;
  FitParts parts{.lamp = true};
  LightFit fit = fit_light(e.whole, parts);
  parts.lamp = is_lamp(e, fit);
  parts.reflection = true;
  const LightFit both = parts.lamp ? all : fit_light(e.whole, parts);
  parts.reflection = is_reflection(e, both, parts, frames, mask);
  if (parts.reflection) result.reflection = both.reflection, fit = both;
  if (!parts.lamp) return result;
  result.lamp = fit.lamp;
  const auto light = over(e.whole, [&](const PicturePoint& p) { return fit.lamp.at(p); });
  result.ratio = std::max(1.0, window_ratio(light));
  result.mean = std::accumulate(light.begin(), light.end(), 0.0) / static_cast<double>(light.size());
  return result;
}

void take_light_out(ImageF& photograph, const StaticLight& light) {
  const int w = photograph.width(), h = photograph.height();
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const PicturePoint p = place_of(x + 0.5, y + 0.5, w, h);
      const double offset = light.reflection ? light.reflection->at(p) : 0.0;
      const double gain = light.lamp ? light.mean / light.lamp->at(p) : 1.0;
      float* pixel = photograph.data() + 3 * (std::int64_t{y} * w + x);
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<float>(std::max(0.0, (static_cast<double>(pixel[c]) - offset) * gain));
    }
  }
}

}  // namespace patinate::capture
