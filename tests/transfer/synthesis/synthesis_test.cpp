#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "libcommon/core/random.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/transfer/transfer.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"

namespace patinate::transfer {
namespace {

using testing_support::TempFolder;

/// A plane of `size` texels with controls "x" and "y" that are source pixel coordinates, moved by `shift` pixels.
struct PlaneTask {
  TempFolder folder;
  std::shared_ptr<const HistoryReader> history;
  std::shared_ptr<const TexelMap> map;
  std::vector<TransferControl> controls;

  PlaneTask(int source_size, int size, int shift,
            const std::function<float(int, int, int, int)>& color = testing_support::blotches) {
    testing_support::write_history(folder.path(), source_size, source_size, 4, color);
    history = std::make_shared<const HistoryReader>(folder.path());
    map = std::make_shared<TexelMap>(testing_support::unit_plane(size), size, size);
    ImageF xs(size, size), ys(size, size);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        xs.at(x, y) = static_cast<float>(x + shift) / static_cast<float>(source_size - 1);
        ys.at(x, y) = static_cast<float>(y + shift) / static_cast<float>(source_size - 1);
      }
    }
    const ControlRange range{0.0, source_size - 1.0, "px"};
    controls.push_back({"x", "x", xs, range, 1.0, ControlMapping::Physical});
    controls.push_back({"y", "y", ys, range, 1.0, ControlMapping::Physical});
  }
  [[nodiscard]] TransferResult run(const TransferOptions& options, int threads = 0) const {
    RunControl control;
    control.num_threads = threads;
    return transfer({.history = history, .map = map, .texel_size_mm = 1.0, .controls = controls}, options, control);
  }
  /// Only "x", matched by rank: a guide that leaves the texture free.
  [[nodiscard]] TransferResult run_guided(const TransferOptions& options, int threads = 0) const {
    RunControl control;
    control.num_threads = threads;
    TransferControl guide = controls[0];
    guide.mapping = ControlMapping::Rank;
    return transfer({.history = history, .map = map, .texel_size_mm = 1.0, .controls = {guide}}, options, control);
  }
};

constexpr int kShift = 8;

TEST(ReferenceSynthesis, SameControlsGiveTheIdentityWithZeroEnergy) {
  const PlaneTask task(48, 32, kShift);
  const TransferResult result = task.run({.method = TransferMethod::Reference});
  EXPECT_EQ(result.energy.energy, 0.0);
  EXPECT_EQ(result.energy.coherent_share, 1.0);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      ASSERT_EQ(result.coordinates[y * 32 + x], (y + kShift) * 48 + x + kShift);
    }
  }
}

// The shift is a whole number of pixels of the coarsest of the three levels, 4 x 4. (Under any other shift whole pieces
// may come out up to half such a pixel off, coherent in themselves.) A few pieces still do: a quarter of that pixel, on
// average, is the tolerance.
TEST(MultiLevelSynthesis, AShiftOfTheGuideGivesTheSameShift) {
  const PlaneTask task(96, 64, kShift);
  TransferOptions options;
  options.coherence_share = 0.5;
  const TransferResult result = task.run(options);
  double sum_of_distances = 0.0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const std::int32_t s = result.coordinates[y * 64 + x];
      sum_of_distances += std::hypot(s % 96 - (x + kShift), s / 96 - (y + kShift));
    }
  }
  EXPECT_LT(sum_of_distances / (64.0 * 64.0), 1.0);
}

TEST(MultiLevelSynthesis, FreeRunningEnergyIsAtMostOnePointTwoTimesTheReferences) {
  const PlaneTask task(96, 96, 0);
  const TransferResult reference = task.run_guided({.method = TransferMethod::Reference});
  const TransferResult fast = task.run_guided({.method = TransferMethod::Fast});
  RecordProperty("energy_ratio", std::to_string(fast.energy.energy / reference.energy.energy));
  EXPECT_LE(fast.energy.energy, 1.2 * reference.energy.energy);
}

// The guide asks for columns only, so that nothing speaks for one row of the source or another. A piece that begins
// near the border ends there, which leaves the outer rows a little less than their share.
TEST(MultiLevelSynthesis, TheSourceIsUsedUpToItsBorder) {
  const PlaneTask task(96, 96, 0);
  const CoordinateMap coordinates = task.run_guided({.method = TransferMethod::Fast}).coordinates;
  constexpr int kOuter = 12;
  const auto num_outer = std::count_if(coordinates.begin(), coordinates.end(),
                                       [](std::int32_t s) { return s / 96 < kOuter || s / 96 >= 96 - kOuter; });
  EXPECT_GE(static_cast<double>(num_outer) / (96.0 * 96.0), 0.5 * (2.0 * kOuter / 96.0));
}

TEST(SourceLevel, ACoarseOneSeesTheHistoryMirroredAtItsBorder) {
  AppearanceImage appearance(8, 6, kAppearanceSize);
  ControlImage controls(8, 6, 1);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x)
      appearance.at(x, y, 0) = static_cast<std::int16_t>(10 * y + x),
                          controls.at(x, y) = static_cast<std::uint16_t>(10 * y + x);
  }
  ImageU8 mask(8, 6, 1, 255);
  mask.at(4, 2) = 0;  // Its nearest is (3, 2); behind that lies (2, 2).
  const SourceLevel level = make_coarse_source_level(appearance, controls, mask, 100.0, Neighborhood::square(2));
  EXPECT_EQ(level.margin_px, 2);
  EXPECT_EQ(level.width(), 12);
  EXPECT_EQ(level.height(), 10);
  EXPECT_EQ(level.usable.size(), 8u * 6u - 1u);
  const auto at = [&](int x, int y) { return level.appearance.at(x + 2, y + 2, 0); };
  EXPECT_EQ(at(0, 0), 0);
  EXPECT_EQ(at(-2, 3), 32);
  EXPECT_EQ(at(9, 1), 15);
  EXPECT_EQ(at(5, -1), 15);
  EXPECT_EQ(at(-1, -2), 21);
  EXPECT_EQ(at(8, 7), 36);
  EXPECT_TRUE(at(4, 2) == 22 || at(4, 2) == 26 || at(4, 2) == 4 || at(4, 2) == 44);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x) {
      const auto pixel = static_cast<std::size_t>((y + 2) * 12 + x + 2);
      EXPECT_EQ(level.is_usable[pixel] != 0, mask.at(x, y) != 0);
      EXPECT_EQ(level.controls.data()[pixel], 10 * y + x);
    }
  }
}

TEST(Synthesis, GivesTheSameCoordinatesForAnyNumberOfThreads) {
  const PlaneTask task(64, 80, 0);
  const CoordinateMap one = task.run_guided({}, 1).coordinates;
  EXPECT_EQ(one, task.run_guided({}, 2).coordinates);
  EXPECT_EQ(one, task.run_guided({}, 5).coordinates);
}

TEST(Synthesis, TheQuartersOfTheControlErrorHaveItsMean) {
  const EnergyReport energy = PlaneTask(64, 80, 0).run_guided({}, 1).energy;
  double sum = 0.0;
  for (double quarter : energy.control_error_quarters) {
    EXPECT_GT(quarter, 0.0);
    sum += quarter;
  }
  EXPECT_NEAR(sum / 4.0, energy.control_error_mean, 1e-9);
}

TEST(Synthesis, ReportsFractionsThatNeverFallAndEndAtOne) {
  const PlaneTask task(64, 48, 0);
  for (TransferMethod method : {TransferMethod::Fast, TransferMethod::Reference}) {
    std::vector<double> fractions;
    RunControl control;
    control.on_progress = [&](double f) { fractions.push_back(f); };
    TransferOptions options;
    options.method = method;
    (void)transfer({.history = task.history, .map = task.map, .texel_size_mm = 1.0, .controls = task.controls}, options,
                   control);
    ASSERT_FALSE(fractions.empty());
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    EXPECT_EQ(fractions.back(), 1.0);
  }
}

TEST(Synthesis, StopsWhenAsked) {
  const PlaneTask task(64, 48, 0);
  std::stop_source source;
  RunControl control;
  control.stop = source.get_token();
  control.on_progress = [&](double f) {
    if (f > 0.4) source.request_stop();
  };
  EXPECT_THROW(
      (void)transfer({.history = task.history, .map = task.map, .texel_size_mm = 1.0, .controls = task.controls}, {},
                     control),
      Canceled);
}

TEST(Synthesis, ASeedChoosesTheResult) {
  const PlaneTask task(64, 48, 0);
  TransferOptions other;
  other.seed = 2;
  EXPECT_EQ(task.run_guided({}).coordinates, task.run_guided({}).coordinates);
  EXPECT_NE(task.run_guided({}).coordinates, task.run_guided(other).coordinates);
}

TEST(Synthesis, AConstantSourceHasNoCoherenceCost) {
  const PlaneTask task(40, 40, 0, [](int, int, int frame, int) { return 0.1f * static_cast<float>(frame + 1); });
  const TransferResult result = task.run_guided({});
  EXPECT_EQ(result.energy.coherence, 0.0);
}

TEST(Synthesis, OnlyUsesPixelsWhoseNeighborhoodLiesInTheMask) {
  TempFolder folder;
  testing_support::write_history(folder.path(), 64, 64, 2, testing_support::blotches);
  HistoryManifest manifest = HistoryReader(folder.path()).manifest();
  HistoryWriter writer(folder.path(), manifest);
  ImageU8 mask(64, 64);
  for (int y = 8; y < 40; ++y) {
    for (int x = 16; x < 60; ++x) mask.at(x, y) = 255;
  }
  writer.write_mask(mask);
  writer.finish();
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const auto map = std::make_shared<TexelMap>(testing_support::unit_plane(48), 48, 48);
  ImageF guide(48, 48);
  for (int i = 0; i < 48 * 48; ++i) guide.data()[i] = static_cast<float>(i % 48) / 47.0f;
  const TransferResult result = transfer({.history = history,
                                          .map = map,
                                          .texel_size_mm = 1.0,
                                          .controls = {{"x", "image", guide, {}, 1.0, ControlMapping::Rank}}});
  for (std::int32_t s : result.coordinates) {
    // The mask [16, 60) x [8, 40) less the neighborhood's radius.
    const int radius_px = result.used.neighborhood_radius_px;
    EXPECT_GE(s % 64, 16 + radius_px);
    EXPECT_LT(s % 64, 60 - radius_px);
    EXPECT_GE(s / 64, 8 + radius_px);
    EXPECT_LT(s / 64, 40 - radius_px);
  }
}

// The integer cost against the formula of energy.h in doubles.
TEST(TexelCost, EqualsTheFormula) {
  const PlaneTask task(32, 24, 0);
  const Neighborhood neighborhood = Neighborhood::square(2);
  AppearanceSpace space = build_appearance_space(*task.history, 1);
  ControlImage source_control(32, 32, 1), target(24, 24, 1);
  RandomStream random(4, 4);
  for (auto& v : source_control.values()) v = static_cast<std::uint16_t>(random.below(kControlSteps + 1));
  for (auto& v : target.values()) v = static_cast<std::uint16_t>(random.below(kControlSteps + 1));
  const SourceLevel source =
      make_source_level(space.levels[0], source_control, space.masks[0], space.variances[0], neighborhood);
  const DestinationLevel destination = make_destination_level(
      task.map, target, neighborhood,
      {.frames = std::make_shared<const FlowFrames>(uv_frames(*task.map)), .pixel_mm = 1.0, .step_mm = 1.0});
  CoordinateMap coordinates(24 * 24);
  const auto random_pixel = [&] {
    return source.usable[random.below(static_cast<std::uint32_t>(source.usable.size()))];
  };
  for (auto& s : coordinates) s = random.below(5) == 0 ? -1 : random_pixel();

  constexpr double kShare = 0.6;
  const std::vector<double> weights{1.0};
  TexelCost cost(source, destination, neighborhood);
  for (TexelId t : {TexelId{0}, TexelId{5 * 24 + 7}, TexelId{23 * 24 + 23}, TexelId{12 * 24}}) {
    cost.prepare(t, coordinates, EnergyScale::make(source, kShare, weights));
    const std::int32_t s = random_pixel();
    double coherence = 0.0, sum_of_weights = 0.0;
    for (std::size_t k = 0; k < neighborhood.offsets.size(); ++k) {
      const int x = static_cast<int>(t % 24) + neighborhood.offsets[k].x,
                y = static_cast<int>(t / 24) + neighborhood.offsets[k].y;
      if (x < 0 || y < 0 || x >= 24 || y >= 24 || coordinates[y * 24 + x] < 0) continue;
      const std::int32_t n = coordinates[y * 24 + x];
      const std::int32_t moved = s + neighborhood.offsets[k].y * 32 + neighborhood.offsets[k].x;
      for (int d = 0; d < kAppearanceSize; ++d) {
        const double difference =
            source.appearance.data()[n * kAppearanceSize + d] - source.appearance.data()[moved * kAppearanceSize + d];
        coherence += neighborhood.weights[k] * difference * difference;
      }
      sum_of_weights += neighborhood.weights[k];
    }
    coherence /= sum_of_weights * 2.0 * source.appearance_variance;
    const double difference = source_control.data()[s] - target.data()[t];
    const double mismatch = difference * difference / (2.0 * source.control_variances[0]);
    const double expected = kShare * coherence + (1.0 - kShare) * mismatch;
    // Rounding of the two integer scales: below 1e-4 of the value.
    EXPECT_NEAR(static_cast<double>(cost.total(s, std::numeric_limits<std::int64_t>::max())) / EnergyScale::kOne,
                expected, 1e-4 * expected + 1e-9);
  }
}

// Where a texel is 1.25 pixels wide, a copy of the source is a copy only if places keep their fractions: rounded apart,
// both ends of a step lie a pixel beside each other at every fourth texel, and whatever has edges seems to cost.
TEST(TexelCost, OfAPieceThatGoesOnIsNothingWhereTexelsAreNoPixels) {
  const PlaneTask task(32, 24, 0);
  const Neighborhood neighborhood = Neighborhood::square(2);
  const AppearanceSpace space = build_appearance_space(*task.history, 1);
  const SourceLevel source =
      make_source_level(space.levels[0], ControlImage(32, 32, 1), space.masks[0], space.variances[0], neighborhood);
  const DestinationLevel destination = make_destination_level(
      task.map, ControlImage(24, 24, 1), neighborhood,
      {.frames = std::make_shared<const FlowFrames>(uv_frames(*task.map)), .pixel_mm = 0.8, .step_mm = 0.8});
  PlaceMap places(24 * 24, 32);
  for (TexelId t = 0; t < 24 * 24; ++t) {
    const FixedPoint point{static_cast<std::int32_t>(320 * (t % 24)), static_cast<std::int32_t>(320 * (t / 24))};
    places.set(t, Place{whole_pixels(point.y) * 32 + whole_pixels(point.x), point});
  }
  constexpr std::int64_t kNoBound = std::numeric_limits<std::int64_t>::max();
  TexelCost cost(source, destination, neighborhood);
  int num_apart = 0;
  for (int y = 6; y < 18; ++y) {
    for (int x = 6; x < 18; ++x) {
      const TexelId t = TexelId{y} * 24 + x;
      cost.prepare(t, places.pixels, EnergyScale::make(source, 1.0, std::vector<double>{1.0}));
      const Place place = places.at(t);
      const PlaceMap::Beside beside = PlaceMap::beside_of(place);
      EXPECT_EQ(cost.total_beside(place.pixel, beside.x, beside.y, kNoBound), 0) << x << "," << y;
      num_apart += cost.total(place.pixel, kNoBound) > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(num_apart, 0);
}

// One pixel at 1, all others at 0: the least variance that a control can have.
TEST(TexelCost, StaysInRangeForASpikeInAControl) {
  const PlaneTask task(32, 24, 0);
  const Neighborhood neighborhood = Neighborhood::square(2);
  const AppearanceSpace space = build_appearance_space(*task.history, 1);
  ControlImage spike(32, 32, 1), target(24, 24, 1);
  spike.at(16, 16) = kControlSteps;
  const SourceLevel source =
      make_source_level(space.levels[0], spike, space.masks[0], space.variances[0], neighborhood);
  const DestinationLevel destination = make_destination_level(
      task.map, target, neighborhood,
      {.frames = std::make_shared<const FlowFrames>(uv_frames(*task.map)), .pixel_mm = 1.0, .step_mm = 1.0});
  CoordinateMap coordinates(24 * 24, source.usable.front());
  TexelCost cost(source, destination, neighborhood);
  cost.prepare(0, coordinates, EnergyScale::make(source, 0.0, std::vector<double>{1.0}));
  // multi_level.cpp multiplies by at most 1168.
  EXPECT_LT(static_cast<double>(cost.control(16 * 32 + 16)) * 1168.0, 0x1p63);
  EXPECT_GT(cost.control(16 * 32 + 16), 0);
}

TEST(Synthesis, TexelsMuchLargerThanPixelsStillGetATexture) {
  const PlaneTask task(64, 48, 0);
  const TransferResult result =
      transfer({.history = task.history, .map = task.map, .texel_size_mm = 0.001, .controls = {task.controls[0]}});
  for (std::int32_t s : result.coordinates) ASSERT_GE(s, 0);
}

TEST(AppearanceSpace, KeepsAllOfAHistoryOfTwoFrames) {
  TempFolder folder;
  testing_support::write_history(folder.path(), 32, 32, 2,
                                 testing_support::blotches);  // 6 numbers per pixel, 8 components.
  const AppearanceSpace space = build_appearance_space(HistoryReader(folder.path()), 2, {.spatial_radius_px = 0});
  EXPECT_NEAR(space.explained_variance, 1.0, 1e-9);
  EXPECT_EQ(space.levels[1].width(), 16);
}

}  // namespace
}  // namespace patinate::transfer
