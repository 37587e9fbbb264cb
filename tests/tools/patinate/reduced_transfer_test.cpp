#include "app/output/reduced_transfer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libcommon/image/filters.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/image/color.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/job/transfer_job.h"

namespace patinate::cli {
namespace {

namespace fs = std::filesystem;

TEST(ReducedTransfer, FitsTilesIntoWhatIsAskedFor) {
  const Sheet sheet{.tile_width = 64, .tile_height = 64, .columns = 2, .names = {"1001", "1002", "1011"}};
  EXPECT_EQ(app::reduced_sheet(sheet, std::int64_t{136} * 136).tile_width, 64);
  EXPECT_EQ(app::reduced_sheet(sheet, std::int64_t{136} * 136 - 1).tile_width, 32);
  EXPECT_EQ(app::reduced_sheet(sheet, 3000).tile_width, 21);
  EXPECT_EQ(app::reduced_sheet(sheet, 1).tile_width, 1);
}

// Against the texture in full, whose values are rounded to codes there: half a code of 255, at most 1 / 255 in light.
TEST(ReducedTransfer, IsTheMeanOfItsTexels) {
  const testing_support::TempFolder folder;
  fs::create_directory(folder / "history");
  testing_support::write_history(folder / "history", 96, 64, 3, testing_support::blotches);
  Mesh mesh = testing_support::patchwork_plane(60.0, 4);
  for (Vec2& uv : mesh.uvs) uv *= 2.0;
  transfer::TransferTask task;
  task.history = std::make_shared<const HistoryReader>(folder / "history");
  task.atlas = std::make_shared<AtlasMesh>(atlas_mesh_of(mesh, find_uv_layout(mesh)));
  task.input.map = std::make_shared<TexelMap>(make_texel_map(*task.atlas, 64));
  task.mesh_name = "plane.obj";
  task.input.texel_size_mm = task.input.map->median_texel_size_mm();
  ControlMap made = make_control_expression("height", *task.input.map, {});
  task.input.controls.push_back(
      {"x", "height", std::move(made.values), {made.low, made.high, made.unit}, 1.0, transfer::ControlMapping::Rank});
  task.options.appearance.structure = 0.0;
  ASSERT_EQ(run_job(plan_transfer(task, folder / "aged"), {}, {}), JobStatus::Done);

  const transfer::TransferReader whole(folder / "aged");
  const app::ReducedTransfer reduced(std::make_shared<const transfer::TransferFolder>(folder / "aged"), 6000);
  ASSERT_EQ(reduced.sheet().tile_width, 32);
  const double time = 0.5 * whole.history().manifest().frames.back().time;
  const std::vector<ImageF> expected = whole.sample_tiles(time);
  const ImageF found = reduced.sample(time);
  for (int tile = 0; tile < 4; ++tile) {
    const ImageF mean = downscale_area(expected[tile], 32, 32), own = cut_tile(found, reduced.sheet(), tile);
    for (std::size_t i = 0; i < mean.values().size(); ++i)
      ASSERT_NEAR(own.values()[i], mean.values()[i], 1.0 / 255.0) << tile << " " << i;
  }
}

}  // namespace
}  // namespace patinate::cli
