#include "transfer/synthesis/refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <stop_token>

#include "libcommon/core/random.h"
#include "patinate/history/memory_history.h"
#include "patinate/transfer/transfer.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/patch_cut.h"
#include "transfer/synthesis/source_levels.h"

namespace patinate::transfer {
namespace {

constexpr int kLinesSource = 96, kLinesSide = 64, kBlock = 16;
constexpr std::int32_t kOnePixel = PixelNeighbor::kOne;

/// Cells between dark lines, laid on a plane in blocks from anywhere: almost every line is broken.
struct BrokenLines {
  SynthesisLevel level;
  SourceStructure structure;
  SimilarPixels similar;
  PlaceMap places;
  std::vector<double> weights{1.0};

  explicit BrokenLines(const Mesh& mesh = testing_support::unit_plane(kLinesSide))
      : places(kLinesSide * kLinesSide, kLinesSource) {
    AppearanceImage appearance(kLinesSource, kLinesSource, kAppearanceSize);
    ControlImage known(kLinesSource, kLinesSource, 1), asked(kLinesSide, kLinesSide, 1);
    ImageF lightness(kLinesSource, kLinesSource);
    for (int y = 0; y < kLinesSource; ++y) {
      for (int x = 0; x < kLinesSource; ++x) {
        const bool on_line = (x + y / 4) % 19 < 2 || (y + x / 5) % 17 < 2;
        lightness.at(x, y) = on_line ? 30.0f : 70.0f;
        appearance.at(x, y, 0) = on_line ? -300 : 100;
        known.at(x, y) = static_cast<std::uint16_t>(x * kControlSteps / kLinesSource);
      }
    }
    for (int i = 0; i < kLinesSide * kLinesSide; ++i)
      asked.data()[i] = static_cast<std::uint16_t>(i % kLinesSide * kControlSteps / kLinesSide);
    const ImageU8 mask(kLinesSource, kLinesSource, 1, 255);
    structure = line_structure(lightness, mask);
    const Neighborhood neighborhood = Neighborhood::square(2);
    const auto map = std::make_shared<TexelMap>(mesh, kLinesSide, kLinesSide);
    level = {make_source_level(std::move(appearance), std::move(known), mask, 170.0 * 170.0, neighborhood),
             make_destination_level(map, std::move(asked), neighborhood, place_source(*map, nullptr, 1.0, 0))};
    similar = find_similar_pixels(level.source);
    for (TexelId t : level.destination.texels) {
      const int x = static_cast<int>(t % kLinesSide), y = static_cast<int>(t / kLinesSide);
      RandomStream random(7, static_cast<std::uint64_t>(y / kBlock * kLinesSide + x / kBlock));
      const auto begin = [&] { return 2 + static_cast<int>(random.below(kLinesSource - kBlock - 4)); };
      const int left = begin(), top = begin();
      places.set(t, place_of(level.source, (top + y % kBlock) * kLinesSource + left + x % kBlock));
    }
  }
  [[nodiscard]] SeamFeatures features() const { return {level.source, structure.channels, 1000.0}; }
  /// The sum that refinement lowers, pair by pair.
  [[nodiscard]] std::int64_t seam_sum(const PlaceMap& of) const {
    const SeamFeatures f = features();
    TexelNeighborhood::Cursor cursor(*level.destination.neighbors);
    std::int64_t sum = 0;
    for (TexelId t : level.destination.texels) {
      for_each_pair(t, cursor.at(t).subspan(level.destination.neighbors->first_adjacent()), kLinesSide,
                    [&](const PixelNeighbor& n, bool is_earlier, int weight) {
                      if (!is_earlier) sum += weight * f.seam(of.at(t), of.at(n.texel), {n.x, n.y});
                    });
    }
    return sum;
  }
  [[nodiscard]] PlaceMap refined(int num_rounds, int threads, std::uint64_t seed = 1) const {
    PlaceMap result = places;
    RunControl control;
    control.num_threads = threads;
    refine_places(level, structure, similar, weights, seed, {.num_rounds = num_rounds}, result, control);
    return result;
  }
};

TEST(SeamFeatures, AreFreeInsideAPieceAndAMetricBetweenPieces) {
  const BrokenLines task;
  ASSERT_FALSE(task.structure.empty());
  const SeamFeatures features = task.features();
  RandomStream random(3, 3);
  const auto place = [&] {
    return FixedPoint{static_cast<std::int32_t>(10 + random.below(70)) * kOnePixel,
                      static_cast<std::int32_t>(10 + random.below(70)) * kOnePixel};
  };
  for (int i = 0; i < 1000; ++i) {
    const FixedPoint a = place(), b = place(), c = place(), step{kOnePixel, i % 2 * kOnePixel};
    EXPECT_EQ(features.seam({0, a}, {0, {a.x + step.x, a.y + step.y}}, step), 0);
    // Labels are offsets: a, b and c at the first texel; each distance is rounded down.
    const auto seam = [&](const FixedPoint& p, const FixedPoint& q) {
      return features.seam({0, p}, {0, {q.x + step.x, q.y + step.y}}, step);
    };
    EXPECT_EQ(seam(a, b), seam(b, a));
    EXPECT_LE(seam(a, c), seam(a, b) + seam(b, c) + 4);
  }
}

TEST(SeamFeatures, AStepToWhereNothingCanBeCopiedIsDear) {
  const BrokenLines task;
  const FixedPoint corner{2 * kOnePixel, 2 * kOnePixel}, inside{40 * kOnePixel, 40 * kOnePixel};
  EXPECT_EQ(task.features().pixel_at(kOnePixel, kOnePixel), -1) << "the neighborhood's radius is 2";
  EXPECT_GE(task.features().seam({0, corner}, {0, inside}, {-kOnePixel, 0}), SeamFeatures::kOutside);
}

TEST(ControlCost, IsFreeWithinAHundredthAndRisesBeyond) {
  const BrokenLines task;
  const ControlCost cost(task.level.source, task.weights, 1.0);
  const std::int32_t pixel = 50 * kLinesSource + 50;
  const std::uint16_t has = task.level.source.controls.at(50, 50);
  const auto at = [&](int beside) {
    const auto target = static_cast<std::uint16_t>(has + beside);
    return cost.at(std::span(&target, 1), pixel);
  };
  EXPECT_EQ(at(0), 0);
  EXPECT_EQ(at(kControlSteps / 101), 0);
  EXPECT_EQ(at(-kControlSteps / 101), 0);
  EXPECT_GT(at(600), at(300));
  // A thousand at the spread, less what is free.
  const double spread = std::sqrt(task.level.source.control_variances[0]), free = 0.01 * kControlSteps;
  EXPECT_NEAR(at(static_cast<int>(spread)), 1000.0 * std::pow((spread - free) / spread, 2), 10.0);
}

TEST(SurfacePatch, OnAPlaneIsASquareWithItsPairs) {
  const BrokenLines task;
  PatchFinder finder(*task.level.destination.map, *task.level.destination.neighbors);
  SurfacePatch patch;
  const TexelId center = 30 * kLinesSide + 30;
  finder.find_texels(center, 3, patch);
  finder.find_edges(patch);
  ASSERT_EQ(patch.texels.size(), 49u);
  EXPECT_EQ(patch.texels[0].texel, center);
  // Row y of the atlas goes down, as the history's does.
  for (const PatchTexel& t : patch.texels) {
    EXPECT_NEAR(t.offset.x, static_cast<int>(t.texel % kLinesSide - 30) * kOnePixel, 3);
    EXPECT_NEAR(std::abs(t.offset.y), std::abs(static_cast<int>(t.texel / kLinesSide - 30)) * kOnePixel, 3);
  }
  const auto inner =
      std::count_if(patch.edges.begin(), patch.edges.end(), [](const PatchEdge& e) { return e.second >= 0; });
  EXPECT_EQ(inner, 2 * 7 * 6 + 2 * 6 * 6);
  // Each of the 32 texels of the ring around sees up to three texels of the square.
  EXPECT_EQ(static_cast<std::ptrdiff_t>(patch.edges.size()) - inner, 4 * 7 * 3 - 4);
}

/// A dome over a square, its texture seen from above.
Mesh dome(double radius) {
  Mesh mesh = testing_support::unit_plane(kLinesSide, kLinesSide);
  for (Vec3& p : mesh.positions) {
    const double x = p.x() - 0.5 * kLinesSide, y = p.y() - 0.5 * kLinesSide;
    p.z() = std::sqrt(radius * radius - x * x - y * y);
  }
  return mesh;
}

// Of half a pixel seams take no notice. Ways around a dome differ by several.
TEST(SurfacePatch, OnADomeIsNowhereTorn) {
  const BrokenLines task(dome(60.0));
  PatchFinder finder(*task.level.destination.map, *task.level.destination.neighbors);
  SurfacePatch patch;
  finder.find_texels(kLinesSide / 2 * kLinesSide + kLinesSide / 2, 30, patch);
  finder.find_edges(patch);
  ASSERT_GT(patch.texels.size(), 2000u);
  int most = 0;
  for (const PatchEdge& e : patch.edges) {
    if (e.second < 0) continue;
    const FixedPoint &a = patch.texels[e.first].offset, &b = patch.texels[e.second].offset;
    most = std::max({most, std::abs(b.x - a.x - e.step.x), std::abs(b.y - a.y - e.step.y)});
  }
  EXPECT_LT(most, kOnePixel / 2);
}

TEST(PatchCut, FindsTheCheapestOfAllBorders) {
  const BrokenLines task;
  const SeamFeatures features = task.features();
  const ControlCost control_cost(task.level.source, task.weights, 1.0);
  const Amounts amounts(task.level.source);  // Not measured: nothing is too much, nor is it near by.
  const NearbyUses nearby(task.level.source, *task.level.destination.map);
  const CutTask cut_task{.source = task.level.source,
                         .destination = task.level.destination,
                         .features = features,
                         .control_cost = control_cost,
                         .similar = task.similar,
                         .amounts = amounts,
                         .nearby = nearby};
  PatchFinder finder(*task.level.destination.map, *task.level.destination.neighbors);
  SurfacePatch patch;
  finder.find_texels(16 * kLinesSide + 16, 1, patch);  // Where four blocks meet.
  finder.find_edges(patch);
  ASSERT_EQ(patch.texels.size(), 9u);
  RandomStream random(5, 5);
  int num_better = 0;
  for (int i = 0; i < 60; ++i) {
    const FixedPoint center{static_cast<std::int32_t>(10 + random.below(70)) * kOnePixel,
                            static_cast<std::int32_t>(10 + random.below(70)) * kOnePixel};
    const auto cost = [&](unsigned labels) {
      const auto place = [&](std::int32_t n) {
        const PatchTexel& t = patch.texels[n];
        return labels >> n & 1u ? FixedPoint{center.x + t.offset.x, center.y + t.offset.y} : task.places.point(t.texel);
      };
      std::int64_t sum = 0;
      for (std::int32_t n = 0; n < 9; ++n) {
        const FixedPoint p = place(n);
        sum += control_cost.at(task.level.destination.target(patch.texels[n].texel), features.pixel_at(p.x, p.y));
      }
      for (const PatchEdge& e : patch.edges) {
        const FixedPoint second = e.second >= 0 ? place(e.second) : task.places.point(e.outside);
        sum += e.weight * features.seam({0, place(e.first)}, {0, second}, e.step);
      }
      return sum;
    };
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (unsigned labels = 0; labels < 512; ++labels) least = std::min(least, cost(labels));
    PatchCut cut(cut_task);
    cut.begin(patch, task.places);
    const std::int64_t gain = cut.lay(patch, {center, 0});
    EXPECT_EQ(gain, cost(0) - least) << i;
    num_better += gain > 0;
  }
  EXPECT_GT(num_better, 0);
}

TEST(Refinement, SmoothedPiecesSpreadWhatTheyAreShearedBy) {
  BrokenLines task;
  // The source as it is, but for a kink of almost half a pixel in the middle.
  const auto lay = [&](std::int32_t kink) {
    for (TexelId t : task.level.destination.texels) {
      const auto x = static_cast<std::int32_t>(t % kLinesSide), y = static_cast<std::int32_t>(t / kLinesSide);
      const std::int32_t beside = x >= kLinesSide / 2 ? kink : 0;
      task.places.set(t, place_at(task.level.source, {(x + 8) * kOnePixel + beside, (y + 8) * kOnePixel}));
    }
  };
  const auto largest_kink = [&] {
    std::int32_t largest = 0;
    for (TexelId t : task.level.destination.texels) {
      if (t % kLinesSide == kLinesSide - 1) continue;
      largest = std::max(largest, std::abs(task.places.point(t + 1).x - task.places.point(t).x - kOnePixel));
    }
    return largest;
  };
  const TexelNeighborhood& beside = *task.level.destination.neighbors;
  lay(0);
  const PlaceMap whole = task.places;
  smooth_places(task.level, beside, 30, task.places);
  EXPECT_EQ(task.places.pixels, whole.pixels) << "whole pixels stay";
  EXPECT_EQ(largest_kink(), 0);
  lay(120);
  ASSERT_EQ(largest_kink(), 120);
  smooth_places(task.level, beside, 30, task.places);
  // As heat spreads from a step: 120 / sqrt(2 pi s) at its middle, with s = 30 sweeps of variance 6 / 9 of a texel.
  EXPECT_NEAR(largest_kink(), 120.0 / std::sqrt(2.0 * 3.14159265 * 30.0 * 6.0 / 9.0), 3.0);
}

// The search tears a source without lines into pieces of a few texels; cut along the best borders they are larger.
TEST(Refinement, OfASourceWithoutStructureMakesPiecesLarger) {
  const auto history =
      std::make_shared<const MemoryHistory>(testing_support::half_images(128, 128, 2, testing_support::blotches));
  const auto map = std::make_shared<const TexelMap>(testing_support::unit_plane(128.0), 128, 128);
  ImageF asked(128, 128);
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) asked.at(x, y) = static_cast<float>(x + y) / 254.0f;
  }
  const TransferInput input{.history = history,
                            .map = map,
                            .controls = {{"x", "diagonal", asked, {0.0, 1.0, ""}, 1.0, ControlMapping::Rank}}};
  const TransferResult good = transfer(input, {}), best = transfer(input, {.quality = TransferQuality::Best});
  ASSERT_FALSE(best.structure);
  EXPECT_GT(best.energy.coherent_share, good.energy.coherent_share) << "fewer neighbors are parted";
  // A hundredth of the range is free to cuts (ControlCost).
  EXPECT_LT(best.energy.control_error_mean, good.energy.control_error_mean + 0.01);
}

TEST(Refinement, LowersTheSumRoundByRound) {
  const BrokenLines task;
  std::int64_t last = task.seam_sum(task.places);
  const std::int64_t first = last;
  for (int rounds : {1, 2, 4, 8}) {
    const std::int64_t sum = task.seam_sum(task.refined(rounds, 0));
    // Control may win what borders lose, but within a round's windows both together fall.
    EXPECT_LT(sum, last) << rounds;
    last = sum;
  }
  EXPECT_LT(last, first / 3) << "lines are periodic: pieces that fit are there";
}

TEST(Refinement, GivesTheSamePlacesForAnyNumberOfThreads) {
  for (const Mesh& mesh : {testing_support::unit_plane(kLinesSide), testing_support::patchwork_plane(kLinesSide, 3)}) {
    const BrokenLines task(mesh);
    const CoordinateMap one = task.refined(4, 1).pixels;
    EXPECT_EQ(one, task.refined(4, 3).pixels);
    EXPECT_NE(one, task.refined(4, 1, 2).pixels) << "another seed";
  }
}

TEST(Refinement, OnlyUsesWhatCanBeCopiedAndLeavesNothingOut) {
  const BrokenLines task(testing_support::quilt_plane(kLinesSide, 3));
  const PlaceMap refined = task.refined(4, 0);
  for (TexelId t = 0; t < kLinesSide * kLinesSide; ++t) {
    const std::int32_t pixel = refined.pixels[t];
    if (!task.level.destination.map->is_covered(t)) {
      EXPECT_EQ(pixel, -1);
    } else {
      ASSERT_GE(pixel, 0);
      EXPECT_NE(task.level.source.is_usable[pixel], 0);
    }
  }
}

TEST(Refinement, NoticesAStop) {
  const BrokenLines task;
  std::stop_source source;
  source.request_stop();
  RunControl stopped;
  stopped.stop = source.get_token();
  PlaceMap places = task.places;
  EXPECT_THROW(refine_places(task.level, task.structure, task.similar, task.weights, 1, {}, places, stopped), Canceled);
}

}  // namespace
}  // namespace patinate::transfer
