#include "libcommon/output/color_ramp.h"

#include <algorithm>

#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"

namespace patinate {

namespace {

using Lab = std::array<double, 3>;
constexpr float kOutside = 0.35f;

Lab mixed_lab(const Lab& a, const Lab& b, double x) {
  return {a[0] + x * (b[0] - a[0]), a[1] + x * (b[1] - a[1]), a[2] + x * (b[2] - a[2])};
}

}  // namespace

std::array<float, 3> ramp_color(ColorRamp ramp, double x) {
  constexpr Lab kNight{16.0, 12.0, -34.0}, kYellow{88.0, -4.0, 66.0};
  constexpr Lab kBlue{42.0, -2.0, -45.0}, kWhite{96.0, 0.0, 0.0}, kOrange{52.0, 38.0, 58.0};
  const double t = std::clamp(x, 0.0, 1.0);
  const Lab lab = ramp == ColorRamp::Sequential ? mixed_lab(kNight, kYellow, t)
                  : t < 0.5                     ? mixed_lab(kBlue, kWhite, 2.0 * t)
                                                : mixed_lab(kWhite, kOrange, 2.0 * t - 1.0);
  const std::array<double, 3> rgb = linear_from_lab(lab);
  std::array<float, 3> out{};
  for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<float>(std::clamp(rgb[c], 0.0, 1.0));
  return out;
}

ImageF ramp_picture(const ImageF& values, const ImageU8& mask, double low, double high, ColorRamp ramp) {
  if (values.channels() != 1 || (!mask.empty() && !mask.same_size(values)))
    throw InvalidInput("ramp picture: one channel and a mask of its size are needed");
  if (!(low < high)) throw InvalidInput("ramp picture: `low` must be below `high`");
  ImageF out(values.width(), values.height(), 3, kOutside);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      const std::array<float, 3> rgb = ramp_color(ramp, (static_cast<double>(values.at(x, y)) - low) / (high - low));
      std::copy(rgb.begin(), rgb.end(), out.pixel(x, y).begin());
    }
  }
  return out;
}

}  // namespace patinate
