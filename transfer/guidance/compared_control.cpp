#include "transfer/guidance/compared_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libcommon/image/filters.h"
#include "patinate/transfer/control_matching.h"

namespace patinate::transfer {

namespace {

/// Grain: a tenth of the variance within 15 px (docs/algorithms/control_matching.md).
constexpr double kFine_px = 15.0, kMaxFine = 0.1;
/// Steps of sqrt(2); the least that leaves at most kMaxFine is taken.
constexpr std::array<double, 7> kBlurs_px{2.0, 2.8, 4.0, 5.7, 8.0, 11.3, 16.0};

struct Variances {
  double all = 0.0, fine = 0.0;
};

/// @param values  Only those inside the mask count.
Variances variances_of(const ImageF& values, const ImageU8& mask, const RunControl& control) {
  const double window_px = kFine_px / std::sqrt(12.0);  // A Gaussian of the variance of a square of that side.
  const ImageF means = gaussian_blur(values, mask, window_px, control);
  double sum = 0.0, squares = 0.0, fine = 0.0, count = 0.0;
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) {
    if (!mask.empty() && mask.data()[i] == 0) continue;
    const double v = static_cast<double>(values.data()[i]), beside = v - static_cast<double>(means.data()[i]);
    sum += v, squares += v * v, fine += beside * beside, count += 1.0;
  }
  if (count == 0.0) return {};
  return {squares / count - (sum / count) * (sum / count), fine / count};
}

}  // namespace

ImageF without_fine_texture(const ImageF& values, const ImageU8& mask, double& blur_px, const RunControl& control) {
  const RunControl silent = control.silent();
  blur_px = 0.0;
  const Variances own = variances_of(values, mask, silent);
  if (!(own.fine > kMaxFine * own.all)) return values;
  ImageF blurred;
  for (const double sigma : kBlurs_px) {
    blur_px = sigma;
    blurred = gaussian_blur(values, mask, sigma, silent);
    const Variances left = variances_of(blurred, mask, silent);
    if (left.fine <= kMaxFine * left.all) break;
  }
  return match_control(blurred, mask, {}, values, mask, {}, ControlMapping::Rank, silent);
}

ImageF compared_control(const History& history, const std::string& name, const ImageU8& mask,
                        const RunControl& control) {
  ImageF values = history.read_control(name);
  const std::vector<LibraryPart>& parts = history.facts().parts;
  double blur_px = 0.0;
  if (parts.empty()) return without_fine_texture(values, mask, blur_px, control);
  if (name == kLibraryControl) return values;
  for (const LibraryPart& part : parts) {
    const ImageU8 inside = crop(mask, part.x, 0, part.width, part.height);
    if (std::all_of(inside.values().begin(), inside.values().end(), [](std::uint8_t m) { return m == 0; })) continue;
    const ImageF smooth =
        without_fine_texture(crop(values, part.x, 0, part.width, part.height), inside, blur_px, control);
    for (int y = 0; y < part.height; ++y) std::copy(smooth.row(y).begin(), smooth.row(y).end(), &values.at(part.x, y));
  }
  return values;
}

}  // namespace patinate::transfer
