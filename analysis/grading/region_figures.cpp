#include "analysis/grading/region_figures.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "analysis/cracks/crack_network.h"
#include "analysis/grading/gloss_units.h"
#include "libcommon/core/median.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/geometry/mesh.h"
#include "patinate/metrics/difference.h"

namespace patinate::analysis {

namespace {

// Uncertainties of areas, chosen on drawn panels (docs/algorithms/grading.md): how far a spot's opacity is off, rim and
// core having other colors; and the share of a spot that is hardly larger than the blur, whose own color nobody sees.
constexpr double kColorUncertainty = 0.04;
constexpr double kSmallUncertainty = 0.3;
constexpr double kSmall_px = 16.0;
constexpr double kCleanRust = 0.05;       // Coverage up to which a pixel shows the coating.
constexpr int kCrackRim_px = 2;           // Blurred edges of cracks are darker than the coating.
constexpr int kPlacesAlong = 4;           // Places of a region, along each side of its box.
constexpr double kMinPlaceShare = 0.5;    // Pixels of a place that counts, over those of a mean one.
constexpr double kConfidence = 0.9;       // Of intervals.
constexpr double kLengthError = 0.05;     // Largest error of the length of a line of pixels [Dorst and Smeulders 1987].
constexpr double kMaxOfRust = 0.8;        // Share of the rusted area that decides its distribution [ours].
constexpr double kFewOfRust = 0.2;        ///< H of ASTM D610 from here on (docs/algorithms/grading.md).
constexpr int kDistributionSquares = 10;  // Along the longer side of the region.
constexpr double kLocalizedShare = 0.1;   // Share of the squares of the region: rust there alone is localized.
constexpr double kRusted = 0.5;           ///< Coverage from which a pixel is rusted.
constexpr int kCreepPlaces = 60;          // Along a scribe; the standard asks for six or more.
constexpr double kScribeEnds = 0.1;       // Share of a scribe that is left out at each end and beside a crossing.

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

/// A pixel of the coating, and which of the region's places it lies in.
struct CleanPixel {
  std::size_t pixel = 0;
  int place = 0;
};

/// Pixels without rust and cracks.
std::vector<CleanPixel> clean_pixels(const ImageF& rust, const ImageU8& cracks, const ImageU8& region) {
  const auto is_near_crack = [&](int x, int y) {
    if (cracks.empty()) return false;
    for (int j = std::max(0, y - kCrackRim_px); j <= std::min(region.height() - 1, y + kCrackRim_px); ++j) {
      for (int i = std::max(0, x - kCrackRim_px); i <= std::min(region.width() - 1, x + kCrackRim_px); ++i) {
        if (cracks.at(i, j) != 0) return true;
      }
    }
    return false;
  };
  int left = region.width(), right = 0, top = region.height(), bottom = 0;
  for (int y = 0; y < region.height(); ++y) {
    for (int x = 0; x < region.width(); ++x) {
      if (region.at(x, y) == 0) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  std::vector<CleanPixel> out;
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      if (region.at(x, y) == 0 || static_cast<double>(rust.at(x, y)) > kCleanRust || is_near_crack(x, y)) continue;
      const int column = kPlacesAlong * (x - left) / (right - left + 1),
                row = kPlacesAlong * (y - top) / (bottom - top + 1);
      out.push_back({static_cast<std::size_t>(y) * region.width() + x, row * kPlacesAlong + column});
    }
  }
  return out;
}

/// @param channel  Of `channels`.
std::vector<double> values_of(const ImageF& image, const std::vector<std::size_t>& pixels, std::size_t channels,
                              std::size_t channel) {
  std::vector<double> values;
  values.reserve(pixels.size());
  for (const std::size_t i : pixels) values.push_back(static_cast<double>(image.data()[channels * i + channel]));
  return values;
}

/// Mean of the middle half: what stains tint is less than a quarter of a coating that is measured. A median of
/// photographs of 8 bits would be one of few values.
double middle_mean(std::vector<double> values) {
  const std::size_t n = values.size(), first = n / 4, last = n - 1 - n / 4;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(first), values.end());
  std::nth_element(values.begin() + static_cast<std::ptrdiff_t>(first),
                   values.begin() + static_cast<std::ptrdiff_t>(last), values.end());
  double sum = 0.0;
  for (std::size_t i = first; i <= last; ++i) sum += values[i];
  return sum / static_cast<double>(last - first + 1);
}

/// A value of all clean pixels, and an interval from the spread of the values of the region's places: the mean of
/// places, as a gauge that is set down several times reads them. @param value_of  Of some of the pixels.
template <class ValueOf>
GradedFigure figure_of_places(const std::vector<CleanPixel>& clean, const ValueOf& value_of) {
  std::vector<std::size_t> all;
  std::array<std::vector<std::size_t>, kPlacesAlong * kPlacesAlong> places;
  for (const CleanPixel& p : clean) {
    all.push_back(p.pixel);
    places[static_cast<std::size_t>(p.place)].push_back(p.pixel);
  }
  const double value = value_of(all);
  std::vector<double> values;
  for (const std::vector<std::size_t>& place : places) {
    if (static_cast<double>(place.size() * places.size()) >= kMinPlaceShare * static_cast<double>(all.size()))
      values.push_back(value_of(place));
  }
  const auto n = static_cast<double>(values.size());
  if (values.size() < 2) return {value, value, value};
  double mean = 0.0, squares = 0.0;
  for (const double v : values) mean += v / n;
  for (const double v : values) squares += (v - mean) * (v - mean);
  const double student = boost::math::quantile(boost::math::students_t(n - 1.0), 0.5 * (1.0 + kConfidence));
  const double half = student * std::sqrt(squares / (n - 1.0) / n);
  return {value, value - half, value + half};
}

Vec2 from_of(const Scribe& s) { return {s.x0, s.y0}; }
Vec2 way_of(const Scribe& s) { return Vec2(s.x1, s.y1) - from_of(s); }
double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Whether a place is nearer to another scribe than `distance`.
bool is_nearer_to_another(const Vec2& place, double distance, const Scribe& scribe,
                          const std::vector<Scribe>& scribes) {
  return std::any_of(scribes.begin(), scribes.end(), [&](const Scribe& other) {
    if (&other == &scribe) return false;
    const Vec2 way = way_of(other), beyond = place - from_of(other);
    const double along = std::clamp(beyond.dot(way) / way.squaredNorm(), 0.0, 1.0);
    return (beyond - along * way).norm() < distance;
  });
}

/// Where other scribes cross this one, as shares of its length.
std::vector<double> crossings_of(const Scribe& scribe, const std::vector<Scribe>& scribes) {
  std::vector<double> out;
  const Vec2 way = way_of(scribe);
  for (const Scribe& other : scribes) {
    const Vec2 other_way = way_of(other), between = from_of(other) - from_of(scribe);
    const double turn = cross(way, other_way);
    if (turn == 0.0) continue;  // Itself, or a parallel one.
    const double here = cross(between, other_way) / turn, there = cross(between, way) / turn;
    if (std::min(here, there) >= 0.0 && std::max(here, there) <= 1.0) out.push_back(here);
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

void add_color_figures(const ImageF& before, const ImageF& now, const ImageF& rust, const ImageU8& cracks,
                       const ImageU8& region, RegionFigures& figures) {
  const std::vector<CleanPixel> clean = clean_pixels(rust, cracks, region);
  if (clean.empty()) return;
  const auto lab_of = [](const ImageF& image, const std::vector<std::size_t>& pixels) {
    std::array<double, 3> color{};
    for (std::size_t c = 0; c < 3; ++c) color[c] = middle_mean(values_of(image, pixels, 3, c));
    return lab_from_linear(color[0], color[1], color[2]);
  };
  const auto set = [&](std::string_view name, bool is_difference, const auto& change) {
    GradedFigure figure = figure_of_places(clean, [&](const std::vector<std::size_t>& pixels) {
      return change(lab_of(before, pixels), lab_of(now, pixels));
    });
    if (is_difference) figure.low = std::max(0.0, figure.low);
    slot(figures, name) = figure;
  };
  set("delta_e", true,
      [](const auto& from, const auto& to) { return std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]); });
  set("ciede2000", true, [](const auto& from, const auto& to) { return ciede2000(from, to); });
  set("delta_l", false, [](const auto& from, const auto& to) { return to[0] - from[0]; });
  set("delta_a", false, [](const auto& from, const auto& to) { return to[1] - from[1]; });
  set("delta_b", false, [](const auto& from, const auto& to) { return to[2] - from[2]; });
}

void add_gloss_figures(const ImageF& f0, const ImageF& roughness, const ImageF& rust, const ImageU8& cracks,
                       const ImageU8& region, RegionFigures& figures) {
  std::vector<CleanPixel> clean = clean_pixels(rust, cracks, region);
  std::erase_if(clean, [&](const CleanPixel& p) { return !(roughness.data()[p.pixel] > 0.0f); });
  if (clean.empty()) return;
  for (const auto& [name, angle] : {std::pair("gloss_20", 20), std::pair("gloss_60", 60), std::pair("gloss_85", 85)}) {
    GradedFigure figure = figure_of_places(clean, [&](const std::vector<std::size_t>& pixels) {
      return gloss_units(angle, std::clamp(middle_mean(values_of(f0, pixels, 1, 0)), 0.0, 1.0),
                         std::clamp(middle_mean(values_of(roughness, pixels, 1, 0)), 0.05, 1.0));
    });
    figure.low = std::max(0.0, figure.low);
    slot(figures, name) = figure;
  }
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
  // A line of pixels is as long as its steps within kLengthError. Cracks hide parts of one another where they cross or
  // touch: of lines at random places the share that they cover.
  const double density = network.length_px / (all * pixel_mm), hidden = std::min(0.9, network.area_px / all);
  slot(figures, "crack_mm_per_mm2") =
      GradedFigure{density, (1.0 - kLengthError) * density, (1.0 + kLengthError) * density / (1.0 - hidden)};
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

void add_creep_figures(const ImageF& rust, const ImageU8& region, double pixel_mm, const std::vector<Scribe>& scribes,
                       RegionFigures& figures) {
  const auto is_rusted = [&](const Vec2& place_mm) {
    const auto x = static_cast<int>(std::floor(place_mm.x() / pixel_mm)),
               y = static_cast<int>(std::floor(place_mm.y() / pixel_mm));
    return rust.contains(x, y) && region.at(x, y) != 0 && static_cast<double>(rust.at(x, y)) >= kRusted;
  };
  const double step = 0.25 * pixel_mm;
  double sum = 0.0, most = 0.0, num_places = 0.0;
  for (const Scribe& scribe : scribes) {
    const Vec2 from = from_of(scribe), way = way_of(scribe), across = Vec2(-way.y(), way.x()).normalized();
    const std::vector<double> crossings = crossings_of(scribe, scribes);
    const double half = 0.5 * scribe.width_mm;
    for (int k = 0; k < kCreepPlaces; ++k) {
      const double along = kScribeEnds + (1.0 - 2.0 * kScribeEnds) * (k + 0.5) / kCreepPlaces;
      const bool is_at_crossing =
          std::any_of(crossings.begin(), crossings.end(), [&](double c) { return std::abs(along - c) < kScribeEnds; });
      if (is_at_crossing) continue;
      const Vec2 place = from + along * way;
      double width = 0.0, widest = 0.0;
      bool is_merged = false;
      for (const double side : {-1.0, 1.0}) {
        double reach = half;
        while (!is_merged && is_rusted(place + side * (reach + step) * across)) {
          reach += step;
          is_merged = is_nearer_to_another(place + side * reach * across, reach, scribe, scribes);
        }
        width += reach - half;
        widest = std::max(widest, reach - half);
      }
      if (is_merged) continue;  // Nobody tells whose rust it is.
      most = std::max(most, widest);
      sum += 0.5 * width;
      num_places += 1.0;
    }
  }
  if (num_places == 0.0) return;
  // A pixel's edge is known to half of it at each place; places err together.
  const double mean = sum / num_places, uncertain = 0.5 * pixel_mm;
  slot(figures, "creep_mm") = GradedFigure{mean, std::max(0.0, mean - uncertain), mean + uncertain};
  slot(figures, "creep_max_mm") = GradedFigure{most, std::max(0.0, most - uncertain), most + uncertain};
}

}  // namespace patinate::analysis
