#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/job/transfer_job.h"

namespace patinate::transfer {
namespace {

using testing_support::TempFolder;
using testing_support::udim_plane;

constexpr int kTile = 32;

/// A square cut into three UDIM tiles, aged with a history of 64 x 48 pixels by a ramp from left to right.
class TransferOverTiles : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_ / "history");
    testing_support::write_history(folder_ / "history", 64, 48, 3, testing_support::blotches);
    const Mesh mesh = udim_plane(kSide, 3);
    TransferTask task;
    task.history = std::make_shared<const HistoryReader>(folder_ / "history");
    task.atlas = std::make_shared<AtlasMesh>(atlas_mesh_of(mesh, find_uv_layout(mesh)));
    task.input.map = std::make_shared<TexelMap>(make_texel_map(*task.atlas, kTile));
    task.mesh_name = "plane.obj";
    task.input.texel_size_mm = task.input.map->median_texel_size_mm();
    ImageF guide(task.input.map->width(), task.input.map->height());
    for (TexelId t = 0; t < task.input.map->num_texels(); ++t) {
      if (task.input.map->is_covered(t))
        guide.values()[t] = static_cast<float>(task.input.map->position_mm(t).x() / kSide);
    }
    task.input.controls.push_back({"x", "ramp", guide, {}, 1.0, ControlMapping::Rank});
    map_ = task.input.map;
    ASSERT_EQ(run_job(plan_transfer(task, folder_ / "transfer"), {}, {}), JobStatus::Done);
  }
  static constexpr double kSide = 48.0;
  TempFolder folder_;
  std::shared_ptr<const TexelMap> map_;
};

TEST_F(TransferOverTiles, WritesAFileForEveryTileAndListsThem) {
  const Json json = load_json(folder_ / "transfer" / "transfer.json");
  EXPECT_FALSE(json.contains("coordinates"));
  ASSERT_EQ(json["tiles"].size(), 3u);
  for (const char* name : {"1001", "1002", "1003"}) {
    const ImageInfo info = probe_image(folder_ / "transfer" / ("coordinates." + std::string(name) + ".exr"));
    EXPECT_EQ(info.width, kTile);
    EXPECT_EQ(info.height, kTile);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "transfer" / ("control." + std::string(name) + ".exr")));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "transfer" / "coordinates.exr"));
  double greatest = 0.0;  // mesh.obj keeps the UDIM squares
  for (const Vec2& uv : read_mesh(folder_ / "transfer" / "mesh.obj").uvs) greatest = std::max(greatest, uv.x());
  EXPECT_EQ(greatest, 3.0);
}

TEST_F(TransferOverTiles, ReadsBackTheCoordinatesOfEveryTexel) {
  const TransferReader transfer(folder_ / "transfer");
  EXPECT_EQ(transfer.sheet().names, (std::vector<std::string>{"1001", "1002", "1003"}));
  EXPECT_EQ(transfer.coverage(), map_->coverage());
  const std::vector<ImageF> tiles = transfer.sample_tiles(1.0);
  const ImageF frame = transfer.history().read_frame(1);
  ASSERT_EQ(tiles.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    const ImageF source =
        read_channels(transfer.manifest().tiles[i].coordinates, {kCoordinateChannels[0], kCoordinateChannels[1]});
    EXPECT_EQ(tiles[i], gather(frame, source));
  }
}

TEST_F(TransferOverTiles, TheSheetRepeatsBordersSoThatNoTileBleedsIntoAnother) {
  const TransferReader transfer(folder_ / "transfer");
  const ImageF sheet = transfer.sample(1.0);
  const Sheet& s = transfer.sheet();
  for (int y = 0; y < kTile; ++y) {
    const int x = s.first_x(0) + kTile - 1, row = s.first_y(0) + y;
    for (int c = 0; c < 3; ++c) EXPECT_EQ(sheet.at(x + 1, row, c), sheet.at(x, row, c));
  }
}

// What makes a seam is a source that does not continue: adjacent texels across a border of tiles should be adjacent in
// the source about as often as adjacent texels inside a tile. Statistics: 64 pairs across, so one standard deviation is
// at most 1 / 16.
TEST_F(TransferOverTiles, TextureGoesOnAcrossTilesAsItDoesInsideThem) {
  const TransferReader transfer(folder_ / "transfer");
  const ImageF& source = transfer.coordinates();
  const Sheet& s = transfer.sheet();
  const auto goes_on = [&](int xa, int ya, int xb, int yb) {
    const float dx = source.at(xb, yb, 0) - source.at(xa, ya, 0), dy = source.at(xb, yb, 1) - source.at(xa, ya, 1);
    return std::abs(dx - 1.0f) <= 1.0f && std::abs(dy) <= 1.0f;
  };
  double inside = 0.0, across = 0.0;
  for (int y = 0; y < kTile; ++y) {
    for (int tile = 0; tile < 3; ++tile) {
      for (int x = 0; x + 1 < kTile; ++x)
        inside += goes_on(s.first_x(tile) + x, s.first_y(tile) + y, s.first_x(tile) + x + 1, s.first_y(tile) + y);
    }
    for (int tile = 0; tile < 2; ++tile) {
      across += goes_on(s.first_x(tile) + kTile - 1, s.first_y(tile) + y, s.first_x(tile + 1), s.first_y(tile + 1) + y);
    }
  }
  inside /= 3.0 * kTile * (kTile - 1);
  across /= 2.0 * kTile;
  EXPECT_GT(inside, 0.4);
  EXPECT_GT(across, inside - 3.0 / 16.0);
}

TEST_F(TransferOverTiles, SaysWhichTileIsMissing) {
  std::filesystem::remove(folder_ / "transfer" / "coordinates.1002.exr");
  try {
    const TransferReader transfer(folder_ / "transfer");
    FAIL();
  } catch (const IoError& e) {
    EXPECT_NE(std::string(e.what()).find("coordinates.1002.exr"), std::string::npos);
  }
}

}  // namespace
}  // namespace patinate::transfer
