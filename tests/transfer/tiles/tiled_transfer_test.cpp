#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/job/transfer_job.h"
#include "transfer/tiles/tile_files.h"
#include "transfer/tiles/tile_job.h"

namespace patinate::transfer {
namespace {

namespace fs = std::filesystem;
using testing_support::error_of;
using testing_support::has;
using testing_support::TempFolder;

/// A waved square of 8 x 8 charts, turned, mirrored and of two densities, in 4 x 4 UDIM tiles: all seams but those
/// within a tile lead from tile to tile.
Mesh waved_patchwork() {
  Mesh mesh = testing_support::patchwork_plane(60.0, 8);
  for (Vec3& p : mesh.positions) p.z() = 3.0 * std::sin(p.x() / 6.0) + 2.0 * std::cos(p.y() / 4.0);
  for (Vec2& uv : mesh.uvs) uv *= 4.0;
  return mesh;
}

struct TiledCase {
  TempFolder folder;
  TransferTask task;
  ControlKindOptions kinds;

  explicit TiledCase(int tile_px, const Mesh& mesh = waved_patchwork(),
                     std::vector<std::string> controls = {"x=0.6*facing + 0.4*height"},
                     float (*color)(int, int, int, int) = testing_support::blotches) {
    fs::create_directory(folder / "history");
    testing_support::write_history(folder / "history", 128, 96, 3, color);
    task.history = std::make_shared<const HistoryReader>(folder / "history");
    task.atlas = std::make_shared<AtlasMesh>(atlas_mesh_of(mesh, find_uv_layout(mesh)));
    task.input.map = std::make_shared<TexelMap>(make_texel_map(*task.atlas, tile_px));
    task.mesh_name = "waves.obj";
    task.input.texel_size_mm = task.input.map->median_texel_size_mm();
    task.input.frames = std::make_shared<const FlowFrames>(
        direction_frames(*task.input.map, DirectionKind::Gravity, Vec3(0.0, 1.0, 0.0)));
    task.flow = "gravity";
    kinds.up = {0.0, 0.0, 1.0};
    kinds.facing.direction = {0.3, 0.2, 1.0};
    for (const std::string& text : controls) {
      const ControlSpec spec = parse_control_spec(text);
      ControlMap made = make_control_expression(spec.destination, *task.input.map, kinds);
      task.input.controls.push_back({spec.source,
                                     spec.destination,
                                     std::move(made.values),
                                     {made.low, made.high, made.unit},
                                     spec.weight,
                                     spec.mapping.value_or(ControlMapping::Rank)});
    }
    task.options.appearance.structure = 0.0;
  }
  [[nodiscard]] TiledTask tiled() const {
    TiledTask t{task, kinds};
    t.transfer.input.map = std::make_shared<TexelMap>(task.input.map->unsearched());
    for (TransferControl& c : t.transfer.input.controls) c.values = {};
    return t;
  }
  /// Makes both, and compares all that does not name the plan.
  void expect_equal() const {
    ASSERT_EQ(run_job(plan_transfer(task, folder / "whole"), {}, {}), JobStatus::Done);
    ASSERT_EQ(run_job(plan_tiled_transfer(tiled(), folder / "tiled"), {}, {}), JobStatus::Done);
    for (const auto& entry : fs::directory_iterator(folder / "whole")) {
      const std::string name = entry.path().filename();
      if (name.ends_with(".json")) continue;
      EXPECT_EQ(read_file(entry.path()), read_file(folder / "tiled" / name)) << name;
    }
    Json whole = load_json(folder / "whole" / "transfer.json"), by_tile = load_json(folder / "tiled" / "transfer.json");
    whole.erase("key");
    by_tile.erase("key");
    EXPECT_EQ(whole, by_tile);
  }
};

TEST(TiledTransfer, GivesTheBytesOfTheTransferInOnePiece) {
  TiledCase task(64);
  task.task.options.multi_level.coarse_passes = 3;
  task.expect_equal();
}

TEST(TiledTransfer, GivesThemWithTwoControlsOfOtherMappingsAndOptions) {
  TiledCase task(40, waved_patchwork(), {"x=facing:2:linear", "y=!height:1:rank"});
  task.task.options.neighborhood_radius_px = 2;
  task.task.options.seed = 7;
  task.task.options.multi_level.fine_passes = 3;
  task.task.options.multi_level.coarse_passes = 2;
  task.task.input.frames = nullptr;
  task.task.flow = "uv";
  task.expect_equal();
}

TEST(TiledTransfer, GivesThemWhereTheHistoryIsHalvedAndTilesAreInARow) {
  TiledCase task(48, testing_support::udim_plane(60.0, 5));
  task.task.options.quality = TransferQuality::Best;  // Borders are refined, though there are no lines.
  task.task.input.texel_size_mm *= 0.5;
  task.task.options.multi_level.coarse_passes = 2;
  task.expect_equal();
}

/// Cells between dark lines that open over time.
float cracked(int x, int y, int frame, int channel) {
  const bool is_on_line = (x + y / 4) % 19 < 2 || (y + x / 5) % 17 < 2;
  return (is_on_line ? 0.6f - 0.27f * static_cast<float>(frame) : 0.6f) +
         0.05f * testing_support::blotches(x, y, 0, channel);
}

TEST(TiledTransfer, GivesThemWhereBordersAreRefinedAlongLines) {
  for (const auto& [tile_px, halvings] : {std::pair(64, 0), std::pair(48, 1)}) {
    TiledCase task(tile_px, waved_patchwork(), {"x=0.6*facing + 0.4*height"}, cracked);
    task.task.options.appearance = {};
    task.task.options.multi_level.coarse_passes = 2;
    for (int i = 0; i < halvings; ++i) task.task.input.texel_size_mm *= 0.5;
    task.expect_equal();
    const Json made = load_json(task.folder / "tiled" / "transfer.json");
    EXPECT_TRUE(made.contains("structure")) << "there are lines to refine along";
    TransferTask draft = task.task;
    draft.options.quality = TransferQuality::Draft;
    ASSERT_EQ(run_job(plan_transfer(draft, task.folder / "draft"), {}, {}), JobStatus::Done);
    EXPECT_FALSE(read_file(task.folder / "tiled" / "coordinates.1001.exr") ==
                 read_file(task.folder / "draft" / "coordinates.1001.exr"))
        << "borders have moved";
  }
}

TEST(TiledTransfer, IsCutIntoItemsThatWaitForEarlierStagesOnly) {
  const TiledCase task(64);
  const JobPlan plan = plan_tiled_transfer(task.tiled(), task.folder / "tiled");
  int stage = 0;
  for (const JobItem& item : plan.items) {
    EXPECT_GE(item.stage, stage);
    stage = item.stage;
  }
  // Survey, match, two halvings, the coarse levels, two levels of start and passes, and the end.
  EXPECT_EQ(stage + 1, 2 + 2 + 1 + (1 + 12) + (1 + 2) + 1);
  EXPECT_EQ(plan.items.size(), 16u * static_cast<std::size_t>(stage) + 1u);
}

TEST(TiledTransfer, RefusesWhatLooksAtTheWholeAtlas) {
  const TiledCase task(64);
  TiledTask reference = task.tiled();
  reference.transfer.options.method = TransferMethod::Reference;
  EXPECT_TRUE(has(error_of([&] { (void)plan_tiled_transfer(reference, "out"); }), "--method reference"));
  TiledTask accessibility = task.tiled();
  accessibility.transfer.input.controls[0].destination = "accessibility";
  EXPECT_TRUE(has(error_of([&] { (void)plan_tiled_transfer(accessibility, "out"); }),
                  "`accessibility` looks at the whole atlas"));
  TiledTask one = task.tiled();
  one.transfer.input.map = std::make_shared<TexelMap>(testing_support::unit_plane(20.0), 64, 64);
  EXPECT_TRUE(has(error_of([&] { (void)plan_tiled_transfer(one, "out"); }), "one tile"));
}

// Every rectangle of a level is a tile's, and only its.
TEST(TransferTileGrid, CoversEveryLevelOnce) {
  const TileGrid grid(make_sheet({"a", "b", "c", "d", "e", "f", "g", "h", "i"}, 41));
  for (std::size_t level = 0; level <= 4; ++level) {
    std::int64_t covered = 0;
    for (int tile = 0; tile < grid.num_tiles(); ++tile) {
      const TexelRect rect = grid.rect(level, tile);
      covered += rect.num_texels();
      for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x)
          ASSERT_EQ(grid.tile_of(level, x, y), tile) << level << " " << x << " " << y;
      }
    }
    EXPECT_EQ(covered, grid.num_texels(level));
  }
}

}  // namespace
}  // namespace patinate::transfer
