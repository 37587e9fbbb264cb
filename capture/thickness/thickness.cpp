#include "patinate/capture/thickness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr float kWeak = 0.5f;         ///< Below it what is not the commonest value is the most.
constexpr float kAsGood = 0.5f;       ///< A second mode that covers this part of the first competes with it.
constexpr double kFewest = 0.001;     ///< Share of the layer: fewer pixels with two modes are chance.
constexpr double kExceptions = 0.05;  ///< Pixels that need not fit, of holes and of what lies beside them.
constexpr double kGrowth = 1.5;       ///< From one window tried to the next.
constexpr double kLayerSigmas = 6.0;  ///< A window that is as wide as the layer: three sigmas to either side.
constexpr int kNoiseDistance_px = 4;  ///< Neighbors of which only noise and grain are different.
constexpr double kMadPerSigma = 0.6745 * std::numbers::sqrt2;  ///< Median of |a - b| for two normal numbers.

double window_of(const ModeFilterOptions& options) { return options.spatial_sigma_px.value_or(kModeFilterWindow_px); }

double median_of(std::vector<float>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

std::int64_t count_inside(const ImageU8& mask) {
  return std::count_if(mask.values().begin(), mask.values().end(), [](std::uint8_t v) { return v != 0; });
}

/// Standard deviation of noise and grain, from differences between neighbors; cracks are too few to matter.
double noise_of(const ImageF& light, const ImageU8& mask) {
  std::vector<float> differences;
  for (int y = 0; y < light.height(); ++y) {
    for (int x = kNoiseDistance_px; x < light.width(); ++x) {
      if (!is_inside(mask, x, y) || !is_inside(mask, x - kNoiseDistance_px, y)) continue;
      differences.push_back(std::abs(light.at(x, y) - light.at(x - kNoiseDistance_px, y)));
    }
  }
  return median_of(differences) / kMadPerSigma;
}

/// Whether two values compete for pixel `i`.
bool has_rival(const ModeFilterResult& result, std::int64_t i) {
  return result.second_share.data()[i] >= kAsGood * result.share.data()[i];
}

/// Pixels whose commonest value covers little of their window in either pass, though no second one competes.
std::int64_t count_weak(const ModeFilterResult& first, const ModeFilterResult& last, const ImageU8& mask) {
  std::int64_t num_weak = 0;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    num_weak +=
        mask.data()[i] != 0 && std::max(first.share.data()[i], last.share.data()[i]) < kWeak && !has_rival(first, i);
  }
  return num_weak;
}

/// Half way between the two values where two compete; NaN when that is nowhere.
double threshold_of(const ModeFilterResult& first, const ImageU8& mask, std::int64_t num_inside, double& two_modes) {
  std::vector<float> middles;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] == 0 || !has_rival(first, i)) continue;
    middles.push_back(0.5f * (first.values.data()[i] + first.second_value.data()[i]));
  }
  two_modes = static_cast<double>(middles.size()) / static_cast<double>(num_inside);
  return two_modes < kFewest ? std::nan("") : median_of(middles);
}

/// Connected places that let more light through than `threshold`, 4 neighbors.
struct BrightPlaces {
  ImageU8 mask;
  std::int64_t num_pixels = 0;
  std::int64_t largest = 0;  ///< Pixels of the largest.
};

BrightPlaces bright_places(const ImageF& values, const ImageU8& mask, double threshold) {
  BrightPlaces found{ImageU8(mask.width(), mask.height())};
  const auto is_new = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < mask.width() && y < mask.height() && mask.at(x, y) != 0 &&
           found.mask.at(x, y) == 0 && static_cast<double>(values.at(x, y)) > threshold;
  };
  std::vector<std::array<int, 2>> open;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!is_new(x, y)) continue;
      std::int64_t size = 0;
      found.mask.at(x, y) = 255;
      open.push_back({x, y});
      while (!open.empty()) {
        const auto [px, py] = open.back();
        open.pop_back();
        ++size;
        for (const auto& [dx, dy] : {std::array{1, 0}, std::array{-1, 0}, std::array{0, 1}, std::array{0, -1}}) {
          if (!is_new(px + dx, py + dy)) continue;
          found.mask.at(px + dx, py + dy) = 255;
          open.push_back({px + dx, py + dy});
        }
      }
      found.num_pixels += size;
      found.largest = std::max(found.largest, size);
    }
  }
  return found;
}

/// Whether a wider window gives the layer in the holes, and beside them the same as before to within range_sigma, all
/// but 5 % of either: on sloping paint it does not.
bool is_filled_alone(const ImageF& before, const ImageF& wider, const ImageU8& mask, const ImageU8& holes,
                     double threshold, double range_sigma) {
  std::int64_t num_in_holes = 0, num_left = 0, num_beside = 0, num_changed = 0;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] == 0) continue;
    const double value = static_cast<double>(wider.data()[i]);
    const bool is_hole = holes.data()[i] != 0;
    num_in_holes += is_hole;
    num_left += is_hole && value > threshold;
    num_beside += !is_hole;
    num_changed += !is_hole && std::abs(value - static_cast<double>(before.data()[i])) > range_sigma;
  }
  return static_cast<double>(num_left) <= kExceptions * static_cast<double>(num_in_holes) &&
         static_cast<double>(num_changed) <= kExceptions * static_cast<double>(num_beside);
}

/// The smallest window of those tried that fills the holes alone; 0 when none does before it is as wide as the layer.
double window_that_fills(const ImageF& light, const ImageF& before, const ImageU8& mask, const ImageU8& holes,
                         double threshold, const ModeFilterOptions& options, const RunControl& control) {
  const double widest = std::sqrt(static_cast<double>(count_inside(mask))) / kLayerSigmas;
  ModeFilterOptions wider = options;
  for (double window = window_of(options);;) {
    window = std::ceil(window * kGrowth);
    if (window > widest) return 0.0;
    wider.spatial_sigma_px = window;
    const ImageF filled = mode_filter(light, mask, wider, control);
    if (is_filled_alone(before, filled, mask, holes, threshold, options.range_sigma)) return window;
  }
}

/// @param light   T that was filtered, finite.
/// @param first   mode_filter_shares() of it.
/// @param last    The same of what the last refinement filtered; `first` when there was none.
/// @param mask    Not empty. @param options  Those of the filter.
/// Cost: where holes are found, up to five more mode filters.
LayerEvidence layer_evidence(const ImageF& light, const ModeFilterResult& first, const ModeFilterResult& last,
                             const ImageU8& mask, const ModeFilterOptions& options, const RunControl& control) {
  LayerEvidence evidence;
  const std::int64_t num_inside = count_inside(mask);
  std::vector<float> shares;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i)
    if (mask.data()[i] != 0) shares.push_back(last.share.data()[i]);
  evidence.weak_share = static_cast<double>(count_weak(first, last, mask)) / static_cast<double>(num_inside);
  evidence.share = median_of(shares);
  evidence.noise = noise_of(light, mask);
  const double threshold = threshold_of(first, mask, num_inside, evidence.two_modes);
  if (std::isnan(threshold)) return evidence;
  const BrightPlaces holes = bright_places(first.values, mask, threshold);
  if (holes.num_pixels == 0) return evidence;
  evidence.hole_share = static_cast<double>(holes.num_pixels) / static_cast<double>(num_inside);
  evidence.hole_width_px = 2.0 * std::sqrt(static_cast<double>(holes.largest) / std::numbers::pi);
  evidence.hole_light = static_cast<double>(percentiles(first.values, holes.mask, 0.5, 0.5).low);
  evidence.brightest = static_cast<double>(percentiles(light, mask, 0.5, 0.999).high);
  if (evidence.hole_share < kNamedHoleShare) return evidence;
  evidence.filling_sigma_px = window_that_fills(light, first.values, mask, holes.mask, threshold, options, control);
  return evidence;
}

constexpr double kSquares = 4.0;  ///< To a spatial sigma of the window.

/// The squares of one color that lie in the layer.
ImageU8 half_of(const ImageU8& known, int side, bool is_black) {
  ImageU8 half(known.width(), known.height());
  for (int y = 0; y < half.height(); ++y) {
    for (int x = 0; x < half.width(); ++x) {
      if (((x / side + y / side) % 2 == 1) == is_black) half.at(x, y) = known.at(x, y);
    }
  }
  return half;
}

/// The layer's light is filled in twice, from the white and from the black squares of a chess board, and compared: half
/// the difference is what all pixels together are off by. Squares of a quarter of the window, at least 2 px: grain that
/// neighbors share counts. Pooled over the window. What both halves have wrong (a slope within the window, light that
/// the layer did not pass) is not in it.
/// @param transmittance  T, H x W x 1, finite inside `known`. @param known  Not empty.
/// @returns H x W x 1, standard deviation of T; 0 outside. Cost: that of two fill_cracks().
ImageF layer_deviation(const ImageF& transmittance, const ImageU8& known, const ThicknessOptions& options,
                       const RunControl& control) {
  if (!transmittance.same_size(known)) throw InvalidInput("thickness: the light and its mask differ in size");
  const double sigma = window_of(options.mode_filter);
  const int side = std::max(2, static_cast<int>(std::lround(sigma / kSquares)));
  const RunControl quiet = control.silent();
  std::array<ImageF, 2> filled;
  for (std::size_t h = 0; h < 2; ++h) {
    const ImageU8 half = half_of(known, side, h == 1);
    const auto values = half.values();
    if (std::all_of(values.begin(), values.end(), [](std::uint8_t v) { return v == 0; }))
      return ImageF(known.width(), known.height());
    const double begin = 0.45 * static_cast<double>(h);
    // Blurred, since both have to say something of every place.
    filled[h] =
        gaussian_blur(fill_cracks(transmittance, half, options, control.part(begin, begin + 0.45)), half, side, quiet);
  }
  ImageF squares(known.width(), known.height());
  for (std::int64_t i = 0; i < squares.num_pixels(); ++i) {
    const float half = 0.5f * (filled[0].data()[i] - filled[1].data()[i]);
    squares.data()[i] = half * half;
  }
  squares = gaussian_blur(squares, known, sigma, quiet);
  for (std::int64_t i = 0; i < squares.num_pixels(); ++i)
    squares.data()[i] = known.data()[i] != 0 ? std::sqrt(squares.data()[i]) : 0.0f;
  return squares;
}

constexpr std::array<std::string_view, 3> kCurveNames{"reciprocal", "beer_lambert", "linear"};
constexpr float kDarkest = 1.0f / 1024.0f;  ///< Transmitted light, below which 1 / T is noise.
/// Blur of a trend, in windows. Narrower it follows grain and what lies beside cracks, wider it misses the paint's
/// curves.
constexpr double kTrendSigmas = 0.75;

/// |d thickness / d T|.
double slope_of(double transmittance, ThicknessCurve curve) {
  switch (curve) {
    case ThicknessCurve::Reciprocal:
      return 1.0 / (transmittance * transmittance);
    case ThicknessCurve::BeerLambert:
      return 1.0 / transmittance;
    case ThicknessCurve::Linear:
      break;
  }
  return 1.0;
}

/// Results of the mode filter in the first and in the last pass.
struct Passes {
  ModeFilterResult first;
  std::optional<ModeFilterResult> last;  ///< Only with refinements; its values are of what was left.
  ImageF filled;
};

Passes filter_in_passes(const ImageF& in, const ImageU8& mask, const ThicknessOptions& options,
                        const RunControl& control) {
  check_ranges(options);
  const double num_passes = 1.0 + options.num_refinements;
  Passes passes{mode_filter_shares(in, mask, options.mode_filter, control.part(0.0, 1.0 / num_passes)), {}, {}};
  passes.filled = passes.first.values;
  const RunControl quiet = control.silent();
  for (int pass = 1; pass <= options.num_refinements; ++pass) {
    const ImageF trend = gaussian_blur(passes.filled, mask, kTrendSigmas * window_of(options.mode_filter), quiet);
    ImageF rest = in;
    std::transform(in.values().begin(), in.values().end(), trend.values().begin(), rest.values().begin(),
                   std::minus<>());
    passes.last =
        mode_filter_shares(rest, mask, options.mode_filter, control.part(pass / num_passes, (pass + 1) / num_passes));
    passes.filled = passes.last->values;
    for (int y = 0; y < in.height(); ++y) {
      for (int x = 0; x < in.width(); ++x) {
        if (is_inside(mask, x, y)) passes.filled.at(x, y) += trend.at(x, y);
      }
    }
  }
  return passes;
}

}  // namespace

void describe(OptionVisitor& v, ThicknessOptions& o) {
  v.visit_choice({"thickness_curve", "How transmitted light T becomes thickness: 1/T, -log T or 1 - T"}, o.curve,
                 kCurveNames);
  describe(v, o.mode_filter);
  v.visit({"num_refinements",
           "How often the mode filter runs again, on the difference between the image and the blurred last result; 0 "
           "keeps edges sharp",
           "", between(0, 10)},
          o.num_refinements);
}

double thickness_of(double transmittance, ThicknessCurve curve) {
  switch (curve) {
    case ThicknessCurve::Reciprocal:
      return 1.0 / transmittance;
    case ThicknessCurve::BeerLambert:
      return -std::log(transmittance);
    case ThicknessCurve::Linear:
      return 1.0 - transmittance;
  }
  throw InvalidInput("thickness_curve: unknown; use reciprocal, beer_lambert or linear");
}

ImageF fill_cracks(const ImageF& in, const ImageU8& mask, const ThicknessOptions& options, const RunControl& control) {
  return filter_in_passes(in, mask, options, control).filled;
}

ThicknessMap thickness_from_transmission(const ImageF& photo, const ImageF& blank, const ImageU8& mask,
                                         const ThicknessOptions& given, const RunControl& control) {
  check_ranges(given);
  if (photo.channels() != 1 || (!blank.empty() && blank.channels() != 1)) {
    throw InvalidInput("thickness: the photographs must have one channel");
  }
  if ((!blank.empty() && !photo.same_size(blank)) || (!mask.empty() && !photo.same_size(mask))) {
    throw InvalidInput("thickness: transmission photograph, blank and mask differ in size");
  }
  ImageF transmittance(photo.width(), photo.height());
  ImageU8 known(photo.width(), photo.height());
  for (int y = 0; y < photo.height(); ++y) {
    for (int x = 0; x < photo.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      const float light = blank.empty() ? 1.0f : blank.at(x, y);
      if (!std::isfinite(photo.at(x, y)) || !std::isfinite(light)) {
        throw InvalidInput("thickness: a transmission photograph holds NaN or infinite values");
      }
      if (!(light >= kDarkest)) continue;
      known.at(x, y) = 255;
      transmittance.at(x, y) = std::clamp(photo.at(x, y) / light, kDarkest, 1.0f);
    }
  }
  const auto known_values = known.values();
  if (std::all_of(known_values.begin(), known_values.end(), [](std::uint8_t v) { return v == 0; })) {
    throw InvalidInput(
        "thickness: the mask or the blank photograph leaves no pixel; the blank must be brighter than black");
  }
  ThicknessOptions options = given;
  LayerWindow window{.sigma_px = window_of(given.mode_filter)};
  if (!given.mode_filter.spatial_sigma_px) {
    window = choose_layer_window(transmittance, known, given, control.part(0.0, 0.5));
    options.mode_filter.spatial_sigma_px = window.sigma_px;
  }
  const double filtered_at = options.with_deviation ? 0.65 : 0.9;
  Passes passes = filter_in_passes(transmittance, known, options, control.part(0.5, filtered_at));
  const RunControl quiet = control.silent();
  ThicknessMap map{.values = std::move(passes.filled),
                   .known = known,
                   .evidence = layer_evidence(transmittance, passes.first, passes.last ? *passes.last : passes.first,
                                              known, options.mode_filter, quiet),
                   .window = window};
  if (options.with_deviation)
    map.deviation = layer_deviation(transmittance, known, options, control.part(filtered_at, 1.0));
  for (int y = 0; y < photo.height(); ++y) {
    for (int x = 0; x < photo.width(); ++x) {
      float& value = map.values.at(x, y);
      if (known.at(x, y) == 0) continue;
      const double filtered = std::clamp(static_cast<double>(value), static_cast<double>(kDarkest), 1.0);
      value = static_cast<float>(thickness_of(filtered, options.curve));
      if (!map.deviation.empty()) map.deviation.at(x, y) *= static_cast<float>(slope_of(filtered, options.curve));
    }
  }
  const Percentiles range = percentiles(map.values, known, 0.001, 0.999);
  map.low = static_cast<double>(range.low);
  map.high = static_cast<double>(range.high);
  control.report(1.0);
  return map;
}

}  // namespace patinate::capture
