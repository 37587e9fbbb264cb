#include "patinate/datasets/crackle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "datasets_synthetic/crackle_io.h"
#include "libcommon/metrics/correlation.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"

namespace patinate::datasets {
namespace {

CrackleOptions small(std::int64_t seed = 1) {
  return {.width = 256, .height = 192, .texel_size_mm = 0.12, .num_frames = 8, .noise = 0.0, .seed = seed};
}

struct CellStatistics {
  double area = 0.0;
  double thickness = 0.0;
  bool touches_border = false;
};

std::vector<CellStatistics> cell_statistics(const CrackleDataset& d) {
  std::vector<CellStatistics> cells(static_cast<std::size_t>(d.num_cells) + 1);
  for (int y = 0; y < d.options.height; ++y) {
    for (int x = 0; x < d.options.width; ++x) {
      CellStatistics& c = cells[d.cells.at(x, y)];
      c.area += 1.0;
      c.thickness += static_cast<double>(d.thickness_mm.at(x, y));
      if (x == 0 || y == 0 || x == d.options.width - 1 || y == d.options.height - 1) c.touches_border = true;
    }
  }
  for (CellStatistics& c : cells) c.thickness /= std::max(1.0, c.area);
  return cells;
}

TEST(Crackle, FollowsAThicknessThatIsGiven) {
  CrackleOptions options = small();
  options.width = 512;
  options.height = 256;
  ImageF share(512, 256);
  for (int y = 0; y < 256; ++y) {
    for (int x = 256; x < 512; ++x) share.at(x, y) = 1.0f;
  }
  const CrackleDataset d = crackle(options, {}, share);
  EXPECT_FLOAT_EQ(d.thickness_mm.at(10, 10), static_cast<float>(options.thickness_min_mm));
  EXPECT_FLOAT_EQ(d.thickness_mm.at(500, 10), static_cast<float>(options.thickness_max_mm));
  std::array<int, 2> cells{};
  for (const CellStatistics& c : cell_statistics(d)) {
    if (c.area >= 8.0) ++cells[c.thickness > 0.3 ? 1 : 0];
  }
  // Spacing goes as the thickness, 5 : 1, so there are 25 cells for one; the rim of the halves and the plate blurs it.
  EXPECT_GT(cells[0], 8 * cells[1]);
  EXPECT_THROW((void)crackle(options, {}, ImageF(8, 8)), InvalidInput);
  EXPECT_THROW((void)crackle(options, {}, ImageF(512, 256, 1, 2.0f)), InvalidInput);
}

TEST(Crackle, HasLargerCellsWhereThePaintIsThick) {
  for (const std::int64_t seed : {1, 2, 3}) {
    CrackleOptions options = small(seed);
    options.width = options.height = 384;
    const CrackleDataset d = crackle(options);
    std::vector<double> area, thickness;
    for (const CellStatistics& c : cell_statistics(d)) {
      if (c.touches_border || c.area < 8.0) continue;
      area.push_back(c.area);
      thickness.push_back(c.thickness);
    }
    area.erase(area.begin());  // Number 0: the cracks.
    thickness.erase(thickness.begin());
    ASSERT_GT(area.size(), 60u);
    EXPECT_GT(rank_correlation(area, thickness), 0.6) << "seed " << seed;
  }
}

TEST(Crackle, RunsStraighterWhereThePaintIsThick) {
  const CrackleDataset d = crackle({.width = 384, .height = 384, .num_frames = 8});
  // Mean turn over 4 px of the cracks' middle parts, away from where they meet others.
  double turn[2] = {0.0, 0.0}, count[2] = {0.0, 0.0};
  for (const Crack& crack : d.cracks) {
    if (crack.is_dead_end) continue;
    for (std::size_t i = 12; i + 12 < crack.points_px.size(); i += 4) {
      const auto &a = crack.points_px[i - 8], &b = crack.points_px[i], &c = crack.points_px[i + 8];
      const int x = static_cast<int>(b[0]), y = static_cast<int>(b[1]);
      if (!d.thickness_mm.contains(x, y)) continue;
      const double angle =
          std::remainder(std::atan2(c[1] - b[1], c[0] - b[0]) - std::atan2(b[1] - a[1], b[0] - a[0]), 2 * M_PI);
      const int which = d.thickness_mm.at(x, y) > 0.35f ? 1 : d.thickness_mm.at(x, y) < 0.2f ? 0 : -1;
      if (which >= 0) turn[which] += std::abs(angle), count[which] += 1.0;
    }
  }
  EXPECT_LT(turn[1] / count[1], 0.6 * turn[0] / count[0]);
}

TEST(Crackle, MeetsOlderCracksNearARightAngle) {
  const CrackleDataset d = crackle({.width = 384, .height = 384, .num_frames = 8});
  std::vector<double> angles;
  for (std::size_t k = 1; k < d.cracks.size(); ++k) {
    const auto& points = d.cracks[k].points_px;
    if (d.cracks[k].is_dead_end || points.size() < 20) continue;
    const auto &tip = points.back(), &before = points[points.size() - 7];
    const double heading = std::atan2(tip[1] - before[1], tip[0] - before[0]);
    for (std::size_t m = 0; m < k; ++m) {
      const auto& other = d.cracks[m].points_px;
      const auto nearest = std::min_element(other.begin(), other.end(), [&](const auto& p, const auto& q) {
        return std::hypot(p[0] - tip[0], p[1] - tip[1]) < std::hypot(q[0] - tip[0], q[1] - tip[1]);
      });
      if (std::hypot((*nearest)[0] - tip[0], (*nearest)[1] - tip[1]) > 1.5) continue;
      const auto i = nearest - other.begin();
      if (i < 6 || i + 6 >= static_cast<std::ptrdiff_t>(other.size())) continue;
      const auto &a = other[i - 6], &b = other[i + 6];
      const double off = std::abs(std::sin(heading - std::atan2(b[1] - a[1], b[0] - a[0])));
      angles.push_back(std::asin(std::min(1.0, off)) * 180.0 / M_PI);
      break;
    }
  }
  ASSERT_GT(angles.size(), 40u);
  std::nth_element(angles.begin(), angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2), angles.end());
  EXPECT_GT(angles[angles.size() / 2], 70.0);  // Random crossings would give a median of 60 degrees.
}

TEST(Crackle, NeverClosesAgain) {
  const CrackleDataset d = crackle(small());
  ImageF before = crack_share(d, 0.0);
  EXPECT_EQ(*std::max_element(before.values().begin(), before.values().end()), 0.0f);
  for (int i = 1; i < d.options.num_frames; ++i) {
    const ImageF now = crack_share(d, i * d.options.interval_s);
    for (std::size_t p = 0; p < now.values().size(); ++p) ASSERT_GE(now.values()[p], before.values()[p]);
    before = now;
  }
  const double mean = std::accumulate(before.values().begin(), before.values().end(), 0.0) /
                      static_cast<double>(before.values().size());
  EXPECT_GT(mean, 0.02);
  EXPECT_LT(mean, 0.25);
}

TEST(Crackle, OpensWhenItsTruthSaysSo) {
  // A pixel whose center lies in a crack is covered by at least half of a pixel's width, or by the whole width of a
  // thinner crack.
  const CrackleDataset d = crackle(small());
  const double time = 0.6 * d.duration_s();
  const ImageF share = crack_share(d, time);
  int num_open = 0;
  for (std::size_t p = 0; p < share.values().size(); ++p) {
    const float opening = d.opening_s.values()[p];
    if (opening >= 0.0f && static_cast<double>(opening) <= time) {
      ++num_open;
      EXPECT_GT(share.values()[p], 0.0f);
    } else {
      EXPECT_LE(share.values()[p], 0.5001f + 0.0f);
    }
  }
  EXPECT_GT(num_open, 100);
}

TEST(Crackle, BeginsToCrackWhereThePaintIsThin) {
  double first = 0.0, all = 0.0, num_all = 0.0;
  for (const std::int64_t seed : {1, 2, 3}) {
    const CrackleDataset d = crackle({.width = 384, .height = 384, .num_frames = 8, .seed = seed});
    for (std::size_t k = 0; k < d.cracks.size(); ++k) {
      const auto& p = d.cracks[k].points_px[d.cracks[k].origin];
      const int x = static_cast<int>(std::lround(p[0])), y = static_cast<int>(std::lround(p[1]));
      if (k < 5) first += static_cast<double>(d.thickness_mm.at(x, y)) / 15.0;
      if (k > 0 && !d.cracks[k].is_dead_end) {
        EXPECT_GE(d.cracks[k].start_s, d.cracks[k - 1].start_s);
      }
    }
    for (const float h : d.thickness_mm.values()) all += static_cast<double>(h), num_all += 1.0;
  }
  EXPECT_LT(first, 0.9 * all / num_all);
}

TEST(Crackle, TransmitsByItsLawWhereThePaintIsWhole) {
  for (const TransmissionLaw law :
       {TransmissionLaw::BeerLambert, TransmissionLaw::Reciprocal, TransmissionLaw::Linear}) {
    CrackleOptions options = small();
    options.law = law;
    options.absorption_per_mm = 1.7;
    const CrackleDataset d = crackle(options);
    const ImageF light = transmitted(d), share = crack_share(d, d.duration_s());
    for (std::size_t p = 0; p < light.values().size(); ++p) {
      const double h = static_cast<double>(d.thickness_mm.values()[p]);
      const double x = 1.7 * h;
      const double expected = law == TransmissionLaw::BeerLambert ? std::exp(-x)
                              : law == TransmissionLaw::Linear    ? 1.0 - x
                                                                  : 1.0 / (1.0 + x);
      const double ratio = static_cast<double>(light.values()[p]) / static_cast<double>(d.backlight.values()[p]);
      if (share.values()[p] == 0.0f) {
        EXPECT_NEAR(ratio, expected, 2e-7);
      } else {
        EXPECT_GE(ratio, expected - 2e-7);
      }
    }
  }
}

TEST(Crackle, PhotographWithoutNoiseIsTheSrgbCode) {
  ImageF linear(256, 1);
  for (int i = 0; i < 256; ++i) linear.at(i, 0) = linear_from_srgb(static_cast<float>(i) / 255.0f);
  const ImageU8 codes = photograph(linear, 0.0, 1, 0);
  for (int i = 0; i < 256; ++i) EXPECT_EQ(codes.at(i, 0), i);
}

TEST(Crackle, PhotographNoiseHasTheStatedDeviation) {
  const ImageU8 codes = photograph(ImageF(128, 128, 1, 0.2f), 0.02, 1, 0);
  double sum = 0.0, squares = 0.0;
  for (const std::uint8_t c : codes.values()) sum += c, squares += static_cast<double>(c) * c;
  const double n = static_cast<double>(codes.values().size());
  const double deviation = std::sqrt(squares / n - (sum / n) * (sum / n));
  // 4 sigma of a sample deviation: 4 / sqrt(2 N) of it; rounding to codes adds 1/12.
  const double expected = std::sqrt(5.1 * 5.1 + 1.0 / 12.0);
  EXPECT_NEAR(deviation, expected, 4.0 * expected / std::sqrt(2.0 * n));
}

TEST(Crackle, DependsOnTheSeedAndNotOnThreads) {
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const CrackleDataset a = crackle(small(), one), b = crackle(small(), three);
  EXPECT_EQ(a.opening_s, b.opening_s);
  EXPECT_EQ(reflected(a, 30.0, one), reflected(b, 30.0, three));
  EXPECT_NE(a.opening_s, crackle(small(2)).opening_s);
}

TEST(Crackle, RefusesOptionsThatContradictEachOther) {
  EXPECT_THROW((void)crackle({.thickness_min_mm = 0.4, .thickness_max_mm = 0.3}), InvalidInput);
  EXPECT_THROW((void)crackle({.law = TransmissionLaw::Linear, .absorption_per_mm = 2.0}), InvalidInput);
  EXPECT_THROW((void)crackle({.noise = std::nan("")}), InvalidInput);
  EXPECT_THROW((void)crackle({.width = 0}), InvalidInput);
}

TEST(CrackleIo, WritesPhotographsAndTruthThatReadBack) {
  const testing_support::TempFolder folder;
  CrackleOptions options = small();
  options.width = options.height = 64;
  options.num_frames = 3;
  const JobPlan plan = plan_crackle(options, folder / "out");
  const std::filesystem::path out = folder / "out";
  std::filesystem::create_directories(out);
  for (const JobItem& item : plan.items) {
    item.run(out, {});
    for (const auto& file : item.outputs) EXPECT_TRUE(std::filesystem::exists(out / file)) << file;
  }
  plan.join(out, {});
  EXPECT_TRUE(std::filesystem::exists(out / "capture.json"));
  EXPECT_TRUE(std::filesystem::exists(out / plan.manifest));
  const CrackleDataset d = crackle(options);
  EXPECT_EQ(read_gray(out / "truth/thickness.exr"), d.thickness_mm);
  EXPECT_EQ(read_gray(out / "truth/opening.exr"), d.opening_s);
  const ImageF last = read_color(out / "frames/0002.png");
  const ImageF expected = reflected(d, 2 * options.interval_s);
  for (std::size_t i = 0; i < last.values().size(); ++i) {
    EXPECT_NEAR(last.values()[i], expected.values()[i], 0.0047);  // Half a code at the steepest end of the sRGB curve.
  }
  options.seed = 9;
  EXPECT_NE(plan_crackle(options, folder / "out").key, plan.key);
}

}  // namespace
}  // namespace patinate::datasets
