#include "analysis/evaluation/structure_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "analysis/cracks/line_pixels.h"
#include "analysis/cracks/line_structure.h"
#include "analysis/evaluation/wanted_share.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace {

constexpr std::array<double, 3> kThresholds = {7.0, 10.0, 16.0};
constexpr int kMostHalvings = 4;  ///< Of the root of two, and as many doublings.
constexpr double kLeastShare = 0.003, kLargestShare = 0.25;
constexpr double kLeastRun = 40.0;  ///< Pixels of line for a dead end.
constexpr int kReach = 4, kLeastArea = 30;
constexpr std::size_t kFewCharts = 4;
constexpr int kScaleDigits = 4;  ///< Of what sizes say, rounding is no scale.

/// What is measured in texels, where a pixel of the source has one or more.
struct LineScale {
  int reach = kReach;
  int least_area = kLeastArea;
  double least_run = kLeastRun;
  LineStructureOptions structure;

  explicit LineScale(double pixels_per_texel) {
    const double larger = std::max(1.0, 1.0 / pixels_per_texel);
    reach = std::min(100, static_cast<int>(std::lround(kReach * larger)));
    least_area = static_cast<int>(std::lround(kLeastArea * larger * larger));
    least_run *= larger;
    structure.spur_px *= larger;
    structure.border_px = static_cast<int>(std::lround(structure.border_px * larger));
  }
};

/// What lines are found in.
struct Ground {
  ImageF lightness;  ///< L*.
  ImageU8 mask;      ///< 0 = outside.
  ImageU8 quarter;   ///< May be empty.
  int x = 0, y = 0;  ///< Its corner in the atlas.
};

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

/// The source's nearest pixel for each texel of a plane.
template <class T>
Image<T> at_texels(const Image<T>& in, double pixels_per_texel) {
  if (in.empty() || pixels_per_texel == 1.0) return in;
  const auto length = [&](int n) { return std::max(1, static_cast<int>(std::floor(n / pixels_per_texel))); };
  const auto pixel = [&](int i, int n) {
    return std::clamp(static_cast<int>(std::floor((i + 0.5) * pixels_per_texel)), 0, n - 1);
  };
  Image<T> out(length(in.width()), length(in.height()));
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) out.at(x, y) = in.at(pixel(x, in.width()), pixel(y, in.height()));
  }
  return out;
}

/// Upper ends of the source's first three quarters.
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

/// The charts, each in its own picture.
std::vector<Ground> charts_of(const TexelMap& surface, const ImageF& lightness, const ImageU8& quarter) {
  struct Box {
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
  };
  std::vector<Box> boxes;
  const auto x_of = [&](TexelId t) { return static_cast<int>(t % surface.width()); };
  const auto y_of = [&](TexelId t) { return static_cast<int>(t / surface.width()); };
  for (TexelId t = 0; t < surface.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const auto c = static_cast<std::size_t>(surface.chart(t));
    if (c >= boxes.size()) boxes.resize(c + 1);
    Box& b = boxes[c];
    if (b.x1 < 0) b = {x_of(t), y_of(t), x_of(t), y_of(t)};
    b = {std::min(b.x0, x_of(t)), b.y0, std::max(b.x1, x_of(t)), y_of(t)};
  }
  std::vector<Ground> charts;
  for (std::size_t c = 0; c < boxes.size(); ++c) {
    const Box& b = boxes[c];
    if (b.x1 < 0) continue;
    const int w = b.x1 - b.x0 + 1, h = b.y1 - b.y0 + 1;
    Ground chart{crop(lightness, b.x0, b.y0, w, h), ImageU8(w, h),
                 quarter.empty() ? ImageU8() : crop(quarter, b.x0, b.y0, w, h), b.x0, b.y0};
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const TexelId t = TexelId{b.y0 + y} * surface.width() + b.x0 + x;
        chart.mask.at(x, y) = surface.is_covered(t) && surface.chart(t) == static_cast<int>(c) ? 255 : 0;
      }
    }
    charts.push_back(std::move(chart));
  }
  return charts;
}

using Structures = std::array<LineStructure, kThresholds.size()>;  ///< One a threshold.

/// Lines of one kind in a source.
struct SourceLines {
  LineKind kind = LineKind::Dark;
  std::array<double, kThresholds.size()> thresholds = {};
  std::array<ImageU8, kThresholds.size()> masks;
  Structures structures;
};

bool are_lines(const LineStructure& s, double least_run) {
  return s.share() >= kLeastShare && s.share() <= kLargestShare && s.inner_length_px >= least_run &&
         static_cast<double>(s.num_ends) * least_run <= s.inner_length_px;
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
    if (above < kLeastShare * static_cast<double>(area)) return false;  // Thinning is what costs.
    found.thresholds[i] = threshold;
    found.masks[i] = lines_at(contrast, threshold, scale.least_area);
    const ImageU8& mask = found.masks[i];
    if (static_cast<double>(mask.num_pixels() - std::count(mask.values().begin(), mask.values().end(), 0)) >
        kLargestShare * static_cast<double>(area))
      return false;
    found.structures[i] = measure_structure(mask, source.mask, source.quarter, scale.structure, control);
    return are_lines(found.structures[i], scale.least_run);
  };
  for (int k = 0; k <= kMostHalvings; ++k) {
    for (const int power : {k, -k}) {
      const double factor = std::exp2(power / 2.0);
      if (fits(1, factor) && fits(0, factor) && fits(2, factor)) return found;
      if (k == 0) break;
    }
  }
  return std::nullopt;
}

Structures measured(const std::vector<Ground>& charts, const SourceLines& lines, const LineScale& scale,
                    const RunControl& control) {
  Structures out;
  for (const Ground& chart : charts) {
    const ImageF contrast = line_contrast(chart.lightness, chart.mask, lines.kind, scale.reach, control);
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] += measure_structure(lines_at(contrast, lines.thresholds[i], scale.least_area), chart.mask, chart.quarter,
                                  scale.structure, control);
  }
  return out;
}

/// What is found in charts that show the source as it is.
struct CutSource {
  Structures structures;
  /// By threshold: area of lines that is found there, over what of the source's lines lies there. Along the border of a
  /// chart half of what surrounds a line is missing, so that narrow charts show fewer than they have.
  std::array<double, kThresholds.size()> found = {};
};

/// The charts cut out of the source: each from one of its corners, few charts from all four. Of larger charts, what
/// fits.
CutSource measured_crops(const std::vector<Ground>& charts, const Ground& source, const SourceLines& lines,
                         const LineScale& scale, const RunControl& control) {
  CutSource out;
  std::array<std::int64_t, kThresholds.size()> found = {}, there = {};
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const ImageU8& chart = charts[c].mask;
    const int w = std::min(chart.width(), source.lightness.width()),
              h = std::min(chart.height(), source.lightness.height());
    const int spare_x = source.lightness.width() - w, spare_y = source.lightness.height() - h;
    for (std::size_t k = 0; k < (charts.size() < kFewCharts ? 4u : 1u); ++k) {
      const std::size_t corner = (c + k) % 4;
      const int x0 = corner % 2 == 0 ? 0 : spare_x, y0 = corner / 2 == 0 ? 0 : spare_y;
      ImageU8 mask = crop(chart, (chart.width() - w) / 2, (chart.height() - h) / 2, w, h);
      for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
          if (!is_inside(source.mask, x0 + x, y0 + y)) mask.at(x, y) = 0;
        }
      }
      const ImageF contrast =
          line_contrast(crop(source.lightness, x0, y0, w, h), mask, lines.kind, scale.reach, control);
      for (std::size_t i = 0; i < found.size(); ++i) {
        const ImageU8 own = crop(lines.masks[i], x0, y0, w, h),
                      seen = lines_at(contrast, lines.thresholds[i], scale.least_area);
        out.structures[i] += measure_structure(seen, mask, {}, scale.structure, control);
        for (std::int64_t p = 0; p < mask.num_pixels(); ++p) {
          there[i] += mask.data()[p] != 0 && own.data()[p] != 0;
          found[i] += mask.data()[p] != 0 && seen.data()[p] != 0;
        }
      }
    }
  }
  for (std::size_t i = 0; i < found.size(); ++i)
    out.found[i] = there[i] > 0 ? static_cast<double>(found[i]) / static_cast<double>(there[i]) : 1.0;
  return out;
}

/// One of the figures: how it is read from sums.
struct LineFigure {
  std::string name, title, unit, undefined;
  std::function<std::optional<double>(const LineStructure&)> value;
};

std::vector<LineFigure> figures_at(double texel_mm, bool has_quarters) {
  const double mm = texel_mm, mm2 = mm * mm;
  const auto over = [](double a, double b) { return b > 0.0 ? std::optional(a / b) : std::nullopt; };
  const auto times = [](std::optional<double> v, double f) { return v ? std::optional(*v * f) : std::nullopt; };
  std::vector<LineFigure> list = {{"line_share", "share of the area", "", "nothing is covered",
                                   [](const auto& s) { return std::optional(s.share()); }},
                                  {"dead_ends", "dead ends", "1/mm", "no lines are away from borders",
                                   [=](const auto& s) { return times(s.ends_per_px(), 1.0 / mm); }},
                                  {"closed_share", "area in closed cells", "", "nothing is covered",
                                   [](const auto& s) { return std::optional(s.closed_share()); }},
                                  {"line_length", "length", "mm/mm2", "nothing is covered",
                                   [=](const auto& s) { return over(s.length_px, s.surface_px * mm); }},
                                  {"median_cell", "closed cell, median", "mm2", "there are no closed cells",
                                   [=](const auto& s) { return times(s.median_cell_px(), mm2); }}};
  list.push_back({"junctions", "junctions", "1/mm2", "nothing is covered",
                  [=](const auto& s) { return over(static_cast<double>(s.num_junctions), s.surface_px * mm2); }});
  for (std::size_t q = 0; q < 4 && has_quarters; ++q) {
    list.push_back({"line_length_q" + std::to_string(q + 1),
                    "length where the control is in the source's quarter " + std::to_string(q + 1), "mm/mm2",
                    "no control is in that quarter",
                    [=](const auto& s) { return over(s.quarter_length_px[q], s.quarter_surface_px[q] * mm); }});
  }
  return list;
}

Figure one_figure(const std::string& name, const std::string& title, const LineFigure& f, std::optional<double> value,
                  std::optional<double> split) {
  return {.name = name,
          .title = title,
          .unit = f.unit,
          .value = value,
          .split = split,
          .undefined = value ? "" : f.undefined};
}

/// Over thresholds at which both sides have a value, or else each over its own.
std::array<std::optional<double>, 2> means_of(const LineFigure& f, const Structures& a, const Structures& b) {
  std::array<double, 4> sums = {};
  std::array<int, 4> counts = {};
  const auto add = [&](std::size_t to, double v) {
    sums[to] += v;
    ++counts[to];
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::optional<double> x = f.value(a[i]), y = f.value(b[i]);
    if (x && y) {
      add(0, *x);
      add(1, *y);
    }
    if (x) add(2, *x);
    if (y) add(3, *y);
  }
  const auto mean = [&](std::size_t i) { return counts[i] > 0 ? std::optional(sums[i] / counts[i]) : std::nullopt; };
  return counts[0] > 0 ? std::array{mean(0), mean(1)} : std::array{mean(2), mean(3)};
}

/// By threshold: share of the area where lines are as frequent as in the source; nothing without controls.
using WantedShares = std::array<std::optional<double>, kThresholds.size()>;

Figure wanted_figure(const std::string& prefix, const std::string& title, std::optional<double> value) {
  return {.name = prefix + "line_share_wanted",
          .title = title,
          .unit = "",
          .value = value,
          .undefined = value ? "" : "no control is known on both sides"};
}

std::optional<double> mean_of(const WantedShares& shares) {
  double sum = 0.0;
  for (const std::optional<double>& share : shares) {
    if (!share) return std::nullopt;
    sum += *share / static_cast<double>(shares.size());
  }
  return sum;
}

void add_figures(const SourceLines& source, const Structures& made, const Structures& crops, const WantedShares& wanted,
                 double texel_mm, bool has_quarters, StructureFigures& out) {
  const bool is_dark = source.kind == LineKind::Dark;
  const std::string prefix = is_dark ? "" : "bright_", kind = is_dark ? "Dark lines" : "Bright lines";
  std::string at;
  for (const double t : source.thresholds) at += (at.empty() ? "" : ", ") + short_number_text(t);
  const auto named = [&](const LineFigure& f, const std::string& suffix) { return prefix + f.name + suffix; };
  std::array<LineFigures, kThresholds.size()> apart;
  for (std::size_t i = 0; i < apart.size(); ++i) apart[i] = {source.kind, source.thresholds[i], {}};
  for (const LineFigure& f : figures_at(texel_mm, has_quarters)) {
    const auto title = [&](const std::string& of, const std::string& where) {
      return kind + ", " + f.title + of + " (M11, " + where + " L*)";
    };
    const bool has_crops = f.name == "dead_ends" || f.name == "closed_share" || f.name == "median_cell";
    const std::string cut = " of the source cut to the same charts";
    const auto [value, split] = means_of(f, made, source.structures);
    out.figures.push_back(one_figure(named(f, ""), title("", "mean at " + at), f, value, split));
    if (has_crops)
      out.figures.push_back(
          one_figure(named(f, "_crops"), title(cut, "mean at " + at), f, means_of(f, crops, crops)[0], {}));
    const std::string as_wanted = " if they were as frequent as in the source where the same control is wanted";
    if (f.name == "line_share")
      out.figures.push_back(wanted_figure(prefix, title(as_wanted, "mean at " + at), mean_of(wanted)));
    for (std::size_t i = 0; i < apart.size(); ++i) {
      const std::string where = short_number_text(source.thresholds[i]);
      apart[i].figures.push_back(
          one_figure(named(f, ""), title("", where), f, f.value(made[i]), f.value(source.structures[i])));
      if (has_crops)
        apart[i].figures.push_back(one_figure(named(f, "_crops"), title(cut, where), f, f.value(crops[i]), {}));
      if (f.name == "line_share") apart[i].figures.push_back(wanted_figure(prefix, title(as_wanted, where), wanted[i]));
    }
  }
  out.lines.insert(out.lines.end(), apart.begin(), apart.end());
}

/// Center lines at the middle threshold, and what ends without meeting another.
Picture picture_of(const std::vector<Ground>& charts, const SourceLines& lines, const TexelMap& surface,
                   const LineScale& scale, const RunControl& control) {
  constexpr int kDot = 2;
  const bool is_dark = lines.kind == LineKind::Dark;
  ImageF image(surface.width(), surface.height(), 3, 0.18f);
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

}  // namespace

StructureFigures measure_lines(const SynthesisSource& source, const SynthesizedMap& map, const SourceIndices& indices,
                               double texel_size_px, const RunControl& control) {
  const double pixels_per_texel = rounded(texel_size_px, kScaleDigits);
  const LineScale scale(pixels_per_texel);
  const TexelMap& surface = *map.surface;
  const double texel_mm = surface.median_texel_size_mm();
  const bool has_quarters = !source.control.empty() && !map.control.empty();
  const std::array<float, 3> ends = has_quarters ? quarters_of(source.control, source.mask) : std::array<float, 3>{};
  const ImageF lightness = lightness_of(source.frames.back());
  const ImageU8 quarter = has_quarters ? in_quarters(source.control, ends) : ImageU8();
  const Ground ground{at_texels(lightness, pixels_per_texel), at_texels(source.mask, pixels_per_texel),
                      at_texels(quarter, pixels_per_texel)};
  const ImageF seen_control = has_quarters ? at_texels(source.control, pixels_per_texel) : ImageF();
  StructureFigures out;
  std::vector<Ground> charts;
  for (const LineKind kind : {LineKind::Dark, LineKind::Bright}) {
    const std::optional<SourceLines> lines = lines_of(ground, kind, scale, control);
    if (!lines) continue;
    if (charts.empty()) {
      ImageF made(surface.width(), surface.height());
      for (TexelId t = 0; t < surface.num_texels(); ++t) {
        if (indices.of(t) >= 0) made.data()[t] = lightness.data()[indices.of(t)];
      }
      charts = charts_of(surface, made, has_quarters ? in_quarters(map.control, ends) : ImageU8());
    }
    const CutSource cut = measured_crops(charts, ground, *lines, scale, control);
    WantedShares wanted;
    for (std::size_t i = 0; i < wanted.size() && has_quarters; ++i) {
      wanted[i] = wanted_share(lines->masks[i], seen_control, ground.mask, surface, map.control);
      if (wanted[i]) *wanted[i] *= cut.found[i];
    }
    add_figures(*lines, measured(charts, *lines, scale, control), cut.structures, wanted, texel_mm, has_quarters, out);
    out.pictures.push_back(picture_of(charts, *lines, surface, scale, control));
  }
  const bool has_dark = !out.lines.empty() && out.lines.front().kind == LineKind::Dark;
  if (has_dark) return out;
  std::vector<Figure> none;
  for (const LineFigure& f : figures_at(texel_mm, false)) {
    none.push_back({.name = f.name,
                    .title = "Dark lines, " + f.title + " (M11)",
                    .unit = f.unit,
                    .undefined = out.lines.empty() ? "the source has no lines" : "the source has no dark lines"});
  }
  out.figures.insert(out.figures.begin(), none.begin(), none.end());
  return out;
}

}  // namespace patinate::analysis
