#include "datasets_synthetic/panel_stains.h"

#include <algorithm>
#include <cmath>

#include "datasets_synthetic/fitted_factor.h"
#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kStreakStream = 1520, kSwayStream = 1521, kRunStream = 1522;  // Streams of random numbers.
constexpr std::int64_t kStreakRows = 16;
constexpr double kStreakAreaMm2 = 14.0;  ///< About what a streak tints.
constexpr double kReachOfWidth = 1.6;    ///< Where a Gaussian of half the width is below 1 %.

/// The shape of a streak, [0, 1], at a place relative to its head. @param down  Share of its length.
double streak_shape(double across_px, double down_px, double length_px, double width_px) {
  const double down = down_px / length_px;
  const double run = smooth_step(-0.05, 0.08, down) * std::pow(std::max(0.0, 1.0 - down), 0.8);
  const double sigma = width_px * (0.5 - 0.22 * std::clamp(down, 0.0, 1.0));
  const double trail = run * std::exp(-0.5 * across_px * across_px / (sigma * sigma));
  const double halo = 0.7 * std::exp(-0.5 * (across_px * across_px + down_px * down_px) / (0.3 * width_px * width_px));
  return std::max(trail, halo);
}

/// Spots in the test area, the largest first.
std::vector<const SpotOutline*> sources(const PanelOptions& o, const std::vector<SpotOutline>& spots) {
  std::vector<const SpotOutline*> out;
  for (const SpotOutline& spot : spots) {
    if (in_test_area(o, o.pixel_mm * Vec2(spot.x_px, spot.y_px))) out.push_back(&spot);
  }
  std::stable_sort(out.begin(), out.end(), [](const auto* a, const auto* b) { return a->radius_px > b->radius_px; });
  return out;
}

double cell_px(const PanelOptions& o, double mm) { return std::max(1.5, mm / o.pixel_mm); }

std::vector<Streak> unscaled_streaks(const PanelOptions& o, const std::vector<SpotOutline>& spots,
                                     const SampleFrame& test_area) {
  const double area = static_cast<double>(test_area.num_samples()) / kSamplesPerPixel * o.pixel_mm * o.pixel_mm;
  const int count =
      std::max(1, static_cast<int>(std::lround(-std::log(1.0 - 0.01 * o.stains) * area / kStreakAreaMm2)));
  const std::vector<const SpotOutline*> heads = sources(o, spots);
  const double edge = o.edge_mm / o.pixel_mm;
  std::vector<Streak> streaks;
  for (int i = 0; i < count; ++i) {
    RandomStream random(static_cast<std::uint64_t>(o.seed), static_cast<std::uint64_t>(i), kStreakStream);
    Streak streak{.x_px = edge + random.uniform() * (o.width - 2.0 * edge),
                  .y_px = edge + 0.7 * random.uniform() * (o.height - 2.0 * edge),
                  .length_px = (6.0 + 12.0 * random.uniform()) / o.pixel_mm,
                  .width_px = (0.8 + 1.0 * random.uniform()) / o.pixel_mm,
                  .opacity = 0.3 + 0.3 * random.uniform(),
                  .start_h = o.hours * (0.05 + 0.4 * random.uniform())};
    // Two of three run down from a spot, as long as there are spots.
    const std::size_t spot = static_cast<std::size_t>(2 * i / 3);
    if (i % 3 != 2 && spot < heads.size()) {
      streak.x_px = heads[spot]->x_px;
      streak.y_px = heads[spot]->y_px;
      streak.width_px = std::max(streak.width_px, 1.3 * heads[spot]->radius_px);
      streak.start_h = std::min(0.9 * o.hours, heads[spot]->start_h + 0.05 * o.hours);
    }
    streaks.push_back(streak);
  }
  return streaks;
}

}  // namespace

ImageF Stains::draw(double hours, double scale, const RunControl& control) const {
  const PanelOptions& o = options_;
  ImageF stain(o.width, o.height);
  parallel_for(o.height, kStreakRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (const Streak& streak : streaks_) {
      const double grown = mark_growth(hours, streak.start_h, o.hours);
      if (!(grown > 0.0)) continue;
      const double width = scale * streak.width_px, length = scale * streak.length_px * (0.3 + 0.7 * grown);
      const double side = kReachOfWidth * width + 1.0 / o.pixel_mm;
      const PixelBox box = pixel_box(streak.x_px - side, streak.y_px - side, streak.x_px + side,
                                     streak.y_px + std::max(length, side), o.width, o.height);
      for (int y = std::max(box.y0, static_cast<int>(begin)); y < std::min(box.y1, static_cast<int>(end)); ++y) {
        for (int x = box.x0; x < box.x1; ++x) {
          const double across = x + 0.5 - streak.x_px + 0.8 / o.pixel_mm * sway_(x, y);
          const double shape = streak_shape(across, y + 0.5 - streak.y_px, length, width);
          if (shape < 0.01) continue;
          const double opacity = streak.opacity * grown * shape * (0.85 + 0.5 * runs_(x, y));
          float& out = stain.at(x, y);
          out = 1.0f - (1.0f - out) * (1.0f - static_cast<float>(std::clamp(opacity, 0.0, 0.95)));
        }
      }
    }
  });
  return stain;
}

double stained_percent(const ImageF& stain, const SampleFrame& test_area) {
  std::int64_t sum = 0;
  for (int y = 0; y < stain.height(); ++y) {
    for (int x = 0; x < stain.width(); ++x) {
      if (static_cast<double>(stain.at(x, y)) >= PanelFigures::kVisibleStain) sum += sample_count(test_area.at(x, y));
    }
  }
  return 100.0 * static_cast<double>(sum) / static_cast<double>(test_area.num_samples());
}

Stains::Stains(const PanelOptions& o, const std::vector<SpotOutline>& spots, const SampleFrame& test_area,
               const RunControl& control)
    : options_(o),
      sway_(static_cast<std::uint64_t>(o.seed), kSwayStream, o.width, o.height, cell_px(o, 8.0), cell_px(o, 5.0)),
      runs_(static_cast<std::uint64_t>(o.seed), kRunStream, o.width, o.height, cell_px(o, 0.5), cell_px(o, 7.0)) {
  if (!(o.stains > 0.0)) return;
  streaks_ = unscaled_streaks(o, spots, test_area);
  const double factor = fitted_factor(
      o.stains, [&](double scale) { return stained_percent(draw(o.hours, scale, control.silent()), test_area); });
  for (Streak& streak : streaks_) {
    streak.length_px *= factor;
    streak.width_px *= factor;
  }
}

}  // namespace patinate::datasets
