#include "analysis/grading/region_figures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "analysis/cracks/crack_network.h"
#include "analysis/grading/gloss_units.h"
#include "libcommon/core/median.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/metrics/difference.h"

namespace patinate::analysis {

namespace {

// Uncertainties of areas, chosen on drawn panels (docs/algorithms/grading.md): how far a spot's opacity is off, rim and
// core having other colors; and the share of a spot that is hardly larger than the blur, whose own color nobody sees.
constexpr double kColorUncertainty = 0.04;
constexpr double kSmallUncertainty = 0.3;
constexpr double kSmall_px = 16.0;
constexpr double kCleanRust = 0.05;       // Coverage up to which a pixel shows the coating.
constexpr double kMaxOfRust = 0.8;        // Share of the rusted area that decides its distribution [ours].
constexpr double kFewOfRust = 0.2;        ///< H of ASTM D610 from here on (docs/algorithms/grading.md).
constexpr int kDistributionSquares = 10;  // Along the longer side of the region.
constexpr double kLocalizedShare = 0.1;   // Share of the squares of the region: rust there alone is localized.
constexpr double kRusted = 0.5;           ///< Coverage from which a pixel is rusted.
constexpr int kCreepPlaces = 60;          // Along the scribe; the standard asks for six or more.
constexpr double kScribeEnds = 0.1;       // Share of the scribe at each end that is left out.

std::optional<GradedFigure>& slot(RegionFigures& figures, std::string_view name) {
  const auto at = std::find(kGradedFigureNames.begin(), kGradedFigureNames.end(), name) - kGradedFigureNames.begin();
  return figures.figures[static_cast<std::size_t>(at)];
}

void set_exact(RegionFigures& figures, std::string_view name, double value) {
  slot(figures, name) = GradedFigure{value, value, value};
}

/// Part of a spot that lies in the region.
struct InRegion {
  double area_px = 0.0;
  double x = 0.0, y = 0.0;
};

/// Rust is localized where so much of it lies in so few squares of the region.
bool is_localized(const std::map<int, InRegion>& spots, const ImageU8& region) {
  const int square = std::max(1, std::max(region.width(), region.height()) / kDistributionSquares);
  const int columns = region.width() / square + 1;
  std::set<int> squares;
  for (int y = 0; y < region.height(); ++y) {
    for (int x = 0; x < region.width(); ++x) {
      if (region.at(x, y) != 0) squares.insert(y / square * columns + x / square);
    }
  }
  std::map<int, double> areas;
  double all = 0.0;
  for (const auto& [label, spot] : spots) {
    areas[static_cast<int>(spot.y) / square * columns + static_cast<int>(spot.x) / square] += spot.area_px;
    all += spot.area_px;
  }
  std::vector<double> sorted;
  for (const auto& [at, area] : areas) sorted.push_back(area);
  std::sort(sorted.rbegin(), sorted.rend());
  const auto few = static_cast<std::size_t>(std::ceil(kLocalizedShare * static_cast<double>(squares.size())));
  double sum = 0.0;
  for (std::size_t k = 0; k < std::min(few, sorted.size()); ++k) sum += sorted[k];
  return sum >= kMaxOfRust * all;
}

double diameter_mm(double area_px, double pixel_mm) { return 2.0 * std::sqrt(area_px / std::numbers::pi) * pixel_mm; }

/// The letter of ASTM D610, by shares of the rusted area.
std::string distribution_of(const std::map<int, InRegion>& spots, const ImageU8& region, double pixel_mm,
                            double pinpoint_mm) {
  double all = 0.0, pinpoints = 0.0;
  for (const auto& [label, spot] : spots) {
    all += spot.area_px;
    if (diameter_mm(spot.area_px, pixel_mm) < pinpoint_mm) pinpoints += spot.area_px;
  }
  if (pinpoints >= kMaxOfRust * all) return "P";
  if (pinpoints > kFewOfRust * all) return "H";
  return is_localized(spots, region) ? "S" : "G";
}

/// Medians: what stains tint is less than half of a coating that is measured.
std::array<double, 3> median_color(const ImageF& image, const std::vector<std::size_t>& pixels) {
  std::array<double, 3> color{};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const std::size_t i : pixels) values.push_back(static_cast<double>(image.data()[3 * i + c]));
    color[c] = median(std::move(values));
  }
  return color;
}

std::vector<std::size_t> clean_pixels(const ImageF& rust, const ImageU8& region) {
  std::vector<std::size_t> out;
  for (std::int64_t i = 0; i < region.num_pixels(); ++i) {
    if (region.data()[i] != 0 && static_cast<double>(rust.data()[i]) <= kCleanRust)
      out.push_back(static_cast<std::size_t>(i));
  }
  return out;
}

}  // namespace

const std::optional<GradedFigure>& RegionFigures::figure(std::string_view name) const {
  const auto at = std::find(kGradedFigureNames.begin(), kGradedFigureNames.end(), name) - kGradedFigureNames.begin();
  return figures[static_cast<std::size_t>(at)];
}

std::vector<std::optional<GradedFigure>> GradedRegion::series(std::string_view figure) const {
  std::vector<std::optional<GradedFigure>> out;
  for (const RegionFigures& time : times) out.push_back(time.figure(figure));
  return out;
}

void add_rust_figures(const RustFrame& rust, const ImageU8& region, std::optional<double> pixel_mm,
                      const RustRule& rule, RegionFigures& figures) {
  std::map<int, InRegion> spots;
  double all = 0.0;
  for (std::int64_t i = 0; i < region.num_pixels(); ++i) {
    if (region.data()[i] == 0) continue;
    all += 1.0;
    const int label = rust.labels[static_cast<std::size_t>(i)];
    if (label >= 0) spots[label].area_px += static_cast<double>(rust.coverage.data()[i]);
  }
  double area = 0.0, low = 0.0, high = 0.0, num_small = 0.0;
  std::map<int, InRegion> kept;
  for (auto& [label, spot] : spots) {
    const RustSpot& whole = rust.spots[static_cast<std::size_t>(label)];
    if (spot.area_px < 0.5) continue;  // Only its blur reaches into the region.
    spot.x = whole.x;
    spot.y = whole.y;
    const double edge = kEdgeUncertainty_px * whole.edge_px * std::min(1.0, spot.area_px / whole.area_px) +
                        (whole.area_px < kSmall_px ? kSmallUncertainty : kColorUncertainty) * spot.area_px;
    num_small += whole.area_px < kSmall_px ? 1.0 : 0.0;
    area += spot.area_px;
    if (whole.is_sure) low += std::max(0.0, spot.area_px - edge);
    high += spot.area_px + edge;
    kept[label] = spot;
  }
  // Spots below the least size may be there: one, and as many as there are small ones.
  high += rule.least_area_px * (1.0 + num_small);
  const double percent = 100.0 / all;
  slot(figures, "rusted_percent") = GradedFigure{area * percent, low * percent, std::min(100.0, high * percent)};
  figures.num_spots = static_cast<int>(kept.size());
  if (!pixel_mm || kept.empty()) return;
  double sum = 0.0;
  for (const auto& [label, spot] : kept) sum += diameter_mm(spot.area_px, *pixel_mm);
  figures.mean_spot_mm = sum / static_cast<double>(kept.size());
  figures.distribution = distribution_of(kept, region, *pixel_mm, rule.pinpoint_mm);
}

void add_color_figures(const ImageF& before, const ImageF& now, const ImageF& rust, const ImageU8& region,
                       RegionFigures& figures) {
  const std::vector<std::size_t> clean = clean_pixels(rust, region);
  if (clean.empty()) return;
  const std::array<double, 3> a = median_color(before, clean), b = median_color(now, clean);
  const std::array<double, 3> from = lab_from_linear(a[0], a[1], a[2]), to = lab_from_linear(b[0], b[1], b[2]);
  const double l = to[0] - from[0], da = to[1] - from[1], db = to[2] - from[2];
  set_exact(figures, "delta_e", std::sqrt(l * l + da * da + db * db));
  set_exact(figures, "ciede2000", ciede2000(from, to));
  set_exact(figures, "delta_l", l);
  set_exact(figures, "delta_a", da);
  set_exact(figures, "delta_b", db);
}

void add_gloss_figures(const ImageF& f0, const ImageF& roughness, const ImageF& rust, const ImageU8& region,
                       RegionFigures& figures) {
  std::vector<double> strengths, widths;
  for (const std::size_t i : clean_pixels(rust, region)) {
    if (!(roughness.data()[i] > 0.0f)) continue;
    strengths.push_back(static_cast<double>(f0.data()[i]));
    widths.push_back(static_cast<double>(roughness.data()[i]));
  }
  if (widths.empty()) return;
  const double strength = std::clamp(median(strengths), 0.0, 1.0), width = std::clamp(median(widths), 0.05, 1.0);
  set_exact(figures, "gloss_20", gloss_units(20, strength, width));
  set_exact(figures, "gloss_60", gloss_units(60, strength, width));
  set_exact(figures, "gloss_85", gloss_units(85, strength, width));
}

void add_crack_figures(const ImageU8& cracks, const ImageU8& region, double pixel_mm, RegionFigures& figures) {
  constexpr double kArm_px = 8.0;  // Length from a junction at which an arm's direction is measured.
  const CrackNetwork network = cracks.empty() ? CrackNetwork{} : measure_cracks(cracks, region, kArm_px);
  if (!(network.length_px > 0.0)) {
    set_exact(figures, "crack_mm_per_mm2", 0.0);
    set_exact(figures, "crack_width_mm", 0.0);
    return;
  }
  double all = 0.0;
  for (const std::uint8_t v : region.values()) all += v != 0 ? 1.0 : 0.0;
  set_exact(figures, "crack_mm_per_mm2", network.length_px / (all * pixel_mm));
  // The edges of a crack are known to half a pixel each.
  const double width = network.width_px().value_or(0.0) * pixel_mm;
  slot(figures, "crack_width_mm") = GradedFigure{width, std::max(0.0, width - pixel_mm), width + pixel_mm};
}

void add_relief_figures(const ReliefMarks& blisters, const ReliefMarks& flakes, const ImageF& rust,
                        const ImageU8& region, double pixel_mm, RegionFigures& figures) {
  const auto add = [&](const ReliefMarks& marks, bool is_blister, std::string_view area_name,
                       std::string_view size_name) {
    std::vector<double> inside(marks.marks.size(), 0.0), all = inside, rusted = inside;
    double num_pixels = 0.0;
    for (std::size_t i = 0; i < marks.labels.size(); ++i) {
      num_pixels += region.data()[i] != 0 ? 1.0 : 0.0;
      if (marks.labels[i] < 0) continue;
      const auto label = static_cast<std::size_t>(marks.labels[i]);
      all[label] += 1.0;
      inside[label] += region.data()[i] != 0 ? 1.0 : 0.0;
      rusted[label] += static_cast<double>(rust.data()[i]) >= kRusted ? 1.0 : 0.0;
    }
    GradedFigure area;
    double sizes = 0.0, count = 0.0;
    for (std::size_t k = 0; k < marks.marks.size(); ++k) {
      if (inside[k] == 0.0 || (is_blister && rusted[k] > 0.5 * all[k])) continue;
      const ReliefMark& mark = marks.marks[k];
      const double share = inside[k] / all[k];
      area.value += share * mark.area_px;
      area.low += share * std::max(0.0, mark.area_px - mark.uncertain_px);
      area.high += share * (mark.area_px + mark.uncertain_px);
      sizes += is_blister ? diameter_mm(mark.area_px, pixel_mm) : mark.longest_px * pixel_mm;
      count += 1.0;
    }
    for (double* end : {&area.value, &area.low, &area.high}) *end = std::min(100.0, 100.0 * *end / num_pixels);
    slot(figures, area_name) = area;
    const double size = count > 0.0 ? sizes / count : 0.0;
    // Both ends of a mark are known to half a pixel.
    slot(figures, size_name) =
        count > 0.0 ? GradedFigure{size, std::max(0.0, size - pixel_mm), size + pixel_mm} : GradedFigure{};
  };
  add(blisters, true, "blistered_percent", "blister_mm");
  add(flakes, false, "flaked_percent", "flake_mm");
}

void add_creep_figures(const ImageF& rust, const ImageU8& region, double pixel_mm, const Scribe& scribe,
                       RegionFigures& figures) {
  const double length = std::hypot(scribe.x1 - scribe.x0, scribe.y1 - scribe.y0);
  const double ux = (scribe.x1 - scribe.x0) / length, uy = (scribe.y1 - scribe.y0) / length;
  const auto is_rusted = [&](double x_mm, double y_mm) {
    const int x = static_cast<int>(std::floor(x_mm / pixel_mm)), y = static_cast<int>(std::floor(y_mm / pixel_mm));
    return rust.contains(x, y) && region.at(x, y) != 0 && static_cast<double>(rust.at(x, y)) >= kRusted;
  };
  const double step = 0.25 * pixel_mm, half = 0.5 * scribe.width_mm;
  double sum = 0.0, most = 0.0;
  for (int k = 0; k < kCreepPlaces; ++k) {
    const double along = length * (kScribeEnds + (1.0 - 2.0 * kScribeEnds) * (k + 0.5) / kCreepPlaces);
    const double x = scribe.x0 + along * ux, y = scribe.y0 + along * uy;
    double width = 0.0;
    for (const double side : {-1.0, 1.0}) {
      double reach = half;
      while (is_rusted(x - side * (reach + step) * uy, y + side * (reach + step) * ux)) reach += step;
      width += reach - half;
      most = std::max(most, reach - half);
    }
    sum += 0.5 * width;
  }
  // A pixel's edge is known to half of it at each place; places err together.
  const double mean = sum / kCreepPlaces, uncertain = 0.5 * pixel_mm;
  slot(figures, "creep_mm") = GradedFigure{mean, std::max(0.0, mean - uncertain), mean + uncertain};
  slot(figures, "creep_max_mm") = GradedFigure{most, std::max(0.0, most - uncertain), most + uncertain};
}

}  // namespace patinate::analysis
