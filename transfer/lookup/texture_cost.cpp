#include "transfer/lookup/texture_cost.h"

#include <algorithm>

namespace patinate::transfer {

namespace {

/// Measured in November 2026 on atlases of 256, 512 and 1024 texels of a history of 256 x 192 pixels (docs/scaling.md).
struct FormatCost {
  double seconds, texel_seconds, megabytes;
};
constexpr FormatCost kCoded{0.08, 4.2e-7, 90.0}, kExr{0.07, 2.8e-7, 90.0}, kJpeg{0.58, 1e-7, 215.0};
constexpr double kReadPixel_seconds = 2e-7, kPixel_mb = 5e-5;  ///< Of the history.
constexpr double kKeptTexel_mb = 5e-6, kMostKept = 16777216.0;

}  // namespace

JobCost texture_cost(const TransferFolder& transfer, const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  const FormatCost& cost = extension == ".exr" ? kExr : extension == ".jpg" || extension == ".jpeg" ? kJpeg : kCoded;
  const TransferManifest& m = transfer.manifest();
  const double texels = static_cast<double>(m.width) * m.height * static_cast<double>(m.tiles.size());
  const HistoryManifest& h = transfer.history().manifest();
  const double pixels = static_cast<double>(h.width) * h.height;
  return {.core_seconds = cost.seconds + cost.texel_seconds * texels + kReadPixel_seconds * pixels,
          .megabytes = cost.megabytes + kPixel_mb * pixels + kKeptTexel_mb * std::min(texels, kMostKept)};
}

}  // namespace patinate::transfer
