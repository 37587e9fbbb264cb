#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "libcommon/core/random.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/job/transfer_job.h"
#include "transfer/library/library_job.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::transfer {
namespace {

namespace fs = std::filesystem;
using testing_support::TempFolder;

/// Grains of another color, size and course than testing_support::blotches.
float grains(int x, int y, int frame, int channel) {
  RandomStream random(7, static_cast<std::uint64_t>(y / 3) * 4096 + static_cast<std::uint64_t>(x / 3), 1);
  const float grain = static_cast<float>(random.uniform()), age = static_cast<float>(frame) / 3.0f;
  return 0.2f + 0.4f * grain * (channel == 2 ? 1.0f : 1.0f - age);
}

ControlMap map_of(const ImageF& values, double low = 0.0, double high = 1.0, const std::string& unit = "relative") {
  return {values, low, high, unit, {}};
}

/// A library of a history of 64 x 48 and one of 48 x 56, and a plane of kSize texels.
class LibraryTransfer : public testing::Test {
 protected:
  static constexpr int kSize = 80;

  void SetUp() override {
    testing_support::write_history(folder_ / "rust", 64, 48, 4, testing_support::blotches);
    testing_support::write_history(folder_ / "sand", 48, 56, 4, grains);
    (void)run_job(plan_library(open_library({{folder_ / "rust", folder_ / "sand"}}), folder_ / "library"), {}, {});
    library_ = std::make_shared<const HistoryReader>(folder_ / "library");
    parts_ = library_->facts().parts;
    map_ = std::make_shared<TexelMap>(testing_support::unit_plane(kSize), kSize, kSize);
    which_ = ImageF(kSize, kSize);
    ramp_ = ImageF(kSize, kSize);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        which_.at(x, y) = x < kSize / 2 ? 0.0f : 1.0f;
        ramp_.at(x, y) = static_cast<float>(y) / (kSize - 1.0f);
      }
    }
  }
  [[nodiscard]] TransferControl pair(const std::string& spec, ControlMap made) const {
    return make_transfer_control(*library_, parse_control_spec(spec), std::move(made), {});
  }
  /// Index of the history that a texel's source belongs to.
  [[nodiscard]] int source_of(const CoordinateMap& coordinates, int x, int y) const {
    return coordinates[y * kSize + x] % library_->manifest().width >= parts_[1].x ? 1 : 0;
  }
  TempFolder folder_;
  std::shared_ptr<const HistoryReader> library_;
  std::vector<LibraryPart> parts_;
  std::shared_ptr<const TexelMap> map_;
  ImageF which_, ramp_;
};

TEST_F(LibraryTransfer, TexelsAwayFromTheBorderTakeTheHistoryThatTheMaskSays) {
  for (TransferMethod method : {TransferMethod::Fast, TransferMethod::Reference}) {
    const TransferResult result =
        transfer({.history = library_,
                  .map = map_,
                  .texel_size_mm = 1.0,
                  .controls = {pair("y=ramp", map_of(ramp_)), pair("history=which", map_of(which_))}},
                 {.method = method, .reference = {.num_passes = 2}});
    constexpr int kBorder = 6;  // Texels on either side, about the radius of two neighborhoods.
    int num_right = 0, num_away = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        if (x >= kSize / 2 - kBorder && x < kSize / 2 + kBorder) continue;
        ++num_away;
        num_right += source_of(result.coordinates, x, y) == (x < kSize / 2 ? 0 : 1);
      }
    }
    EXPECT_GE(num_right, 0.99 * num_away) << kTransferMethodNames[static_cast<std::size_t>(method)];
  }
}

TEST_F(LibraryTransfer, RanksAreThoseOfTheHistoryThatApplies) {
  const std::vector<TransferControl> controls{pair("y=ramp", map_of(ramp_)), pair("history=which", map_of(which_))};
  const ImageU8 mask = library_->read_mask();
  const MatchedControls matched = match_controls(*library_, mask, controls, map_->coverage());
  // Within each half the ramp is uniform, and so is each history's y: 0 to 47 and 0 to 55 px, of a range of 55. Half a
  // row is the step of both.
  for (int y = 0; y < kSize; ++y) {
    const double share = (y + 0.5) / kSize;
    EXPECT_NEAR(55.0 * static_cast<double>(matched.destination[0].at(3, y)), 48.0 * share - 0.5, 0.6) << y;
    EXPECT_NEAR(55.0 * static_cast<double>(matched.destination[0].at(kSize - 3, y)), 56.0 * share - 0.5, 0.6) << y;
  }
  EXPECT_EQ(matched.destination[1].at(3, 3), 0.0f);
  EXPECT_EQ(matched.destination[1].at(kSize - 3, 3), 1.0f);
}

TEST_F(LibraryTransfer, MapsOfTheHistoryAreIndicesOrGrays) {
  std::vector<LibraryPart> three = parts_;
  three.push_back({.name = "third", .x = library_->manifest().width - 1, .width = 1, .height = 1, .key = ""});
  three[1].width -= 1;
  HistoryManifest manifest = library_->manifest();
  manifest.parts = three;
  write_history_manifest(folder_ / "library/history.json", manifest);
  const HistoryReader history(folder_ / "library");
  const auto made = [&](const std::string& spec, const ControlMap& map) {
    return make_transfer_control(history, parse_control_spec(spec), map, {});
  };
  const TransferControl gray = made("history=gray.png", map_of(which_)),
                        indices = made("history=index.exr", map_of(which_, 0.0, 2.0)),
                        height = made("history=height", map_of(which_, 3.0, 9.0, "mm"));
  EXPECT_EQ(gray.mapping, ControlMapping::Physical);
  EXPECT_EQ(gray.range.high, 2.0);
  EXPECT_EQ(indices.range.high, 2.0);
  EXPECT_EQ(height.range.low, 0.0);
  EXPECT_EQ(height.range.high, 2.0);
  EXPECT_EQ(made("history=index.exr", map_of(which_, 0.0, 1.5)).range.high, 1.5);
  EXPECT_EQ(made("history=gray.png:1:rank", map_of(which_)).mapping, ControlMapping::Rank);
  ControlMap painted = map_of(which_);
  EXPECT_EQ(made("x=facing", painted).mapping, ControlMapping::Rank) << "computed from the shape";
  painted.has_file = true;
  EXPECT_EQ(made("x=gray.png", painted).mapping, ControlMapping::Linear) << "two values, as any painted mask";
  EXPECT_EQ(made("x=ramp.png", map_of(ramp_)).mapping, ControlMapping::Rank);
}

TEST_F(LibraryTransfer, AHistoryThatIsAskedForAndMaskedOutIsNamed) {
  ImageU8 first_only(library_->manifest().width, library_->manifest().height, 1, 0);
  for (int y = 0; y < first_only.height(); ++y) std::fill_n(first_only.row(y).begin(), 64, std::uint8_t{255});
  const std::string message = testing_support::error_of([&] {
    (void)transfer({.history = library_,
                    .map = map_,
                    .texel_size_mm = 1.0,
                    .controls = {pair("history=which", map_of(which_))},
                    .source_mask = first_only});
  });
  EXPECT_TRUE(testing_support::has(message, "no pixel of its history 1 (test) is inside the mask")) << message;
}

TEST_F(LibraryTransfer, AHistoryNarrowerThanTheNeighborhoodIsNamed) {
  ImageU8 mask(library_->manifest().width, library_->manifest().height, 1, 255);
  for (int y = 0; y < mask.height(); ++y)
    std::fill(mask.row(y).begin() + parts_[1].x + 6, mask.row(y).end(), std::uint8_t{0});
  const std::string message = testing_support::error_of([&] {
    (void)transfer({.history = library_,
                    .map = map_,
                    .texel_size_mm = 1.0,
                    .controls = {pair("history=which", map_of(which_))},
                    .source_mask = mask});
  });
  EXPECT_TRUE(testing_support::has(message, "history 1 (test) has its whole neighborhood of 7 pixels")) << message;
}

class SourceMask : public LibraryTransfer {};

TEST_F(SourceMask, NothingIsCopiedFromWhereItIsZero) {
  const auto history = std::make_shared<const HistoryReader>(folder_ / "rust");
  ImageU8 right(64, 48, 1, 0);
  for (int y = 0; y < 48; ++y) std::fill_n(right.row(y).begin() + 30, 34, std::uint8_t{255});
  for (TransferMethod method : {TransferMethod::Fast, TransferMethod::Reference}) {
    const TransferControl guide{"y", "ramp", ramp_, {}, 1.0, ControlMapping::Rank};
    const TransferResult result =
        transfer({.history = history, .map = map_, .texel_size_mm = 1.0, .controls = {guide}, .source_mask = right},
                 {.method = method, .reference = {.num_passes = 1}});
    for (std::int32_t s : result.coordinates) ASSERT_GE(s % 64, 30 + 3);  // Its whole neighborhood lies in the mask.
  }
}

TEST_F(SourceMask, OfAnotherSizeOrThatLeavesNothingIsSaid) {
  const HistoryReader history(folder_ / "rust");
  EXPECT_TRUE(
      testing_support::has(testing_support::error_of([&] { (void)usable_mask(history, ImageU8(20, 48, 1, 255)); }),
                           "is 20 x 48 pixels; the history"));
  EXPECT_TRUE(testing_support::has(testing_support::error_of([&] { (void)usable_mask(history, ImageU8(64, 48)); }),
                                   "leaves no pixel"));
}

TEST_F(SourceMask, IsKeptWithTheTransferAndPartOfItsKey) {
  TransferTask task;
  task.history = library_;
  task.input.map = map_;
  task.mesh_name = "plane.obj";
  task.input.controls = {pair("y=ramp", map_of(ramp_)), pair("history=which", map_of(which_))};
  const std::string key = plan_transfer(task, folder_ / "aged").key;
  task.input.source_mask = ImageU8(library_->manifest().width, library_->manifest().height, 1, 255);
  task.input.source_mask.at(5, 5) = 0;
  task.source_mask_name = "mask.png";
  const JobPlan plan = plan_transfer(task, folder_ / "aged");
  EXPECT_NE(plan.key, key);
  EXPECT_EQ(run_job(plan, {}, {}), JobStatus::Done);

  const TransferReader transfer(folder_ / "aged");
  EXPECT_EQ(transfer.source_mask().at(5, 5), 0);
  EXPECT_EQ(transfer.source_mask().at(6, 5), 255);
  // What a reader matches is what was searched with.
  const MatchedControls matched =
      match_controls(*library_, usable_mask(*library_, task.input.source_mask), task.input.controls, map_->coverage());
  EXPECT_EQ(transfer.matched_control(0), matched.destination[0]);
  EXPECT_EQ(transfer.matched_control(1), matched.destination[1]);
  // source.index names the history whose columns source.x lies in.
  const ImageF index = read_channels(folder_ / "aged/coordinates.exr", {"source.x", kIndexChannel});
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x)
      ASSERT_EQ(index.at(x, y, 1), index.at(x, y, 0) >= static_cast<float>(parts_[1].x) ? 1.0f : 0.0f);
  }
}

TEST(MatchControlByLabel, OneLabelIsMatchControl) {
  ImageF a(20, 20), b(30, 30);
  for (std::size_t i = 0; i < a.values().size(); ++i) a.values()[i] = static_cast<float>(i % 37) / 36.0f;
  for (std::size_t i = 0; i < b.values().size(); ++i)
    b.values()[i] = static_cast<float>(i % 101 * (i % 101)) / 10000.0f;
  const ImageU8 of_a(20, 20, 1, 5), of_b(30, 30, 1, 5);
  for (ControlMapping mapping : {ControlMapping::Rank, ControlMapping::Linear}) {
    EXPECT_EQ(match_control_by_label(a, of_a, {}, b, of_b, {}, mapping), match_control(a, {}, {}, b, {}, {}, mapping));
  }
  EXPECT_THROW((void)match_control_by_label(a, of_a, {}, b, ImageU8(30, 30, 1, 4), {}, ControlMapping::Rank),
               InvalidInput);
}

}  // namespace
}  // namespace patinate::transfer
