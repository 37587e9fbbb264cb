#include "datasets_synthetic/panel_layout.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets_synthetic/fitted_factor.h"
#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/geometry/mesh.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kPlaceStream = 1530, kClusterStream = 1531, kGrainStream = 1532;  // Of random streams.
constexpr std::uint64_t kEdgeItems = std::uint64_t{1} << 32;                              ///< Numbers of edge spots.
constexpr std::int64_t kTextureRows = 16;
constexpr int kMaxTries = 200;
constexpr double kClearOfScribeMm = 1.0;  ///< Between a spot and what creeps from the scribe.

/// How the spots of a pattern differ.
struct SpotSizes {
  double mean_mm;  ///< Diameter.
  double spread;   ///< Standard deviation of its logarithm.
};
SpotSizes spot_sizes(const PanelOptions& o) {
  constexpr std::array<SpotSizes, 3> kSizes{{{3.0, 0.35}, {1.5, 0.6}, {0.5, 0.15}}};
  SpotSizes sizes = kSizes[static_cast<std::size_t>(o.pattern)];
  sizes.mean_mm = o.spot_mm.value_or(sizes.mean_mm);
  return sizes;
}

/// Spots whose union covers about `percent` of an area: -log(1 - p) times the area, as those that lie anywhere overlap.
int spot_count(const SpotSizes& sizes, double percent, double area_mm2) {
  if (!(percent > 0.0)) return 0;
  const double one = 0.25 * std::numbers::pi * sizes.mean_mm * sizes.mean_mm * std::exp(sizes.spread * sizes.spread);
  return static_cast<int>(std::clamp(-std::log(1.0 - 0.01 * percent) * area_mm2 / one, 1.0, 1e6));
}

/// An outline with a size and a start; the larger ones began earlier. @param random  Its own stream.
SpotOutline sized_spot(const PanelOptions& o, const SpotSizes& sizes, std::uint64_t item, RandomStream& random) {
  SpotOutline spot = bent_outline(static_cast<std::uint64_t>(o.seed), item);
  const double size = sizes.spread * random.normal();
  spot.radius_px = 0.5 * sizes.mean_mm / o.pixel_mm * std::exp(size - 0.5 * sizes.spread * sizes.spread);
  const double late = random.uniform();
  spot.start_h = o.hours * std::clamp(0.02 + 0.7 * late * late * std::exp(-size), 0.02, 0.8);
  return spot;
}

bool is_clear_of_scribe(const PanelOptions& o, const std::optional<PanelScribe>& scribe, const SpotOutline& spot) {
  if (!scribe) return true;
  const double reach = spot.reach * spot.radius_px * o.pixel_mm + kClearOfScribeMm;
  const double half = 0.5 * scribe->width_mm + largest_creep(*scribe) + reach;
  const double x = spot.x_px * o.pixel_mm, y = spot.y_px * o.pixel_mm;
  return x < std::min(scribe->from_mm[0], scribe->to_mm[0]) - half ||
         x > std::max(scribe->from_mm[0], scribe->to_mm[0]) + half || y < scribe->from_mm[1] - reach ||
         y > scribe->to_mm[1] + reach;
}

/// Places in the test area: anywhere, or around a few middles.
class Places {
 public:
  Places(const PanelOptions& o, int num_spots) : options_(o) {
    if (o.pattern != RustPattern::Spot) return;
    const int count = std::clamp(num_spots / 6, 1, 4);
    for (int i = 0; i < count; ++i) {
      RandomStream random(static_cast<std::uint64_t>(o.seed), static_cast<std::uint64_t>(i), kClusterStream);
      middles_.push_back(anywhere(random));
    }
    // As dense as a heap of spots that overlap a little.
    spread_px_ = 0.45 * spot_sizes(o).mean_mm / o.pixel_mm * std::sqrt(static_cast<double>(num_spots) / count);
  }
  Vec2 draw(RandomStream& random) const {
    if (middles_.empty()) return anywhere(random);
    const Vec2& middle = middles_[random.below(static_cast<std::uint32_t>(middles_.size()))];
    return middle + spread_px_ * Vec2(random.normal(), random.normal());
  }

 private:
  [[nodiscard]] Vec2 anywhere(RandomStream& random) const {
    const double edge = options_.edge_mm / options_.pixel_mm;
    return {edge + random.uniform() * (options_.width - 2.0 * edge),
            edge + random.uniform() * (options_.height - 2.0 * edge)};
  }
  const PanelOptions& options_;
  std::vector<Vec2> middles_;
  double spread_px_ = 0.0;
};

std::vector<SpotOutline> test_spots(const PanelOptions& o, const std::optional<PanelScribe>& scribe, double area_mm2) {
  const SpotSizes sizes = spot_sizes(o);
  const int count = spot_count(sizes, o.rust, area_mm2);
  const Places places(o, count);
  std::vector<SpotOutline> spots;
  for (int i = 0; i < count; ++i) {
    const auto item = static_cast<std::uint64_t>(i);
    RandomStream random(static_cast<std::uint64_t>(o.seed), item, kPlaceStream);
    SpotOutline spot = sized_spot(o, sizes, item, random);
    for (int k = 0; k < kMaxTries; ++k) {
      const Vec2 place = places.draw(random);
      spot.x_px = place.x();
      spot.y_px = place.y();
      const bool is_there = in_test_area(o, place.x() * o.pixel_mm, place.y() * o.pixel_mm);
      if (is_there && is_clear_of_scribe(o, scribe, spot)) {
        spots.push_back(spot);
        break;
      }
    }
  }
  return spots;
}

/// Spots along the panel's edges, most of them near the edge.
std::vector<SpotOutline> edge_spots(const PanelOptions& o, double area_mm2) {
  SpotSizes sizes = spot_sizes(o);
  sizes.mean_mm = std::min(sizes.mean_mm, 0.4 * o.edge_mm);
  const double width = o.width, height = o.height, edge = o.edge_mm / o.pixel_mm;
  const int count = spot_count(sizes, o.edge_rust, area_mm2);
  std::vector<SpotOutline> spots;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t item = kEdgeItems + static_cast<std::uint64_t>(i);
    RandomStream random(static_cast<std::uint64_t>(o.seed), item, kPlaceStream);
    SpotOutline spot = sized_spot(o, sizes, item, random);
    spot.is_edge = true;
    const double along = 2.0 * (width + height) * random.uniform(), depth = random.uniform();
    const double in = 0.8 * edge * depth * depth;
    if (along < 2.0 * width) {
      spot.x_px = along < width ? along : along - width;
      spot.y_px = along < width ? in : height - in;
    } else {
      const double down = along - 2.0 * width;
      spot.y_px = down < height ? down : down - height;
      spot.x_px = down < height ? in : width - in;
    }
    spots.push_back(spot);
  }
  return spots;
}

void scale_to(std::vector<SpotOutline>& spots, const PanelOptions& o, double wanted_samples, const SampleFrame& test,
              bool is_edge, const RunControl& control) {
  if (spots.empty()) return;
  const double factor = fitted_factor(wanted_samples, [&](double scale) {
    const SampleImage samples = draw_spots(spots, o, is_edge, o.hours, scale, false, control.silent()).samples;
    const std::int64_t inside = count_samples(samples, test);
    return static_cast<double>(is_edge ? count_samples(samples) - inside : inside);
  });
  for (SpotOutline& spot : spots) spot.radius_px *= factor;
}

std::vector<SpotOutline> all_spots(const PanelOptions& o, const std::optional<PanelScribe>& scribe,
                                   const SampleFrame& test, const RunControl& control) {
  const double mm2 = o.pixel_mm * o.pixel_mm / kSamplesPerPixel;
  const auto in_test = static_cast<double>(test.num_samples());
  const double outside = static_cast<double>(o.width) * o.height * kSamplesPerPixel - in_test;
  std::vector<SpotOutline> spots = test_spots(o, scribe, in_test * mm2);
  if (o.rust > 0.0 && spots.empty()) throw InvalidInput("creep: leaves no room for rust beside the scribe; use less");
  scale_to(spots, o, 0.01 * o.rust * in_test, test, false, control);
  std::vector<SpotOutline> edge = edge_spots(o, outside * mm2);
  scale_to(edge, o, 0.01 * o.edge_rust * outside, test, true, control);
  spots.insert(spots.end(), edge.begin(), edge.end());
  return spots;
}

/// Makes the mean 0 in the test area.
void center(ImageF& field, const SampleFrame& test) {
  double sum = 0.0;
  for (int y = 0; y < field.height(); ++y) {
    for (int x = 0; x < field.width(); ++x) sum += static_cast<double>(field.at(x, y)) * std::popcount(test.at(x, y));
  }
  const auto mean = static_cast<float>(sum / static_cast<double>(test.num_samples()));
  for (float& value : field.values()) value -= mean;
}

void add_paint(PanelLayout& layout, const RunControl& control) {
  const PanelOptions& o = layout.options;
  const auto seed = static_cast<std::uint64_t>(o.seed);
  const auto cell = [&o](double mm) { return std::max(1.2, mm / o.pixel_mm); };
  const SmoothNoise fine(seed, kGrainStream, o.width, o.height, cell(0.3), cell(0.3));
  const SmoothNoise peel(seed, kGrainStream + 1, o.width, o.height, cell(1.2), cell(1.2));
  const SmoothNoise broad(seed, kGrainStream + 2, o.width, o.height, cell(14.0), cell(14.0));
  const SmoothNoise chalk(seed, kGrainStream + 3, o.width, o.height, cell(9.0), cell(16.0));
  layout.grain = layout.uneven = ImageF(o.width, o.height);
  parallel_for(o.height, kTextureRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < o.width; ++x) {
        layout.grain.at(x, y) = static_cast<float>(0.02 * fine(x, y) + 0.025 * peel(x, y) + 0.03 * broad(x, y));
        layout.uneven.at(x, y) = static_cast<float>(0.8 * chalk(x, y));
      }
    }
  });
  center(layout.grain, layout.test_area);
  center(layout.uneven, layout.test_area);
}

}  // namespace

PanelLayout lay_out_panel(const PanelOptions& o, const RunControl& control) {
  check_panel(o);
  PanelLayout layout{.options = o, .test_area = SampleFrame(o.width, o.height, o.edge_mm / o.pixel_mm)};
  if (o.scribe) layout.scribe = make_scribe(o);
  layout.spots = all_spots(o, layout.scribe, layout.test_area, control);
  if (o.crack_density > 0.0) layout.cracks = make_cracks(o);
  layout.streaks = make_streaks(o, layout.spots, control);
  add_paint(layout, control.silent());
  return layout;
}

PanelMarks marks_at(const PanelLayout& layout, double hours, const RunControl& control) {
  const PanelOptions& o = layout.options;
  PanelMarks marks{.rust = draw_spots(layout.spots, o, false, hours, 1.0, true, control)};
  if (o.edge_rust > 0.0) {
    const Marks edge = draw_spots(layout.spots, o, true, hours, 1.0, true, control);
    for (int y = 0; y < o.height; ++y) {
      for (int x = 0; x < o.width; ++x) {
        marks.rust.samples.at(x, y) |= edge.samples.at(x, y) & ~layout.test_area.at(x, y);
        marks.rust.inside_px.at(x, y) = std::max(marks.rust.inside_px.at(x, y), edge.inside_px.at(x, y));
      }
    }
  }
  if (layout.scribe) marks.scribe = draw_scribe(*layout.scribe, o, hours, control);
  if (!layout.cracks.empty()) marks.cracks = draw_cracks(layout.cracks, o, hours);
  if (!layout.streaks.empty()) marks.stain = draw_streaks(layout.streaks, o, hours, 1.0, control);
  return marks;
}

}  // namespace patinate::datasets
