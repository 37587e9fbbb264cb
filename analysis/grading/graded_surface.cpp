#include "analysis/grading/graded_surface.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "analysis/cracks/line_mask.h"
#include "analysis/figures/color_stack.h"
#include "analysis/grading/labeled_rust.h"
#include "analysis/grading/panel_mask.h"
#include "analysis/grading/region_figures.h"
#include "analysis/grading/relief_marks.h"
#include "analysis/grading/rust_map.h"
#include "analysis/grading/scribe_finder.h"
#include "analysis/grading/surface_forecast.h"
#include "libcommon/core/text.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/history/history_sampling.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kShownTimes = 4;
constexpr float kPlainLightness = 50.0f;  // Lightness that no crack changes.

constexpr double kMinSlenderness = 4.0;  // Length of a crack over its mean width.

/// Rust, with the pixels around it, is no crack.
constexpr int kRustMargin_px = 3;

bool is_empty(const ImageU8& mask) {
  return std::none_of(mask.values().begin(), mask.values().end(), [](std::uint8_t v) { return v != 0; });
}

/// Changes of lightness from the unexposed surface, around kPlainLightness.
ImageF lightness_change(const ImageF& before, const ImageF& now) {
  ImageF out(now.width(), now.height());
  const auto lightness = [](const ImageF& image, std::int64_t i) {
    const float* c = image.data() + 3 * i;
    return lab_from_linear(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]))[0];
  };
  for (std::int64_t i = 0; i < now.num_pixels(); ++i)
    out.data()[i] = kPlainLightness + static_cast<float>(lightness(now, i) - lightness(before, i));
  return out;
}

/// Dark specks are no cracks: a crack's box has a diagonal of at least four times its mean width.
ImageU8 long_ones(const ImageU8& cracks) {
  cv::Mat mask(cracks.height(), cracks.width(), CV_8U), labels, stats, centers;
  std::copy(cracks.values().begin(), cracks.values().end(), mask.begin<std::uint8_t>());
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centers, 8);
  std::vector<char> is_long(static_cast<std::size_t>(count), 0);
  for (int k = 1; k < count; ++k) {
    const double w = stats.at<int>(k, cv::CC_STAT_WIDTH), h = stats.at<int>(k, cv::CC_STAT_HEIGHT);
    is_long[static_cast<std::size_t>(k)] = w * w + h * h >= kMinSlenderness * stats.at<int>(k, cv::CC_STAT_AREA);
  }
  ImageU8 out = cracks;
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      if (!is_long[static_cast<std::size_t>(labels.at<int>(y, x))]) out.at(x, y) = 0;
    }
  }
  return out;
}

ImageU8 cracks_of(const ImageF& before, const ImageF& now, const ImageU8& mask, const ImageF& rust, int reach_px) {
  ImageU8 bare = mask;
  for (int y = 0; y < bare.height(); ++y) {
    for (int x = 0; x < bare.width(); ++x) {
      if (!(rust.at(x, y) > 0.5f)) continue;
      for (int j = std::max(0, y - kRustMargin_px); j <= std::min(bare.height() - 1, y + kRustMargin_px); ++j) {
        for (int i = std::max(0, x - kRustMargin_px); i <= std::min(bare.width() - 1, x + kRustMargin_px); ++i)
          bare.at(i, j) = 0;
      }
    }
  }
  if (is_empty(bare)) return {bare.width(), bare.height()};
  return long_ones(find_cracks(lightness_change(before, now), bare, {.reach_px = reach_px}));
}

std::vector<GradeRegion> whole_sample(const ImageU8& mask, std::optional<double> pixel_mm, double edge_mm) {
  if (!pixel_mm || !(edge_mm > 0.0)) return {{"sample", mask}};
  ImageU8 inner = without_edge(mask, edge_mm / *pixel_mm);
  if (is_empty(inner))
    throw InvalidInput("grade: an edge of " + short_number_text(edge_mm) + " mm leaves nothing of a sample of " +
                       short_number_text(mask.width() * *pixel_mm) + " x " +
                       short_number_text(mask.height() * *pixel_mm) + " mm; state a smaller --edge-mm");
  return {{"sample", std::move(inner)}};
}

/// A scribe that lies beside the sample would creep by nothing, which is the best grade.
void require_on_sample(const Scribe& scribe, const ImageU8& mask, double pixel_mm) {
  for (const auto& [x_mm, y_mm] : {std::pair(scribe.x0, scribe.y0), std::pair(scribe.x1, scribe.y1)}) {
    const double x = std::floor(x_mm / pixel_mm), y = std::floor(y_mm / pixel_mm);
    const bool is_inside = x >= 0.0 && y >= 0.0 && x < mask.width() && y < mask.height() &&
                           mask.at(static_cast<int>(x), static_cast<int>(y)) != 0;
    if (!is_inside)
      throw InvalidInput("the scribe: its end " + short_number_text(x_mm) + "," + short_number_text(y_mm) +
                         " mm lies outside of the sample; the picture is " +
                         short_number_text(mask.width() * pixel_mm) + " x " +
                         short_number_text(mask.height() * pixel_mm) + " mm");
  }
}

/// @param before  The unexposed photograph.
std::vector<Scribe> scribes_of(const ScribeRequest& request, const ImageF& before, const ImageU8& mask,
                               std::optional<double> pixel_mm) {
  if (!request.is_wanted || !pixel_mm) return {};
  for (const Scribe& scribe : request.given) require_on_sample(scribe, mask, *pixel_mm);
  if (!request.given.empty()) return request.given;
  const std::vector<Scribe> found = find_scribes(before, mask, *pixel_mm);
  if (found.empty())
    throw InvalidInput(
        "the scribe: no straight scratch was found in the unexposed photograph; give its ends and width in mm");
  return found;
}

std::string scribe_text(const Scribe& s) {
  std::string text;
  for (const double v : {s.x0, s.y0, s.x1, s.y1, s.width_mm})
    text += (text.empty() ? "" : ",") + number_text(rounded(v, 2));
  return text;
}

void restrict_regions(std::vector<GradeRegion>& regions, const ImageU8& mask) {
  std::vector<int> owner(mask.values().size(), -1);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    GradeRegion& region = regions[r];
    for (std::size_t k = 0; k < r; ++k) {
      if (regions[k].name == region.name) throw InvalidInput("region " + region.name + ": is given twice");
    }
    if (!region.mask.same_size(mask))
      throw InvalidInput("region " + region.name + ": has " + size_text(region.mask.width(), region.mask.height()) +
                         " pixels; the history has " + size_text(mask.width(), mask.height()));
    for (std::size_t i = 0; i < owner.size(); ++i) {
      std::uint8_t& inside = region.mask.data()[i];
      if (inside == 0) continue;
      if (owner[i] >= 0)
        throw InvalidInput("region " + region.name + ": lies over region " +
                           regions[static_cast<std::size_t>(owner[i])].name + "; regions have no pixel in common");
      owner[i] = static_cast<int>(r);
      inside &= mask.data()[i];
    }
    if (is_empty(region.mask)) throw InvalidInput("region " + region.name + ": holds nothing of the sample");
  }
}

/// A scratch, and a pixel beside it.
bool is_on_scribe(const Scribe& scribe, double pixel_mm, std::size_t pixel, int width) {
  const double x = (static_cast<double>(pixel % static_cast<std::size_t>(width)) + 0.5) * pixel_mm,
               y = (static_cast<double>(pixel / static_cast<std::size_t>(width)) + 0.5) * pixel_mm;
  const double dx = scribe.x1 - scribe.x0, dy = scribe.y1 - scribe.y0, length = std::hypot(dx, dy);
  const double along = std::clamp(((x - scribe.x0) * dx + (y - scribe.y0) * dy) / (length * length), 0.0, 1.0);
  return std::hypot(x - scribe.x0 - along * dx, y - scribe.y0 - along * dy) <= 0.5 * scribe.width_mm + pixel_mm;
}

/// A scratch is no crack, nor are its edges.
ImageU8 without_scribes(ImageU8 mask, const std::vector<Scribe>& scribes, double pixel_mm) {
  for (Scribe scribe : scribes) {
    scribe.width_mm += 2.0 * kRustMargin_px * pixel_mm;
    for (std::size_t i = 0; i < mask.values().size(); ++i) {
      if (is_on_scribe(scribe, pixel_mm, i, mask.width())) mask.data()[i] = 0;
    }
  }
  return mask;
}

/// Rust that spreads from a scribe is creep, and no rust of the surface.
RustFrame without_creep(RustFrame rust, const std::vector<Scribe>& scribes, double pixel_mm) {
  if (scribes.empty()) return rust;
  const auto is_on_any = [&](std::size_t pixel) {
    return std::any_of(scribes.begin(), scribes.end(), [&](const Scribe& scribe) {
      return is_on_scribe(scribe, pixel_mm, pixel, rust.coverage.width());
    });
  };
  std::vector<char> is_creep(rust.spots.size(), 0);
  for (std::size_t i = 0; i < rust.labels.size(); ++i) {
    if (rust.labels[i] >= 0 && is_on_any(i)) is_creep[static_cast<std::size_t>(rust.labels[i])] = 1;
  }
  for (int& label : rust.labels) {
    if (label >= 0 && is_creep[static_cast<std::size_t>(label)]) label = -1;
  }
  return rust;
}

/// Every photograph knows its heights; a map that is constant in time is the shape of the sample.
bool has_heights(const HistoryFacts& facts) {
  return std::all_of(facts.frames.begin(), facts.frames.end(), [](const FrameFacts& f) {
    return std::find(f.extras.begin(), f.extras.end(), "height") != f.extras.end();
  });
}

/// By kind.
std::array<ReliefMarks, 2> relief_of(const ImageF& before, const ImageF& now, const ImageU8& mask) {
  const ImageF change = height_change(before, now, mask);
  return {find_relief_marks(change, mask, ReliefKind::Blister), find_relief_marks(change, mask, ReliefKind::Flake)};
}

GradedRegion begun(const GradeRegion& region, std::optional<double> pixel_mm, const RustRule& rule) {
  GradedRegion out{.name = region.name};
  for (const std::uint8_t v : region.mask.values()) out.num_pixels += v != 0 ? 1 : 0;
  if (pixel_mm) out.area_mm2 = static_cast<double>(out.num_pixels) * *pixel_mm * *pixel_mm;
  out.seen_from_percent = 100.0 * rule.least_area_px / static_cast<double>(out.num_pixels);
  return out;
}

}  // namespace

void describe(OptionVisitor& v, GradeOptions& o) {
  v.visit({"edge_mm", "Width of the band along the edge of the whole sample that is left out", "mm", between(0, 1000)},
          o.edge_mm);
  v.visit({"unexposed", "Time of the photograph that shows the unexposed surface; without: the first"}, o.unexposed);
  v.visit({"crack_reach", "Half the width of the widest crack", "px", between(1, 100)}, o.crack_reach_px);
  v.visit({"forecast", "Time after the last photograph to which figures are forecast; without: none are"}, o.forecast);
}

GradedSurface grade_surface(const TextureSeries& series, GradeRequest request, const RunControl& control) {
  std::vector<GradeRegion>& regions = request.regions;
  const GradeOptions& options = request.options;
  GradedSurface out;
  for (const FrameFacts& frame : series.facts().frames) out.times.push_back(frame.time);
  out.pixel_mm = series.pixel_mm();
  const ImageU8 mask = common_mask(series, out.times);
  if (is_empty(mask)) throw InvalidInput(series.name() + ": no pixel shows the surface in every photograph");
  std::size_t unexposed = 0;
  if (options.unexposed) {
    const auto found = std::find(out.times.begin(), out.times.end(), *options.unexposed);
    if (found == out.times.end())
      throw InvalidInput("--unexposed: no photograph has the time " + number_text(*options.unexposed));
    unexposed = static_cast<std::size_t>(found - out.times.begin());
  }
  const ImageF before = series.sample(out.times[unexposed]);
  out.scribes = scribes_of(request.scribe, before, mask, out.pixel_mm);
  for (const Scribe& scribe : out.scribes) {
    if (request.scribe.given.empty())
      out.notes.push_back("the scribe was found: " + scribe_text(scribe) + " (its ends and width in mm)");
  }
  if (!request.scribe.is_wanted && out.pixel_mm && out.times.size() > 1 &&
      !find_scribes(before, mask, *out.pixel_mm).empty())
    out.notes.emplace_back(
        "the unexposed photograph shows a straight scratch, whose rust counts as that of the surface; --scribe auto "
        "measures creep from it");
  const bool has_unexposed = out.times.size() > 1;
  if (has_unexposed) out.unexposed_time = out.times[unexposed];
  if (!has_unexposed)
    out.notes.emplace_back(
        "one photograph: nothing tells the unexposed surface, so that changes of color, cracks and times are not "
        "given");
  if (!out.pixel_mm)
    out.notes.emplace_back(
        "the size of a pixel is not known: shares and colors are given, lengths are not, and no edge was left out");
  if (regions.empty()) {
    regions = whole_sample(mask, out.pixel_mm, options.edge_mm);
    if (out.pixel_mm) out.edge_mm = options.edge_mm;
  } else {
    restrict_regions(regions, mask);
  }
  const RustRule rule = request.labels.empty() ? request.rust
                                               : labeled_rust_rule(request.rust, has_unexposed ? before : ImageF(),
                                                                   series.sample(out.times.back()), request.labels);
  for (const GradeRegion& region : regions) out.regions.push_back(begun(region, out.pixel_mm, rule));

  const RustMap map({.num_frames = static_cast<int>(out.times.size()),
                     .color = [&](int t) { return series.sample(out.times[static_cast<std::size_t>(t)]); },
                     .mask = mask,
                     .unexposed = has_unexposed ? std::optional(static_cast<int>(unexposed)) : std::nullopt},
                    rule, control.part(0.0, 0.5));
  const std::vector<MaterialMap> maps = material_maps(series.facts());
  const bool has_gloss = std::find(maps.begin(), maps.end(), MaterialMap::Roughness) != maps.end();
  const auto height_at = [&](std::size_t t) {
    return series.on_surface(sample_material_map(series.history(), MaterialMap::Height, out.times[t], Between::Blend));
  };
  const bool has_relief = out.pixel_mm && has_heights(series.facts());
  const ImageF height_before = has_relief && has_unexposed ? height_at(unexposed) : ImageF();
  const ImageU8 coated = without_scribes(mask, out.scribes, out.pixel_mm.value_or(1.0));
  const std::size_t shown_step = std::max<std::size_t>(1, (out.times.size() + kShownTimes - 2) / (kShownTimes - 1));
  for (std::size_t t = 0; t < out.times.size(); ++t) {
    const RustFrame rust = map.at(static_cast<int>(t));
    const RustFrame counted = without_creep(rust, out.scribes, out.pixel_mm.value_or(1.0));
    const ImageF now = series.sample(out.times[t]);
    ImageF f0, roughness;
    if (has_gloss) {
      f0 =
          series.on_surface(sample_material_map(series.history(), MaterialMap::Specular, out.times[t], Between::Blend));
      roughness = series.on_surface(
          sample_material_map(series.history(), MaterialMap::Roughness, out.times[t], Between::Blend));
    }
    ImageU8 cracks;
    if (has_unexposed && out.pixel_mm && t != unexposed)
      cracks = cracks_of(before, now, coated, rust.coverage, options.crack_reach_px);
    std::array<ReliefMarks, 2> relief;
    if (has_relief) relief = relief_of(height_before, height_at(t), coated);
    for (std::size_t r = 0; r < regions.size(); ++r) {
      const ImageU8& region = regions[r].mask;
      RegionFigures& figures = out.regions[r].times.emplace_back();
      add_rust_figures(counted, region, out.pixel_mm, rule, figures);
      if (has_unexposed) add_color_figures(before, now, rust.coverage, cracks, region, figures);
      if (has_gloss) add_gloss_figures(f0, roughness, rust.coverage, cracks, region, figures);
      if (has_unexposed && out.pixel_mm) add_crack_figures(cracks, region, *out.pixel_mm, figures);
      if (has_relief) add_relief_figures(relief[0], relief[1], rust.coverage, region, *out.pixel_mm, figures);
      if (!out.scribes.empty()) add_creep_figures(rust.coverage, region, *out.pixel_mm, out.scribes, figures);
    }
    if (t % shown_step == 0 || t + 1 == out.times.size()) {
      out.shown.push_back({t, now, rust.coverage, cracks});
      if (has_relief) out.shown.back().marks = {std::move(relief[0].labels), std::move(relief[1].labels)};
    }
    control.report(0.5 + 0.5 * static_cast<double>(t + 1) / static_cast<double>(out.times.size()));
    control.throw_if_stopped();
  }
  for (GradedRegion& region : out.regions) keep_from_falling(region);
  if (options.forecast) add_forecasts(*options.forecast, out);
  return out;
}

}  // namespace patinate::analysis
