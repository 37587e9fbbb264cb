#include "tools/patinate/services/evaluated_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/job/spread_job.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/json.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "tools/patinate/services/evaluated_maps.h"
#include "transfer/job/transfer_job.h"

namespace patinate::cli {
namespace {

namespace fs = std::filesystem;
using testing_support::TempFolder;

/// A transfer onto a waved square of turned and mirrored charts, 2 x 2 in each of `side` x `side` UDIM tiles.
void make_transfer(const TempFolder& folder, int tile_px, int side = 2) {
  fs::create_directory(folder / "history");
  testing_support::write_history(folder / "history", 96, 64, 3, testing_support::blotches);
  Mesh mesh = testing_support::patchwork_plane(60.0, 2 * side);
  for (Vec3& p : mesh.positions) p.z() = 3.0 * std::sin(p.x() / 6.0) + 2.0 * std::cos(p.y() / 4.0);
  for (Vec2& uv : mesh.uvs) uv *= side;
  transfer::TransferTask task;
  task.history = std::make_shared<const HistoryReader>(folder / "history");
  task.atlas = std::make_shared<AtlasMesh>(atlas_mesh_of(mesh, find_uv_layout(mesh)));
  task.input.map = std::make_shared<TexelMap>(make_texel_map(*task.atlas, tile_px));
  task.mesh_name = "waves.obj";
  task.input.texel_size_mm = task.input.map->median_texel_size_mm();
  task.input.frames = std::make_shared<const FlowFrames>(
      direction_frames(*task.input.map, DirectionKind::Gravity, Vec3(0.0, 1.0, 0.0)));
  task.flow = "gravity";
  ControlMap made = make_control_expression("0.6*facing + 0.4*height", *task.input.map, {});
  task.input.controls.push_back({"x",
                                 "0.6*facing + 0.4*height",
                                 std::move(made.values),
                                 {made.low, made.high, made.unit},
                                 1.0,
                                 transfer::ControlMapping::Rank});
  task.options.appearance.structure = 0.0;
  task.options.multi_level.coarse_passes = 2;
  ASSERT_EQ(run_job(plan_transfer(task, folder / "aged"), {}, {}), JobStatus::Done);
}

/// Of the transfer that make_transfer() made, with few samples.
analysis::EvaluationTask task_of(const TempFolder& folder) {
  analysis::EvaluationTask task;
  task.options = {.num_samples = 500, .num_directions = 4, .num_audits = 200};
  task.maps = {transfer_item(folder / "aged", task.options, 1, {.cache = false})};
  return task;
}

/// Runs the items of every tile, and evaluates the map in one piece.
void expect_report_of_the_whole(const analysis::EvaluationTask& task, const TempFolder& folder, std::size_t num_tiles) {
  ASSERT_TRUE(task.maps[0].tiles);
  const analysis::MapToEvaluate opened = task.maps[0].open({});
  const analysis::Evaluation made = analysis::evaluate(opened.source, opened.map, task.options, 1);
  Json expected = Json::array();
  for (const auto* list : {&opened.more, &made.figures}) {
    for (const analysis::Figure& f : *list) expected.push_back(analysis::figure_json(f));
  }
  const JobPlan plan = analysis::plan_evaluation(task, folder / "report");
  EXPECT_EQ(plan.items.size(), 2 * num_tiles + 1);
  ASSERT_EQ(run_job(plan, {}, {}), JobStatus::Done);
  const Json report = load_json(folder / "report" / "evaluation.json");
  EXPECT_EQ(report.at("maps").at(0).at("figures"), expected);
  EXPECT_EQ(report.at("maps").at(0).at("hash"), made.hash);
}

TEST(EvaluatedTiles, SayWhatTheWholeTransferSays) {
  const TempFolder folder;
  make_transfer(folder, 64);
  const analysis::EvaluationTask task = task_of(folder);
  expect_report_of_the_whole(task, folder, 4);

  // Item by item, as processes of their own would, and the last tile first.
  const JobPlan spread = analysis::plan_evaluation(task, folder / "spread");
  for (const int stage : {0, 1, 2}) {
    for (std::size_t i = spread.items.size(); i-- > 0;) {
      const std::array<std::size_t, 1> item{i};
      if (spread.items[i].stage == stage) {
        EXPECT_EQ(run_spread_items(analysis::plan_evaluation(task, folder / "spread"), item, {}, {}), 1u);
      }
    }
  }
  ASSERT_EQ(join_spread_items(spread, {}, {}), JobStatus::Done);
  for (const char* name : {"evaluation.json", "evaluation.html"})
    EXPECT_EQ(read_file(folder / "spread" / name), read_file(folder / "report" / name)) << name;
}

TEST(EvaluatedTiles, Of64TilesSayWhatTheWholeTransferSays) {
  const TempFolder folder;
  make_transfer(folder, 20, 8);
  expect_report_of_the_whole(task_of(folder), folder, 64);
}

TEST(EvaluatedTiles, AreNoneOfATransferOfOneTile) {
  const TempFolder folder;
  fs::create_directory(folder / "history");
  testing_support::write_history(folder / "history", 96, 64, 2, testing_support::blotches);
  const Mesh mesh = testing_support::unit_plane(60.0);
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
  EXPECT_FALSE(transfer_tiles(folder / "aged", {}, 1, {.cache = false}));
}

}  // namespace
}  // namespace patinate::cli
