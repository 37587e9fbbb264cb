#include "patinate/transfer/transfer_reader.h"

#include <gtest/gtest.h>

#include <fstream>

#include "libcommon/core/files.h"
#include "libcommon/history/footprint.h"
#include "patinate/image/image_io.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/job/transfer_job.h"

namespace patinate::transfer {
namespace {

using testing_support::TempFolder;

class FinishedTransfer : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_ / "history");
    testing_support::write_history(folder_ / "history", 48, 40, 3, testing_support::blotches);
    task_.history = std::make_shared<const HistoryReader>(folder_ / "history");
    task_.input.map = std::make_shared<TexelMap>(testing_support::cut_plane(64.0), 64, 64);
    task_.mesh_name = "plane.obj";
    task_.input.texel_size_mm = task_.input.map->median_texel_size_mm();
    ImageF guide(64, 64);
    for (int i = 0; i < 64 * 64; ++i) guide.data()[i] = static_cast<float>(i % 64) / 63.0f;
    task_.input.controls.push_back({"x", "image", guide, {}, 1.0, ControlMapping::Rank});
    EXPECT_EQ(run_job(plan_transfer(task_, folder_ / "transfer"), {}, {}), JobStatus::Done);
    EXPECT_EQ(run_job(plan_transfer(task_, folder_ / "transfer"), {}, {}), JobStatus::UpToDate);
  }
  TempFolder folder_;
  TransferTask task_;
};

TEST_F(FinishedTransfer, FramesAreExactlyThoseOfTheHistoryAtItsCoordinates) {
  const TransferReader transfer(folder_ / "transfer");
  const ImageF& s = transfer.coordinates();
  for (int f = 0; f < 3; ++f) {
    const ImageF texture = transfer.sample(f), expected = gather(transfer.history().read_frame(f), s);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        if (s.at(x, y, 0) < 0.0f) continue;
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(texture.at(x, y, c), expected.at(x, y, c));
        }
      }
    }
  }
}

TEST_F(FinishedTransfer, ATexelOfSeveralPixelsShowsTheirMean) {
  task_.input.texel_size_mm = task_.input.map->median_texel_size_mm() / 2.5;
  for (const Footprint footprint : {Footprint::Mean, Footprint::Pixel}) {
    task_.options.footprint = footprint;
    const auto folder = folder_ / kFootprintNames[static_cast<std::size_t>(footprint)];
    EXPECT_EQ(run_job(plan_transfer(task_, folder), {}, {}), JobStatus::Done);
    const TransferReader transfer(folder);
    const double side = footprint == Footprint::Mean ? 2.5 : 1.0;
    EXPECT_EQ(transfer.manifest().footprint_px, side);
    const ImageF seen = mean_over_footprint(HistoryReader(folder_ / "history").read_frame(2), {}, side);
    const ImageF& s = transfer.coordinates();
    const ImageF texture = transfer.sample(2.0), expected = gather(seen, s);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        if (s.at(x, y, 0) < 0.0f) continue;
        ASSERT_EQ(texture.at(x, y, 1), expected.at(x, y, 1));
      }
    }
  }
}

TEST_F(FinishedTransfer, BetweenFramesIsTheirBlend) {
  const TransferReader transfer(folder_ / "transfer");
  const ImageF a = transfer.sample(1.0), b = transfer.sample(2.0), between = transfer.sample(1.25);
  const auto coverage = transfer.coverage();
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      if (coverage.at(x, y)) {
        EXPECT_NEAR(between.at(x, y, 1), 0.75f * a.at(x, y, 1) + 0.25f * b.at(x, y, 1), 1e-6f);
      }
    }
  }
}

TEST_F(FinishedTransfer, AHistoryThatHasChangedIsNoticed) {
  const auto manifest = folder_ / "history/history.json";
  std::string text = read_file(manifest);
  text.replace(text.find("0123456789abcdef"), 16, "fedcba9876543210");
  write_atomically(manifest, text);
  EXPECT_THROW(TransferReader(folder_ / "transfer"), IoError);
}

TEST_F(FinishedTransfer, AnUnknownKeyIsAnError) {
  const auto manifest = folder_ / "transfer/transfer.json";
  std::string text = read_file(manifest);
  text.replace(text.find("\"seed\""), 6, "\"sead\"");
  write_atomically(manifest, text);
  EXPECT_THROW(TransferReader(folder_ / "transfer"), IoError);
}

TEST(HistoryContentKey, OfAHistoryWithoutKeyFollowsItsMask) {
  TempFolder folder;
  testing_support::write_history(folder.path(), 16, 16, 2, testing_support::blotches);
  HistoryManifest manifest = HistoryReader(folder.path()).manifest();
  manifest.key.clear();
  HistoryWriter writer(folder.path(), manifest);
  writer.write_mask(ImageU8(16, 16, 1, 255));
  writer.finish();
  const std::string before = history_content_key(HistoryReader(folder.path()));
  ImageU8 other(16, 16, 1, 255);
  other.at(3, 3) = 0;
  write_codes(folder / *writer.manifest().mask, other);
  EXPECT_NE(before, history_content_key(HistoryReader(folder.path())));
}

TEST_F(FinishedTransfer, ADamagedFolderIsOneLine) {
  const std::string good = read_file(folder_ / "transfer/transfer.json");
  for (std::size_t length = 0; length + 2 < good.size(); length += good.size() / 23 + 1) {
    write_atomically(folder_ / "transfer/transfer.json", std::string_view(good).substr(0, length));
    EXPECT_THROW(TransferReader(folder_ / "transfer"), IoError) << length;
  }
  write_atomically(folder_ / "transfer/transfer.json", good);
  const std::string exr = read_file(folder_ / "transfer/coordinates.exr");
  write_atomically(folder_ / "transfer/coordinates.exr", std::string_view(exr).substr(0, exr.size() / 2));
  EXPECT_THROW(TransferReader(folder_ / "transfer"), IoError);
}

}  // namespace
}  // namespace patinate::transfer
