#include "capture/thickness/thickness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libcommon/core/error.h"
#include "libcommon/image/filters.h"

namespace patinate {

namespace {

constexpr std::array<std::string_view, 3> kCurveNames{"reciprocal", "beer_lambert", "linear"};
constexpr float kDarkest = 1.0f / 1024.0f;

}  // namespace

void describe(OptionVisitor& v, ThicknessOptions& o) {
  v.visit_choice({"thickness_curve", "How transmitted light T becomes thickness: 1/T, -log T or 1 - T"}, o.curve, kCurveNames);
  describe(v, o.mode_filter);
}

double thickness_of(double transmittance, ThicknessCurve curve) {
  switch (curve) {
    case ThicknessCurve::Reciprocal: return 1.0 / transmittance;
    case ThicknessCurve::BeerLambert: return -std::log(transmittance);
    case ThicknessCurve::Linear: return 1.0 - transmittance;
  }
  throw InvalidInput("thickness_curve: unknown; use reciprocal, beer_lambert or linear");
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
    throw InvalidInput("thickness: the mask or the blank photograph leaves no pixel; the blank must be brighter than black");
  }
  ThicknessMap map{mode_filter(transmittance, known, options.mode_filter, control), 0.0, 0.0, known};
  for (int y = 0; y < photo.height(); ++y) {
    for (int x = 0; x < photo.width(); ++x) {
      float& value = map.values.at(x, y);
      if (known.at(x, y) == 0) continue;
      const double filtered = std::clamp(static_cast<double>(value), static_cast<double>(kDarkest), 1.0);
      value = static_cast<float>(thickness_of(filtered, options.curve));
    }
  }
  const Percentiles range = percentiles(map.values, known, 0.001, 0.999);
  map.low = static_cast<double>(range.low);
  map.high = static_cast<double>(range.high);
  return map;
}

}  // namespace patinate
