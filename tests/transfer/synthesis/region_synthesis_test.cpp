#include "transfer/synthesis/region_synthesis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "patinate/history/memory_history.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "transfer/synthesis/pyramid.h"

namespace patinate::transfer {
namespace {

constexpr int kEditedSide = 128;  // Texels and pixels.

/// Two charts of which one is turned, aged from left to right; and a region across the seam that is to age otherwise.
struct EditedPlane {
  std::shared_ptr<const History> history = std::make_shared<const MemoryHistory>(
      testing_support::half_images(kEditedSide, kEditedSide, 2, testing_support::blotches));
  std::shared_ptr<const TexelMap> map =
      std::make_shared<const TexelMap>(testing_support::cut_plane(kEditedSide), kEditedSide, kEditedSide);
  TransferOptions options = {};

  [[nodiscard]] ImageF ramp(bool is_reversed) const {
    ImageF values(kEditedSide, kEditedSide);
    for (TexelId t = 0; t < map->num_texels(); ++t) {
      if (!map->is_covered(t)) continue;
      const double along = map->position_mm(t).x() / kEditedSide;
      values.data()[t] = static_cast<float>(is_reversed ? 1.0 - along : along);
    }
    return values;
  }
  [[nodiscard]] TransferInput input(bool is_reversed = false) const {
    return {.history = history,
            .map = map,
            .texel_size_mm = 1.0,
            .controls = {{"x", "ramp", ramp(is_reversed), {0.0, 1.0, ""}, 1.0, ControlMapping::Linear}}};
  }
  [[nodiscard]] std::unique_ptr<RegionSynthesis> begun(int threads = 0) const {
    RunControl control;
    control.num_threads = threads;
    const TransferResult finished = transfer(input(), options, control);
    PreparedTransfer prepared = prepare_transfer(input(), options, control);
    PlaceMap places(map->num_texels(), prepared.levels[0].source.width());
    for (const TexelId t : prepared.levels[0].destination.texels) {
      const SourcePlace p = from_full_size(finished.place(t), prepared.levels[0].source.width(),
                                           static_cast<int>(prepared.first), prepared.source_width);
      places.set(t, p.pixel, {p.beside_x, p.beside_y});
    }
    return std::make_unique<RegionSynthesis>(std::move(prepared), std::move(places), control);
  }
  /// Within 20 mm of the middle, which the seam goes through.
  [[nodiscard]] std::vector<TexelId> dab() const {
    std::vector<TexelId> texels;
    for (TexelId t = 0; t < map->num_texels(); ++t) {
      if (map->is_covered(t) && (map->position_mm(t) - Vec3(kEditedSide / 2, kEditedSide / 2, 0)).norm() < 20.0)
        texels.push_back(t);
    }
    return texels;
  }
};

constexpr std::uint16_t kWanted = kControlSteps / 10;

/// Mean distance of the copied pixels' control from what is wanted, as a share of the range.
double mean_miss(const RegionSynthesis& synthesis, std::span<const TexelId> texels) {
  const SynthesisLevel& level = synthesis.prepared().levels[0];
  double sum = 0.0;
  for (const TexelId t : texels) {
    const int has = level.source.controls.data()[synthesis.places().pixels[t]];
    sum += std::abs(has - int{level.destination.target(t)[0]});
  }
  return sum / kControlSteps / static_cast<double>(texels.size());
}

bool equal(const PlaceMap& a, const PlaceMap& b) {
  return a.pixels == b.pixels && std::equal(a.beside().begin(), a.beside().end(), b.beside().begin(), b.beside().end());
}

TEST(RegionSynthesis, FollowsWhatWasPaintedAndLeavesEverythingElse) {
  const EditedPlane task;
  for (const RegionWork work : {RegionWork::Search, RegionWork::Structure}) {
    const std::unique_ptr<RegionSynthesis> synthesis = task.begun();
    const double usual = synthesis->energy().control_error_mean;
    const PlaceMap before = synthesis->places();
    const std::vector<TexelId> dab = task.dab();
    for (const TexelId t : dab) synthesis->target(t)[0] = kWanted;
    ASSERT_GT(mean_miss(*synthesis, dab), 0.2) << "the middle of the ramp is 0.5";
    const TexelSet region = synthesis->with_reach(dab);
    synthesis->synthesize(region, work, 7);
    // A region has a rim, where pieces must also fit what stays: half of its texels lie within 6 mm of it.
    EXPECT_LT(mean_miss(*synthesis, dab), 2.0 * usual);
    std::size_t num_outside = 0;
    for (const TexelId t : synthesis->destination().texels) {
      if (region.contains(t)) continue;
      ++num_outside;
      ASSERT_EQ(synthesis->places().at(t), before.at(t)) << t;
    }
    EXPECT_GT(num_outside, synthesis->destination().texels.size() / 2);
  }
}

TEST(RegionSynthesis, OfARegionThatIsRightAlreadyChangesLittle) {
  const EditedPlane task;
  const std::unique_ptr<RegionSynthesis> synthesis = task.begun();
  const PlaceMap before = synthesis->places();
  const std::vector<TexelId> dab = task.dab();
  synthesis->synthesize(synthesis->with_reach(dab), RegionWork::Search, 7);
  const auto num_moved =
      std::count_if(dab.begin(), dab.end(), [&](TexelId t) { return !(synthesis->places().at(t) == before.at(t)); });
  // Texels that missed their control before are searched again, with the passes that the finest level has anyway.
  EXPECT_LT(static_cast<double>(num_moved), 0.5 * static_cast<double>(dab.size()));
}

TEST(RegionSynthesis, OfTheWholeSurfaceFollowsAControlAsATransferDoes) {
  const EditedPlane task;
  const std::unique_ptr<RegionSynthesis> synthesis = task.begun();
  const TransferResult wanted = transfer(task.input(true), task.options);
  for (const TexelId t : synthesis->destination().texels) synthesis->target(t)[0] = wanted.matched_controls.data()[t];
  synthesis->synthesize(synthesis->destination().texels, RegionWork::Structure, 7);
  // A hundredth of the range is free to cuts (ControlCost).
  EXPECT_NEAR(synthesis->energy().control_error_mean, wanted.energy.control_error_mean, 0.01);
}

TEST(RegionSynthesis, GivesTheSamePlacesForAnyNumberOfThreads) {
  const EditedPlane task;
  const auto made = [&](int threads) {
    RunControl control;
    control.num_threads = threads;
    std::unique_ptr<RegionSynthesis> synthesis = task.begun(threads);
    const std::vector<TexelId> dab = task.dab();
    for (const TexelId t : dab) synthesis->target(t)[0] = kWanted;
    synthesis->synthesize(synthesis->with_reach(dab), RegionWork::Search, 7, control);
    synthesis->synthesize(synthesis->with_reach(dab), RegionWork::Structure, 8, control);
    return synthesis;
  };
  const auto one = made(1);
  EXPECT_TRUE(equal(one->places(), made(2)->places()));
  EXPECT_TRUE(equal(one->places(), made(5)->places()));
}

// A piece that goes on over a whole coarse texel is the same piece there.
TEST(HalvedPlaces, OfAPieceThatGoesOnAreThoseThatWereDoubled) {
  const EditedPlane task;
  PreparedTransfer prepared = prepare_transfer(task.input(), task.options, {});
  for (SynthesisLevel& level : prepared.levels) find_neighbors(level.destination, prepared.neighborhood);
  const SynthesisLevel &fine = prepared.levels[0], &coarse = prepared.levels[1];
  const PlaceMap begun = initial_places(coarse, 3);
  const PlaceMap doubled = upsample(begun, coarse, fine, 3);
  PlaceMap halved = initial_places(coarse, 4);
  downsample_texels(doubled, fine, coarse, coarse.destination.texels, halved);
  std::size_t num_same = 0;
  for (const TexelId t : coarse.destination.texels) num_same += halved.at(t) == begun.at(t) ? 1 : 0;
  // Those whose first child would lie in the border of the finest level, where nothing is usable, begin anew: 4 of 64
  // pixels on each side.
  EXPECT_GT(static_cast<double>(num_same), 0.75 * static_cast<double>(coarse.destination.texels.size()));
}

}  // namespace
}  // namespace patinate::transfer
