#include "analysis/evaluation/source_lines.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "analysis/cracks/line_pixels.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace {

/// L* (docs/algorithms/evaluation.md).
constexpr std::array<double, kNumLineThresholds> kThresholds = {7.0, 10.0, 16.0};
constexpr int kMaxHalvings = 4;                            ///< Halvings by the root of two, and as many doublings.
constexpr double kMinShare = 0.003, kLargestShare = 0.25;  ///< Shares of the area (docs/algorithms/evaluation.md).
constexpr double kMinRun = 40.0;                           ///< px of line a dead end (docs/algorithms/evaluation.md).
/// px and px2 at the source's scale: closing square of 9 x 9, least spot.
constexpr int kReach = 4, kMinArea = 30;
constexpr std::int64_t kFewCharts = 4;  ///< With fewer charts, four crops a chart are compared.

bool are_lines(const LineStructure& s, double least_run) {
  return s.share() >= kMinShare && s.share() <= kLargestShare && s.inner_length_px >= least_run &&
         static_cast<double>(s.num_ends) * least_run <= s.inner_length_px;
}

}  // namespace

LineScale::LineScale(double pixels_per_texel) {
  const double larger = std::max(1.0, 1.0 / pixels_per_texel);
  reach = std::min(100, static_cast<int>(std::lround(kReach * larger)));
  least_area = static_cast<int>(std::lround(kMinArea * larger * larger));
  least_run = kMinRun * larger;
  structure.spur_px *= larger;
  structure.border_px = static_cast<int>(std::lround(structure.border_px * larger));
}

ImageF lightness_of(const ImageF& codes) {
  ImageF out(codes.width(), codes.height());
  for (std::int64_t i = 0; i < out.num_pixels(); ++i) {
    std::array<double, 3> linear{};
    for (std::size_t c = 0; c < 3; ++c)
      linear[c] = static_cast<double>(linear_from_srgb(codes.data()[3 * i + static_cast<std::int64_t>(c)] / 255.0f));
    out.data()[i] = static_cast<float>(lab_from_linear(linear[0], linear[1], linear[2])[0]);
  }
  return out;
}

std::array<float, 3> quarters_of(const ImageF& control, const ImageU8& mask) {
  const Percentiles outer = percentiles(control, mask, 0.25, 0.75), middle = percentiles(control, mask, 0.5, 0.5);
  return {outer.low, middle.low, outer.high};
}

ImageU8 in_quarters(const ImageF& control, const std::array<float, 3>& ends) {
  ImageU8 out(control.width(), control.height());
  for (std::int64_t i = 0; i < out.num_pixels(); ++i)
    out.data()[i] = static_cast<std::uint8_t>(
        std::count_if(ends.begin(), ends.end(), [&](float e) { return control.data()[i] > e; }));
  return out;
}

std::vector<Ground> charts_of(const MapPart& part, const ImageF& lightness, const ImageU8& quarter) {
  struct Box {
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
  };
  std::map<int, Box> boxes;
  part.for_each_covered([&](TexelId t, std::int64_t i) {
    const auto x = static_cast<int>(i % part.rect.width()), y = static_cast<int>(i / part.rect.width());
    Box& b = boxes[part.surface.chart(t)];
    if (b.x1 < 0) b = {x, y, x, y};
    b = {std::min(b.x0, x), b.y0, std::max(b.x1, x), y};
  });
  std::vector<Ground> charts;
  for (const auto& [number, b] : boxes) {
    const int w = b.x1 - b.x0 + 1, h = b.y1 - b.y0 + 1;
    Ground chart{crop(lightness, b.x0, b.y0, w, h), ImageU8(w, h),
                 quarter.empty() ? ImageU8() : crop(quarter, b.x0, b.y0, w, h), b.x0, b.y0};
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const TexelId t = part.texel(std::int64_t{b.y0 + y} * part.rect.width() + b.x0 + x);
        chart.mask.at(x, y) = part.surface.chart(t) == number ? 255 : 0;
      }
    }
    charts.push_back(std::move(chart));
  }
  return charts;
}

std::optional<SourceLines> lines_of(const Ground& source, LineKind kind, const LineScale& scale,
                                    const RunControl& control) {
  const ImageF contrast = line_contrast(source.lightness, source.mask, kind, scale.reach, control);
  const std::int64_t area = source.mask.empty() ? contrast.num_pixels()
                                                : source.mask.num_pixels() - std::count(source.mask.values().begin(),
                                                                                        source.mask.values().end(), 0);
  SourceLines found{.kind = kind, .thresholds = {}, .masks = {}, .structures = {}};
  const auto fits = [&](std::size_t i, double factor) {
    const double threshold = rounded(kThresholds[i] * factor, 3);
    const auto above = static_cast<double>(std::count_if(contrast.values().begin(), contrast.values().end(),
                                                         [&](float v) { return static_cast<double>(v) >= threshold; }));
    if (above < kMinShare * static_cast<double>(area)) return false;  // Thinning is what costs.
    found.thresholds[i] = threshold;
    found.masks[i] = lines_at(contrast, threshold, scale.least_area);
    const ImageU8& mask = found.masks[i];
    if (static_cast<double>(mask.num_pixels() - std::count(mask.values().begin(), mask.values().end(), 0)) >
        kLargestShare * static_cast<double>(area))
      return false;
    found.structures[i] = measure_structure(mask, source.mask, source.quarter, scale.structure, control);
    return are_lines(found.structures[i], scale.least_run);
  };
  for (int k = 0; k <= kMaxHalvings; ++k) {
    for (const int power : {k, -k}) {
      const double factor = std::exp2(power / 2.0);
      if (fits(1, factor) && fits(0, factor) && fits(2, factor)) return found;
      if (k == 0) break;
    }
  }
  return std::nullopt;
}

LineStructures measured(const std::vector<Ground>& charts, const SourceLines& lines, const LineScale& scale,
                        const RunControl& control) {
  LineStructures out;
  for (const Ground& chart : charts) {
    const ImageF contrast = line_contrast(chart.lightness, chart.mask, lines.kind, scale.reach, control);
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] += measure_structure(lines_at(contrast, lines.thresholds[i], scale.least_area), chart.mask, chart.quarter,
                                  scale.structure, control);
  }
  return out;
}

CutSource measured_crops(const std::vector<Ground>& charts, std::int64_t first, std::int64_t num_charts,
                         const Ground& source, const SourceLines& lines, const LineScale& scale,
                         const RunControl& control) {
  CutSource out;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const ImageU8& chart = charts[c].mask;
    const int w = std::min(chart.width(), source.lightness.width()),
              h = std::min(chart.height(), source.lightness.height());
    const int spare_x = source.lightness.width() - w, spare_y = source.lightness.height() - h;
    for (int k = 0; k < (num_charts < kFewCharts ? 4 : 1); ++k) {
      const auto corner = (first + static_cast<std::int64_t>(c) + k) % 4;
      const int x0 = corner % 2 == 0 ? 0 : spare_x, y0 = corner / 2 == 0 ? 0 : spare_y;
      ImageU8 mask = crop(chart, (chart.width() - w) / 2, (chart.height() - h) / 2, w, h);
      for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
          if (!is_inside(source.mask, x0 + x, y0 + y)) mask.at(x, y) = 0;
        }
      }
      const ImageF contrast =
          line_contrast(crop(source.lightness, x0, y0, w, h), mask, lines.kind, scale.reach, control);
      for (std::size_t i = 0; i < kNumLineThresholds; ++i) {
        const ImageU8 own = crop(lines.masks[i], x0, y0, w, h),
                      seen = lines_at(contrast, lines.thresholds[i], scale.least_area);
        out.structures[i] += measure_structure(seen, mask, {}, scale.structure, control);
        for (std::int64_t p = 0; p < mask.num_pixels(); ++p) {
          out.there[i] += mask.data()[p] != 0 && own.data()[p] != 0;
          out.found[i] += mask.data()[p] != 0 && seen.data()[p] != 0;
        }
      }
    }
  }
  return out;
}

Picture line_picture(const std::vector<Ground>& charts, const SourceLines& lines, const TexelRect& rect,
                     const LineScale& scale, const RunControl& control) {
  constexpr int kDot = 2;
  const bool is_dark = lines.kind == LineKind::Dark;
  ImageF image(rect.width(), rect.height(), 3, 0.18f);
  const auto paint = [&](int x, int y, float red, float green, float blue) {
    if (!image.contains(x, y)) return;
    const auto p = image.pixel(x, y);
    p[0] = red, p[1] = green, p[2] = blue;
  };
  std::vector<PixelPlace> ends;
  for (const Ground& chart : charts) {
    const ImageF contrast = line_contrast(chart.lightness, chart.mask, lines.kind, scale.reach, control);
    const ImageU8 centers =
        pruned(thinned(lines_at(contrast, lines.thresholds[1], scale.least_area)), scale.structure.spur_px);
    const ImageU8 dead = dead_ends(centers, chart.mask, scale.structure.border_px);
    for (int y = 0; y < centers.height(); ++y) {
      for (int x = 0; x < centers.width(); ++x) {
        if (chart.mask.at(x, y) == 0) continue;
        const float v = centers.at(x, y) != 0 ? 0.0f : 0.8f;
        paint(chart.x + x, chart.y + y, v, v, v);
        if (dead.at(x, y) != 0) ends.push_back({chart.x + x, chart.y + y});
      }
    }
  }
  for (const PixelPlace& end : ends) {
    for (int j = -kDot; j <= kDot; ++j) {
      for (int i = -kDot; i <= kDot; ++i) paint(end.x + i, end.y + j, 0.8f, 0.0f, 0.0f);
    }
  }
  return {is_dark ? "lines" : "bright_lines",
          std::string(is_dark ? "Dark" : "Bright") + " lines at " + short_number_text(lines.thresholds[1]) +
              " L*; red: where they end without meeting another",
          std::move(image)};
}

}  // namespace patinate::analysis
