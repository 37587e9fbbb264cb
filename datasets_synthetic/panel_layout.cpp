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

constexpr std::uint32_t kPlaceStream = 1530, kClusterStream = 1531, kPaintStream = 1532;  // Streams of random numbers.
constexpr std::uint64_t kEdgeItems = std::uint64_t{1} << 32;                              ///< Numbers of edge spots.
constexpr std::int64_t kPaintRows = 16;
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

bool is_clear_of_scribes(const PanelOptions& o, const std::vector<PanelScribe>& scribes, const SpotOutline& spot) {
  const double reach = spot.reach * spot.radius_px * o.pixel_mm + kClearOfScribeMm;
  const Vec2 place = o.pixel_mm * Vec2(spot.x_px, spot.y_px);
  return std::all_of(scribes.begin(), scribes.end(), [&](const PanelScribe& scribe) {
    const Vec2 way = scribe.to_mm - scribe.from_mm, along = way.normalized(), beyond = place - scribe.from_mm;
    const double s = beyond.dot(along), n = std::abs(beyond.x() * along.y() - beyond.y() * along.x());
    return n > 0.5 * scribe.width_mm + largest_creep(scribe) + reach || s < -reach || s > way.norm() + reach;
  });
}

/// Places in the test area or beside it: anywhere, or in the test area around a few middles.
class Places {
 public:
  Places(const PanelOptions& o, int num_spots) : options_(o) {
    if (o.pattern != RustPattern::Spot) return;
    const int count = std::clamp(num_spots / 6, 1, 4);
    for (int i = 0; i < count; ++i) {
      RandomStream random(static_cast<std::uint64_t>(o.seed), static_cast<std::uint64_t>(i), kClusterStream);
      middles_.push_back(anywhere(random, o.edge_mm / o.pixel_mm));
    }
    // Spots overlap a little, as in a heap.
    spread_px_ = 0.45 * spot_sizes(o).mean_mm / o.pixel_mm * std::sqrt(static_cast<double>(num_spots) / count);
  }
  /// Some of the places do not lie where they are asked for.
  Vec2 draw(RandomStream& random, bool in_test) const {
    if (middles_.empty() || !in_test) return anywhere(random, in_test ? options_.edge_mm / options_.pixel_mm : 0.0);
    const Vec2& middle = middles_[random.below(static_cast<std::uint32_t>(middles_.size()))];
    return middle + spread_px_ * Vec2(random.normal(), random.normal());
  }

 private:
  [[nodiscard]] Vec2 anywhere(RandomStream& random, double edge_px) const {
    return {edge_px + random.uniform() * (options_.width - 2.0 * edge_px),
            edge_px + random.uniform() * (options_.height - 2.0 * edge_px)};
  }
  const PanelOptions& options_;
  std::vector<Vec2> middles_;
  double spread_px_ = 0.0;
};

/// Spots whose middles lie all in the test area, or all beside it.
void add_spots(std::vector<SpotOutline>& spots, const PanelOptions& o, const std::vector<PanelScribe>& scribes,
               const Places& places, int count, bool in_test) {
  const std::size_t first = spots.size();
  for (std::size_t i = first; i < first + static_cast<std::size_t>(count); ++i) {
    RandomStream random(static_cast<std::uint64_t>(o.seed), i, kPlaceStream);
    SpotOutline spot = sized_spot(o, spot_sizes(o), i, random);
    for (int k = 0; k < kMaxTries; ++k) {
      const Vec2 place = places.draw(random, in_test);
      spot.x_px = place.x();
      spot.y_px = place.y();
      if (in_test_area(o, place * o.pixel_mm) != in_test || !is_clear_of_scribes(o, scribes, spot)) continue;
      spots.push_back(spot);
      break;
    }
  }
}

/// Spreads spots as densely beside the test area as in it, but for spots in a few places, which lie in it.
std::vector<SpotOutline> spread_spots(const PanelOptions& o, const std::vector<PanelScribe>& scribes,
                                      double in_test_mm2, double beside_mm2) {
  const int count = spot_count(spot_sizes(o), o.rust, in_test_mm2);
  const Places places(o, count);
  std::vector<SpotOutline> spots;
  add_spots(spots, o, scribes, places, count, true);
  if (count > 0 && spots.empty()) throw InvalidInput("creep: leaves no room for rust beside the scribe; use less");
  if (o.pattern != RustPattern::Spot) {
    const int beside = static_cast<int>(std::min(1e6, std::floor(count * beside_mm2 / in_test_mm2)));
    add_spots(spots, o, scribes, places, beside, false);
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

std::vector<SpotOutline> all_spots(const PanelOptions& o, const std::vector<PanelScribe>& scribes,
                                   const SampleFrame& test, const RunControl& control) {
  const double mm2 = o.pixel_mm * o.pixel_mm / kSamplesPerPixel;
  const auto in_test = static_cast<double>(test.num_samples());
  const double outside = static_cast<double>(o.width) * o.height * kSamplesPerPixel - in_test;
  std::vector<SpotOutline> spots = spread_spots(o, scribes, in_test * mm2, outside * mm2);
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
    for (int x = 0; x < field.width(); ++x) sum += static_cast<double>(field.at(x, y)) * sample_count(test.at(x, y));
  }
  const auto mean = static_cast<float>(sum / static_cast<double>(test.num_samples()));
  for (float& value : field.values()) value -= mean;
}

/// Adds noise of a cell's size to a field.
void add_noise(ImageF& field, const PanelOptions& o, std::uint32_t number, double cell_mm, float amplitude,
               const RunControl& control) {
  const double cell = std::max(1.2, cell_mm / o.pixel_mm);
  const SmoothNoise noise(static_cast<std::uint64_t>(o.seed), kPaintStream + number, o.width, o.height, cell, cell);
  parallel_for(o.height, kPaintRows, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> row(static_cast<std::size_t>(o.width));
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      noise.row(y, row);
      for (int x = 0; x < o.width; ++x) field.at(x, y) += amplitude * row[static_cast<std::size_t>(x)];
    }
  });
}

void add_paint(PanelLayout& layout, const RunControl& control) {
  const PanelOptions& o = layout.options;
  layout.grain = layout.uneven = ImageF(o.width, o.height);
  add_noise(layout.grain, o, 0, 0.3, 0.03f,
            control);  // Unevenness of pigments, orange peel, and how thick the paint lies.
  add_noise(layout.grain, o, 1, 1.2, 0.06f, control);
  add_noise(layout.grain, o, 2, 14.0, 0.03f, control);
  add_noise(layout.uneven, o, 3, 12.0, 0.8f, control);
  center(layout.grain, layout.test_area);
  center(layout.uneven, layout.test_area);
}

}  // namespace

PanelLayout lay_out_panel(const PanelOptions& o, const RunControl& control) {
  check_panel(o);
  const SampleFrame test_area(o.width, o.height, o.edge_mm / o.pixel_mm);
  const std::vector<PanelScribe> scribes = make_scribes(o);
  const std::vector<SpotOutline> spots = all_spots(o, scribes, test_area, control);
  PanelLayout layout{.options = o,
                     .test_area = test_area,
                     .spots = spots,
                     .scribes = scribes,
                     .stains = Stains(o, spots, test_area, control),
                     .rust = RustTexture(o)};
  if (o.crack_density > 0.0) layout.cracks = make_cracks(o);
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
  if (!layout.scribes.empty()) {
    marks.scribe = draw_scribes(layout.scribes, o, hours, control);
    marks.cut = draw_scribes(layout.scribes, o, 0.0, control).samples;
  }
  if (!layout.cracks.empty()) marks.cracks = draw_cracks(layout.cracks, o, hours);
  if (!layout.stains.empty()) marks.stain = layout.stains.draw(hours, 1.0, control);
  return marks;
}

}  // namespace patinate::datasets
