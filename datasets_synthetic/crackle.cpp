#include "patinate/datasets/crackle.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "datasets_synthetic/crackle_growth.h"
#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::datasets {

namespace {

constexpr std::array<std::string_view, 3> kLawNames = {"beer_lambert", "reciprocal", "linear"};
constexpr std::uint32_t kThicknessNoise = 1;  // Purposes of random streams.
constexpr std::uint32_t kMottleNoise = 3;
constexpr std::uint32_t kBrushNoise = 4;
constexpr std::uint32_t kEdgeNoise = 5;
constexpr double kMinBarrierPx = 0.75;  // Half width of a crack's band in the cell map.

// From where on, between the thickest paint (0) and the thinnest (1), cracks come no longer one by one, and where
// wholly at once.
constexpr double kOneByOne = 0.35;
constexpr double kAtOnce = 0.65;

// Share of the drying time at which the first and the last cracks begin.
constexpr double kFirstOnset = 0.03;
constexpr double kLastOnset = 0.72;

// A ramp across the plate, bent by broad swells, scaled to fill [min, max].
ImageF make_thickness(const CrackleOptions& o) {
  const int w = o.width, h = o.height;
  const double size = std::max(w, h);
  const SmoothNoise broad(static_cast<std::uint64_t>(o.seed), kThicknessNoise, w, h, 0.30 * size, 0.30 * size);
  const SmoothNoise fine(static_cast<std::uint64_t>(o.seed), kThicknessNoise + 1, w, h, 0.13 * size, 0.13 * size);
  ImageF field(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const double ramp = (0.8 * x + 0.45 * y) / size;
      field.at(x, y) = static_cast<float>(ramp + 0.85 * broad(x, y) + 0.25 * fine(x, y));
    }
  }
  // Half way to equal shares of all thicknesses, so that each of them has room for whole cells.
  std::vector<float> sorted(field.values().begin(), field.values().end());
  std::sort(sorted.begin(), sorted.end());
  const double range = static_cast<double>(sorted.back()) - static_cast<double>(sorted.front());
  for (float& value : field.values()) {
    const auto below = std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin();
    const double rank = static_cast<double>(below) / static_cast<double>(sorted.size());
    const double share = (static_cast<double>(value) - static_cast<double>(sorted.front())) / range;
    const double f = std::clamp(0.5 * share + 0.5 * rank, 0.0, 1.0);
    value = static_cast<float>(o.thickness_min_mm + f * (o.thickness_max_mm - o.thickness_min_mm));
  }
  return field;
}

/// @throws InvalidInput unless `share` is of the plate's size and in [0, 1].
ImageF scaled_thickness(const CrackleOptions& o, const ImageF& share) {
  if (share.width() != o.width || share.height() != o.height || share.channels() != 1)
    throw InvalidInput("thickness: expected one value for every pixel of the plate");
  ImageF thickness = share;
  for (float& value : thickness.values()) {
    if (!(value >= 0.0f && value <= 1.0f)) throw InvalidInput("thickness: expected values from 0 to 1");
    value =
        static_cast<float>(o.thickness_min_mm + static_cast<double>(value) * (o.thickness_max_mm - o.thickness_min_mm));
  }
  return thickness;
}

ImageF make_paint(const CrackleOptions& o, const ImageF& thickness) {
  constexpr std::array<double, 3> kPaint = {0.590, 0.655, 0.575};  // A pale gray-green.
  constexpr std::array<double, 3> kUnder = {0.20, 0.15, 0.10};     // Color that shows through where it is thin.
  const double w = o.width, h = o.height;
  const std::uint64_t seed = static_cast<std::uint64_t>(o.seed);
  const SmoothNoise mottle(seed, kMottleNoise, w, h, 17.0, 17.0);
  const SmoothNoise brush(seed, kBrushNoise, w, h, 26.0, 2.2);
  ImageF paint(o.width, o.height, 3);
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      const double thick = static_cast<double>(thickness.at(x, y));
      const double hiding = 1.0 - 0.35 * std::exp(-9.0 * thick / o.thickness_max_mm);
      const double shade = 1.0 + 0.07 * mottle(x, y) + 0.06 * brush(x, y);
      for (int c = 0; c < 3; ++c) {
        const std::size_t i = c;
        paint.at(x, y, c) = static_cast<float>(shade * (hiding * kPaint[i] + (1.0 - hiding) * kUnder[i]));
      }
    }
  }
  return paint;
}

ImageF make_backlight(const CrackleOptions& o) {
  ImageF light(o.width, o.height);
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      const double u = (x + 0.5) / o.width - 0.5, v = (y + 0.5) / o.height - 0.5;
      light.at(x, y) = static_cast<float>(0.90 * (1.0 - 0.25 * (u * u + v * v) + 0.03 * u));
    }
  }
  return light;
}

int clamped(double value, int size) { return std::clamp(static_cast<int>(std::lround(value)), 0, size - 1); }

// How far from its center line a crack changes the paint's look.
double rim_px(double spacing_px) { return 1.6 + 0.045 * spacing_px; }

double final_width_px(const CrackleOptions& o, const Crack& crack, double spacing_px) {
  const double rank = crack.is_dead_end ? 0.42 : 0.70 + 0.55 * std::pow(0.6, crack.level);
  return std::max(0.45, o.strain * spacing_px * rank);
}

// Distance, width and time of one crack at every pixel it can reach, appended to `out`.
void add_influences(const CrackleOptions& o, const ImageF& spacing, const SmoothNoise& edge, const Crack& crack,
                    double speed_px_per_s, std::vector<CrackleDataset::Influence>& out) {
  std::vector<CrackleDataset::Influence> found;
  const std::size_t size = crack.points_px.size();
  for (std::size_t i = 0; i < size; ++i) {
    const double px = crack.points_px[i][0], py = crack.points_px[i][1];
    const double s = static_cast<double>(spacing.at(clamped(px, o.width), clamped(py, o.height)));
    const double length = 0.5 * std::abs(static_cast<double>(i) - crack.origin);
    double width = final_width_px(o, crack, s) * (1.0 + 0.7 * edge(px, py));
    if (crack.is_dead_end) width *= 1.0 - static_cast<double>(i) / static_cast<double>(size);
    const double reach = 0.5 * width + 3.5 * rim_px(s);
    const int x0 = std::max(0, static_cast<int>(std::ceil(px - reach)));
    const int x1 = std::min(o.width - 1, static_cast<int>(std::floor(px + reach)));
    const int y0 = std::max(0, static_cast<int>(std::ceil(py - reach)));
    const int y1 = std::min(o.height - 1, static_cast<int>(std::floor(py + reach)));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double d = std::hypot(x - px, y - py);
        if (d > reach) continue;
        found.push_back({y * o.width + x, static_cast<float>(d), static_cast<float>(width),
                         static_cast<float>(crack.start_s + length / speed_px_per_s)});
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.distance_px < b.distance_px;
  });
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i == 0 || found[i].pixel != found[i - 1].pixel) out.push_back(found[i]);
  }
}

double time_constant_s(const CrackleDataset& d) { return 0.25 * d.duration_s(); }

// When half a crack's width reaches `distance`; -1 if never before the end.
double time_reached(const CrackleDataset& d, const CrackleDataset::Influence& i) {
  const double share = 2.0 * static_cast<double>(i.distance_px) / static_cast<double>(i.width_px);
  if (!(share < 1.0)) return -1.0;
  const double time = static_cast<double>(i.start_s) - time_constant_s(d) * std::log1p(-share);
  return time <= d.duration_s() ? time : -1.0;
}

void set_start_times(CrackleDataset& d, const std::vector<double>& onset,
                     const std::vector<std::array<int, 2>>& ends_on) {
  const double duration = d.duration_s();
  for (std::size_t k = 0; k < d.cracks.size(); ++k) {
    Crack& crack = d.cracks[k];
    const double share = kFirstOnset + (kLastOnset - kFirstOnset) * std::pow(onset[k], 1.6);
    crack.start_s = share * duration;
    // Cracks that it ends on must be there first.
    for (const int parent : ends_on[k]) {
      if (parent >= 0) crack.start_s = std::max(crack.start_s, d.cracks[parent].start_s);
    }
  }
}

void label_cells(CrackleDataset& d) {
  const int w = d.options.width, h = d.options.height;
  cv::Mat paint(h, w, CV_8U, cv::Scalar(255));
  const double duration = d.duration_s();
  for (const auto& i : d.influences) {
    const double half =
        0.5 * static_cast<double>(i.width_px) * crack_opening(d, duration, static_cast<double>(i.start_s));
    if (static_cast<double>(i.distance_px) <= std::max(half, kMinBarrierPx)) {
      paint.at<std::uint8_t>(i.pixel / w, i.pixel % w) = 0;
    }
  }
  cv::Mat labels;
  d.num_cells = cv::connectedComponents(paint, labels, 4, CV_32S) - 1;
  d.cells = Image<std::int32_t>(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) d.cells.at(x, y) = labels.at<std::int32_t>(y, x);
  }
}

}  // namespace

void describe(OptionVisitor& v, CrackleOptions& o) {
  v.visit({"width", "Width of the photographs", "px", between(32, 8192)}, o.width);
  v.visit({"height", "Height of the photographs", "px", between(32, 8192)}, o.height);
  v.visit({"texel_size", "Length on the plate that a pixel shows", "mm", above(0)}, o.texel_size_mm);
  v.visit({"num_frames", "Photographs over time", "", between(2, 10000)}, o.num_frames);
  v.visit({"interval", "Time between photographs", "s", above(0)}, o.interval_s);
  v.visit({"thickness_min", "Thinnest paint", "mm", above(0)}, o.thickness_min_mm);
  v.visit({"thickness_max", "Thickest paint", "mm", above(0)}, o.thickness_max_mm);
  v.visit({"thickness_map",
           "IMAGE that says where paint is thick: black = thickness_min, white = thickness_max; default: drawn from "
           "the seed"},
          o.thickness_map);
  v.visit({"spacing_per_thickness", "Crack spacing divided by paint thickness", "", above(0)}, o.spacing_per_thickness);
  v.visit({"strain", "Final width of a crack divided by the spacing", "", between(0, 0.5)}, o.strain);
  v.visit({"grain", "How much the first cracks run vertically", "", between(0, 1)}, o.grain);
  v.visit({"yellowing", "Share of blue that the paint loses until the end", "", between(0, 1)}, o.yellowing);
  v.visit_choice({"law", "How transmitted light falls with thickness"}, o.law, kLawNames);
  v.visit({"absorption", "Strength of that fall", "1/mm", above(0)}, o.absorption_per_mm);
  v.visit({"simultaneity",
           "Degree to which thin paint cracks all at once, with junctions of 120 degrees; 0 = cracks form one by one "
           "everywhere",
           "", between(0, 1)},
          o.simultaneity);
  v.visit({"noise", "Standard deviation of the noise that is added to the photographs; 1 = full scale", "",
           between(0, 0.5)},
          o.noise);
  v.visit({"seed", "Every random choice derives from it", "", at_least(0)}, o.seed);
}

void check_crackle(const CrackleOptions& o) {
  check_ranges(o);
  if (!(o.thickness_max_mm > o.thickness_min_mm)) {
    throw InvalidInput("thickness_max: " + number_text(o.thickness_max_mm) + " is not above thickness_min, " +
                       number_text(o.thickness_min_mm));
  }
  if (o.law == TransmissionLaw::Linear && !(o.absorption_per_mm * o.thickness_max_mm < 1.0)) {
    throw InvalidInput("absorption: " + number_text(o.absorption_per_mm) +
                       " leaves no light under the thickest paint; with the linear law use less than " +
                       number_text(1.0 / o.thickness_max_mm));
  }
}

CrackleDataset crackle(const CrackleOptions& options, const RunControl& control, const ImageF& thickness) {
  check_crackle(options);
  CrackleDataset d;
  d.options = options;
  d.thickness_mm = thickness.empty() ? make_thickness(options) : scaled_thickness(options, thickness);
  d.paint = make_paint(options, d.thickness_mm);
  d.backlight = make_backlight(options);

  CrackleField field{ImageF(options.width, options.height), ImageF(options.width, options.height),
                     ImageF(options.width, options.height)};
  const double thickness_range = options.thickness_max_mm - options.thickness_min_mm;
  for (std::size_t i = 0; i < d.thickness_mm.values().size(); ++i) {
    const double h = static_cast<double>(d.thickness_mm.values()[i]);
    field.spacing_px.values()[i] =
        static_cast<float>(std::max(4.0, options.spacing_per_thickness * h / options.texel_size_mm));
    const double thin = 1.0 - (h - options.thickness_min_mm) / thickness_range,
                 rise = std::clamp((thin - kOneByOne) / (kAtOnce - kOneByOne), 0.0, 1.0);
    field.unsteadiness.values()[i] = static_cast<float>(thin);
    field.at_once.values()[i] = static_cast<float>(options.simultaneity * rise * rise * (3.0 - 2.0 * rise));
  }
  std::vector<double> onset;
  std::vector<std::array<int, 2>> ends_on;
  d.cracks = grow_cracks(field, options.grain, static_cast<std::uint64_t>(options.seed), onset, ends_on, control);

  // A tip crosses the plate in a sixth of the time.
  const double speed = std::hypot(options.width, options.height) / (d.duration_s() / 6.0);
  set_start_times(d, onset, ends_on);
  const SmoothNoise edge(static_cast<std::uint64_t>(options.seed), kEdgeNoise, options.width, options.height, 2.5, 2.5);
  for (const Crack& crack : d.cracks) {
    control.throw_if_stopped();
    add_influences(options, field.spacing_px, edge, crack, speed, d.influences);
  }
  std::stable_sort(d.influences.begin(), d.influences.end(),
                   [](const auto& a, const auto& b) { return a.pixel < b.pixel; });

  d.opening_s = ImageF(options.width, options.height, 1, -1.0f);
  for (const auto& i : d.influences) {
    const double time = time_reached(d, i);
    float& first = d.opening_s.values()[i.pixel];
    if (time >= 0.0 && (first < 0.0f || time < static_cast<double>(first))) first = static_cast<float>(time);
  }
  label_cells(d);
  control.report(1.0);
  return d;
}

double crack_opening(const CrackleDataset& dataset, double time_s, double start_s) {
  return time_s > start_s ? -std::expm1(-(time_s - start_s) / time_constant_s(dataset)) : 0.0;
}

double transmittance(const CrackleOptions& options, double thickness_mm) {
  const double x = options.absorption_per_mm * thickness_mm;
  switch (options.law) {
    case TransmissionLaw::Reciprocal:
      return 1.0 / (1.0 + x);
    case TransmissionLaw::Linear:
      return 1.0 - x;
    case TransmissionLaw::BeerLambert:
      break;
  }
  return std::exp(-x);
}

}  // namespace patinate::datasets
