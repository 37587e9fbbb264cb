#include "analysis/cracks/line_mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/cracks/line_pixels.h"
#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kRows = 32;                             ///< Rows of a chunk of work.
constexpr float kNone = std::numeric_limits<float>::lowest();  ///< Below every value.

/// Largest value in a square around every pixel inside the mask, of those inside; kNone outside.
ImageF dilated(const ImageF& in, const ImageU8& mask, int reach, const RunControl& control) {
  const int w = in.width(), h = in.height();
  ImageF rows(w, h, 1, kNone), out(w, h, 1, kNone);
  parallel_for(h, kRows, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> padded(static_cast<std::size_t>(w + 2 * reach), kNone);
    for (int y = static_cast<int>(begin); y < end; ++y) {
      for (int x = 0; x < w; ++x) padded[x + reach] = is_inside(mask, x, y) ? in.at(x, y) : kNone;
      float* to = rows.row(y).data();
      for (int i = 0; i <= 2 * reach; ++i) {
        const float* from = padded.data() + i;
        for (int x = 0; x < w; ++x) to[x] = std::max(to[x], from[x]);
      }
    }
  });
  parallel_for(h, kRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y) {
      float* to = out.row(y).data();
      for (int j = std::max(0, y - reach); j <= std::min(h - 1, y + reach); ++j) {
        const float* from = rows.row(j).data();
        for (int x = 0; x < w; ++x) to[x] = std::max(to[x], from[x]);
      }
      for (int x = 0; x < w; ++x) to[x] = is_inside(mask, x, y) ? to[x] : kNone;
    }
  });
  return out;
}

ImageF negative(ImageF in) {
  for (float& v : in.values()) v = -v;
  return in;
}

/// The threshold that parts values best into two classes, [Otsu 1979], of 256 bins.
double otsu(const std::vector<float>& values) {
  const double high = static_cast<double>(*std::max_element(values.begin(), values.end()));
  if (!(high > 0.0)) return 0.0;
  std::array<double, 256> counts{};
  for (float v : values)
    counts[static_cast<std::size_t>(std::min(255.0, std::max(0.0, static_cast<double>(v)) / high * 256.0))] += 1.0;
  double total = 0.0, weighted = 0.0;
  for (std::size_t k = 0; k < 256; ++k) total += counts[k], weighted += counts[k] * static_cast<double>(k);
  double below = 0.0, below_weighted = 0.0, best = -1.0, threshold = 0.0;
  for (std::size_t k = 0; k + 1 < 256; ++k) {
    below += counts[k];
    below_weighted += counts[k] * static_cast<double>(k);
    if (below == 0.0 || below == total) continue;
    const double d = below_weighted / below - (weighted - below_weighted) / (total - below),
                 between = below * (total - below) * d * d;
    if (between > best) best = between, threshold = static_cast<double>(k + 1) / 256.0 * high;
  }
  return threshold;
}

}  // namespace

ImageF line_contrast(const ImageF& lightness, const ImageU8& mask, LineKind kind, int reach_px,
                     const RunControl& control) {
  if (lightness.channels() != 1 || (!mask.empty() && !mask.same_size(lightness)))
    throw InvalidInput("lines: one channel and a mask of its size are needed");
  if (reach_px < 1 || reach_px > 100) throw InvalidInput("lines: the reach must be in [1, 100] px");
  const ImageF shown = kind == LineKind::Dark ? lightness : negative(lightness);
  ImageF out = dilated(negative(dilated(shown, mask, reach_px, control)), mask, reach_px, control);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x)
      out.at(x, y) = is_inside(mask, x, y) ? std::max(0.0f, -out.at(x, y) - shown.at(x, y)) : 0.0f;
  }
  return out;
}

ImageU8 lines_at(const ImageF& contrast, double threshold, int least_area_px) {
  ImageU8 out(contrast.width(), contrast.height());
  for (std::int64_t i = 0; i < out.num_pixels(); ++i)
    out.data()[i] = static_cast<double>(contrast.data()[i]) >= threshold ? 255 : 0;
  for (const std::vector<PixelPlace>& part : parts_of(out, true)) {
    if (part.size() >= static_cast<std::size_t>(std::max(0, least_area_px))) continue;
    for (const PixelPlace& p : part) out.at(p.x, p.y) = 0;
  }
  return out;
}

ImageU8 find_cracks(const ImageF& lightness, const ImageU8& mask, const CrackFinder& settings) {
  if (!(settings.least_contrast > 0.0)) throw InvalidInput("cracks: the contrast must be > 0");
  const ImageF contrast = line_contrast(lightness, mask, LineKind::Dark, settings.reach_px);
  std::vector<float> inside;
  for (int y = 0; y < contrast.height(); ++y) {
    for (int x = 0; x < contrast.width(); ++x) {
      if (is_inside(mask, x, y)) inside.push_back(contrast.at(x, y));
    }
  }
  const double threshold = inside.empty() ? settings.least_contrast : std::max(otsu(inside), settings.least_contrast);
  // More than the threshold: at least the next number.
  return lines_at(contrast, std::nextafter(threshold, 1e30), settings.least_area_px);
}

}  // namespace patinate::analysis
