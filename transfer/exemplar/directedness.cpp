#include "transfer/exemplar/directedness.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libcommon/image/filters.h"
#include "transfer/exemplar/structure.h"

namespace patinate::transfer {

double directedness(const ImageF& lightness, const ImageU8& mask, const RunControl& control) {
  // Gaussians whose difference is the band in which directions are measured.
  constexpr double kFine_px = 1.0, kCoarse_px = 8.0;
  ImageF band = gaussian_blur(lightness, mask, kFine_px, control);
  const ImageF coarse = gaussian_blur(lightness, mask, kCoarse_px, control);
  for (std::int64_t i = 0; i < band.num_pixels(); ++i) band.data()[i] -= coarse.data()[i];
  constexpr double kFlat = 1e-6;  // Squared L* a pixel: less is rounding.
  double weight = 0.0, double_x = 0.0, double_y = 0.0, fourfold_x = 0.0, fourfold_y = 0.0;
  for (int y = 1; y + 1 < band.height(); ++y) {
    for (int x = 1; x + 1 < band.width(); ++x) {
      if (!is_inside(mask, x - 1, y) || !is_inside(mask, x + 1, y) || !is_inside(mask, x, y - 1) ||
          !is_inside(mask, x, y + 1))
        continue;
      const auto dx = static_cast<double>(band.at(x + 1, y) - band.at(x - 1, y)),
                 dy = static_cast<double>(band.at(x, y + 1) - band.at(x, y - 1));
      const double squared = dx * dx + dy * dy;
      if (squared < kFlat) continue;
      const double c = (dx * dx - dy * dy) / squared,
                   s = 2.0 * dx * dy / squared;  // Cosine and sine of twice the angle.
      weight += squared;
      double_x += squared * c, double_y += squared * s;
      fourfold_x += squared * (c * c - s * s), fourfold_y += squared * 2.0 * c * s;
    }
  }
  if (!(weight > 0.0)) return 0.0;
  return std::max(std::sqrt(double_x * double_x + double_y * double_y),
                  std::sqrt(fourfold_x * fourfold_x + fourfold_y * fourfold_y)) /
         weight;
}

double directedness(const History& history, const ImageU8& mask, const RunControl& control) {
  const HistoryFacts& facts = history.facts();
  const ImageF lightness = lightness_of(history.read_frame(history.num_frames() - 1));
  if (facts.parts.empty()) return directedness(lightness, mask, control);
  double most = 0.0;
  for (const LibraryPart& part : facts.parts) {
    most = std::max(most, directedness(crop(lightness, part.x, 0, part.width, part.height),
                                       mask.empty() ? mask : crop(mask, part.x, 0, part.width, part.height), control));
  }
  return most;
}

}  // namespace patinate::transfer
