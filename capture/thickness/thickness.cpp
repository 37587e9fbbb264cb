#include "patinate/capture/thickness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "capture/thickness/layer_evidence.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

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
  const double sigma = options.mode_filter.spatial_sigma_px;
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
constexpr float kDarkest = 1.0f / 1024.0f;
/// Blur of a trend, in windows. Narrower it follows grain and what lies beside cracks, wider it misses the paint's
/// curves.
constexpr double kTrendSigmas = 0.75;

}  // namespace

void describe(OptionVisitor& v, ThicknessOptions& o) {
  v.visit_choice({"thickness_curve", "How transmitted light T becomes thickness: 1/T, -log T or 1 - T"}, o.curve,
                 kCurveNames);
  describe(v, o.mode_filter);
  v.visit({"num_refinements",
           "How often the mode filter is run again on what differs from its blurred result; 0 keeps edges sharp", "",
           between(0, 10)},
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

namespace {

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

/// What the mode filter gave in the first and in the last pass.
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
    const ImageF trend = gaussian_blur(passes.filled, mask, kTrendSigmas * options.mode_filter.spatial_sigma_px, quiet);
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

ImageF fill_cracks(const ImageF& in, const ImageU8& mask, const ThicknessOptions& options, const RunControl& control) {
  return filter_in_passes(in, mask, options, control).filled;
}

ThicknessMap thickness_from_transmission(const ImageF& photo, const ImageF& blank, const ImageU8& mask,
                                         const ThicknessOptions& options, const RunControl& control) {
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
  const double filtered_at = options.with_deviation ? 0.35 : 0.9;
  Passes passes = filter_in_passes(transmittance, known, options, control.part(0.0, filtered_at));
  const RunControl quiet = control.silent();
  ThicknessMap map{.values = std::move(passes.filled),
                   .known = known,
                   .evidence = layer_evidence(transmittance, passes.first, passes.last ? *passes.last : passes.first,
                                              known, options.mode_filter, quiet)};
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
