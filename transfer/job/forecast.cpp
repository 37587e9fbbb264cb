#include "transfer/job/forecast.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/text.h"
#include "patinate/geometry/mesh.h"
#include "transfer/synthesis/transfer_controls.h"
#include "transfer/synthesis/whole_windows.h"

namespace patinate::transfer {

namespace {

constexpr std::int64_t kMaxLookedAt = 1 << 18;  ///< Texels that the forecast looks at, evenly picked.
constexpr std::size_t kBins = 64;               ///< Steps of a control in which shares are counted.
constexpr double kManyCopies = 10.0;  // A choice: rows were seen at 59 and are not at 200 since reuse is balanced;
                                      // pieces are found again sooner.
constexpr double kSmallShare = 0.25;  // Share of the source.
constexpr std::int64_t kFewWindows =
    40;  // Beside each other: a square of some 44 pixels. A choice: what a few dozen pieces are laid from repeats.
constexpr double kRare = 1e-4;  // Share of the surface: not what it asks for.

using Shares = std::array<double, kBins>;

/// Every step-th pixel of every step-th row.
template <class T>
Image<T> thinned(const Image<T>& image, int step) {
  Image<T> result((image.width() + step - 1) / step, (image.height() + step - 1) / step);
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) result.at(x, y) = image.at(x * step, y * step);
  }
  return result;
}

/// How often values occur.
Shares shares_of(const ImageF& values, const ImageU8& mask) {
  Shares shares{};
  double total = 0.0;
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) {
    if (!mask.empty() && mask.data()[i] == 0) continue;
    const double value = std::clamp(static_cast<double>(values.data()[i]), 0.0, 1.0);
    shares[std::min(kBins - 1, static_cast<std::size_t>(value * kBins))] += 1.0;
    total += 1.0;
  }
  for (double& s : shares) s /= std::max(1.0, total);
  return shares;
}

/// With the bins beside each: pixels of nearly the same value serve as well.
double around(const Shares& shares, std::size_t bin) {
  double sum = shares[bin];
  if (bin > 0) sum += shares[bin - 1];
  if (bin + 1 < kBins) sum += shares[bin + 1];
  return sum;
}

/// Nearest bin that has pixels, for a bin without.
std::size_t filled_bin(const Shares& source, std::size_t bin) {
  for (std::size_t away = 0; away < kBins; ++away) {
    if (bin >= away && source[bin - away] > 0.0) return bin - away;
    if (bin + away < kBins && source[bin + away] > 0.0) return bin + away;
  }
  return bin;
}

struct Demand {
  double copies = 1.0;  ///< Copies of what is asked for, relative to equal use.
  double asked = 1.0;   ///< Share of the source.
};
Demand demand_of(const Shares& source, const Shares& surface) {
  Shares asked{};
  for (std::size_t b = 0; b < kBins; ++b) asked[filled_bin(source, b)] += surface[b];
  Demand demand{.copies = 0.0, .asked = 0.0};
  for (std::size_t b = 0; b < kBins; ++b) {
    const double have = around(source, b), want = around(asked, b);
    if (have > 0.0) demand.copies += asked[b] * want / have;
    if (want > kRare) demand.asked += source[b];
  }
  return demand;
}

}  // namespace

TransferForecast forecast_transfer(const TransferInput& input, int neighborhood_radius_px) {
  const ImageU8 mask = usable_mask(*input.history, input.source_mask);
  int step = 1;
  while (input.map->num_texels() / step / step > kMaxLookedAt) ++step;
  ImageU8 coverage = thinned(input.map->coverage(), step);
  if (std::all_of(coverage.values().begin(), coverage.values().end(), [](std::uint8_t c) { return c == 0; })) {
    step = 1;  // Charts narrower than a step.
    coverage = input.map->coverage();
  }
  std::vector<TransferControl> controls;
  for (const TransferControl& c : input.controls)
    controls.push_back({c.source, c.destination, thinned(c.values, step), c.range, c.weight, c.mapping});
  const MatchedControls matched = match_controls(*input.history, mask, controls, coverage);
  TransferForecast forecast;
  forecast.num_pixels = mask.num_pixels();
  forecast.num_usable =
      std::count_if(mask.values().begin(), mask.values().end(), [](std::uint8_t m) { return m != 0; });
  const int radius_px = neighborhood_radius_px > 0 ? neighborhood_radius_px : 3;
  forecast.window_px = 2 * radius_px + 1;
  forecast.num_whole = num_whole_windows(mask, radius_px);
  const Mesh& mesh = input.map->mesh();
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
    forecast.surface_mm2 += 0.5 * area_vector(mesh, t).norm();
  const double source_mm2 = static_cast<double>(forecast.num_usable) * input.texel_size_mm * input.texel_size_mm;
  forecast.surface_share = forecast.surface_mm2 / source_mm2;
  forecast.num_copies = forecast.surface_share;
  for (std::size_t c = 0; c < matched.source.size(); ++c) {
    const Demand demand = demand_of(shares_of(matched.source[c], mask), shares_of(matched.destination[c], coverage));
    forecast.num_copies = std::max(forecast.num_copies, demand.copies * forecast.surface_share);
    if (demand.asked >= forecast.asked_share) continue;
    forecast.asked_share = demand.asked;
    forecast.narrowest = input.controls[c].source;
  }
  return forecast;
}

std::vector<std::string> warnings_of(const TransferForecast& f) {
  std::vector<std::string> warnings;
  const double usable = static_cast<double>(f.num_usable) / static_cast<double>(f.num_pixels);
  if (usable < kSmallShare) {
    warnings.push_back(
        "only " + percent_text(usable, 2) + " of the history can be copied (" + std::to_string(f.num_usable) + " of " +
        std::to_string(f.num_pixels) + " pixels are inside the mask, " + std::to_string(f.num_whole) +
        " of them with their whole neighborhood); use a larger mask, or photographs that show the object larger");
  }
  if (usable >= kSmallShare && f.num_whole < kFewWindows * f.window_px * f.window_px) {
    const std::string side = std::to_string(f.window_px);
    warnings.push_back("only " + std::to_string(f.num_usable) + " pixels of the history can be copied, " +
                       std::to_string(f.num_whole) + " of them with their whole neighborhood of " + side + " x " +
                       side + ", so that copied pieces will repeat visibly; use a larger photograph or mask");
  }
  if (f.asked_share < kSmallShare) {
    warnings.push_back(
        "control `" + f.narrowest + "`: the values on the mesh occur in only " + percent_text(f.asked_share, 2) +
        " of the history, and the rest of it is not used; use a map with more values, or the mapping `rank`");
  }
  if (f.num_copies >= kManyCopies) {
    warnings.push_back(
        "the surface is as large as " + short_number_text(std::round(f.num_copies)) +
        " copies of the usable part of the history, so that pieces will repeat; photograph a larger piece, combine "
        "several "
        "histories into a library, or lay pixels larger (--texel-size where the mesh has a unit, else a smaller "
        "--resolution)");
  }
  return warnings;
}

}  // namespace patinate::transfer
