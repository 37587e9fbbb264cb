#include <gtest/gtest.h>

#include <cmath>

#include "analysis/compare/sections.h"
#include "analysis/fit/aged_surface.h"
#include "libcommon/core/random.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

using testing_support::TempFolder;

constexpr int kPlateSide = 128, kCell = 16;

/// A gray plate; later a dark dash of a cell's width and two pixels lies across each of 64 cells or does not, by the
/// toss of a coin.
AgedSurface dashed(std::uint64_t seed) {
  AgedSurface surface{.name = "dashed",
                      .time_unit = TimeUnit::Days,
                      .texel_size_mm = {},
                      .times = {0.0, 1.0},
                      .colors = {},
                      .mask = ImageU8(kPlateSide, kPlateSide, 1, 255),
                      .controls = {}};
  surface.colors.assign(2, ImageF(kPlateSide, kPlateSide, 3, 0.5F));
  for (int cell = 0; cell < (kPlateSide / kCell) * (kPlateSide / kCell); ++cell) {
    if (RandomStream(seed, static_cast<std::uint64_t>(cell)).uniform() < 0.5) continue;
    const int left = cell % (kPlateSide / kCell) * kCell, top = cell / (kPlateSide / kCell) * kCell + kCell / 2;
    for (int y = top; y < top + 2; ++y) {
      for (int x = left; x < left + kCell; ++x) {
        for (int c = 0; c < 3; ++c) surface.colors[1].at(x, y, c) = 0.05F;
      }
    }
  }
  return surface;
}

Figure share_of(const TempFolder& folder, std::uint64_t seed) {
  write_surface(folder.path() / "s", dashed(seed), "0123456789abcdef");
  const CompareOptions options{.places = Places::Never, .cracks = true, .seed = seed};
  const auto series = [&] { return open_series(folder.path() / "s").series; };
  const Section section = cracks_section(load_pair(series(), series(), options), options);
  for (const Figure& f : section.figures) {
    if (f.name == "crack_share_a") return f;
  }
  ADD_FAILURE() << "no share";
  return {};
}

TEST(CrackIntervals, OfAShareHoldTheTrueOneAsOftenAsTheySay) {
  const TempFolder folder;
  constexpr int kSurfaces = 40;
  std::vector<Figure> shares;
  double mean = 0.0;
  for (int k = 0; k < kSurfaces; ++k) {
    shares.push_back(share_of(folder, static_cast<std::uint64_t>(k)));
    ASSERT_TRUE(shares.back().low && shares.back().high);
    mean += *shares.back().value / kSurfaces;
  }
  // Half of 64 dashes of 32 pixels; four standard deviations of a mean over 40 x 64 coins.
  constexpr double kDash = 32.0 / (kCell * kCell);
  EXPECT_NEAR(mean, 0.5 * kDash, 4.0 * 0.5 * kDash / std::sqrt(40.0 * 64.0));
  int held = 0;
  for (const Figure& f : shares) held += *f.low <= mean && mean <= *f.high;
  EXPECT_GE(held, kSurfaces * (0.95 - 3.0 * std::sqrt(0.95 * 0.05 / kSurfaces)));  // Three sigma of a share.
}

}  // namespace
}  // namespace patinate::analysis
