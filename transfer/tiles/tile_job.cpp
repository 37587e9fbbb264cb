#include "transfer/tiles/tile_job.h"

#include <span>

#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "transfer/files/transfer_files.h"
#include "transfer/job/transfer_job.h"
#include "transfer/tiles/tile_files.h"

namespace patinate::transfer {

namespace fs = std::filesystem;

namespace {

using Work = std::function<void(const fs::path& folder, const RunControl& control)>;

/// Adds the items of one stage after the other.
class StageList {
 public:
  StageList(JobPlan& plan, const TileGrid& grid) : plan_(plan), grid_(grid) {}

  /// An item a tile. @param name  Before the tile's number. @param texels  About its work, a texel of level 0.
  void add(const std::string& name, std::size_t level, double work,
           const std::function<std::vector<fs::path>(int tile)>& outputs,
           const std::function<Work(int tile)>& work_of) {
    for (int tile = 0; tile < grid_.num_tiles(); ++tile) {
      plan_.items.push_back({.name = name + "." + std::to_string(tile),
                             .outputs = outputs(tile),
                             .run = work_of(tile),
                             .stage = stage_,
                             .weight = work * weight_of(level, tile)});
    }
    ++stage_;
  }
  void add_one(const std::string& name, double weight, std::vector<fs::path> outputs, Work work) {
    plan_.items.push_back(
        {.name = name, .outputs = std::move(outputs), .run = std::move(work), .stage = stage_++, .weight = weight});
  }
  [[nodiscard]] double weight_of(std::size_t level, int tile) const {
    return static_cast<double>(grid_.rect(level, tile).num_texels());
  }

 private:
  JobPlan& plan_;
  const TileGrid& grid_;
  int stage_ = 0;
};

}  // namespace

JobPlan plan_tiled_transfer(TiledTask task, const fs::path& output) {
  const auto tiled = std::make_shared<TiledTransfer>(std::move(task));
  const TransferTask& transfer = tiled->task().transfer;
  const TileGrid& grid = tiled->grid();
  const std::size_t num_tiled = tiled->num_tiled_levels();
  JobInputs inputs = transfer_inputs(transfer, "transfer by tile");
  inputs.add_options(option_values(tiled->task().kinds));
  JobPlan plan = inputs.plan(output, "transfer.json");
  plan.parallel_items = false;  // Each uses all threads itself.
  StageList stages(plan, grid);
  const std::size_t num_controls = transfer.input.controls.size();
  stages.add(
      "survey", 0, 0.3,
      [&](int tile) {
        std::vector<fs::path> files{tile_file::texel_counts(tile)};
        for (std::size_t c = 0; c < num_controls; ++c) {
          files.insert(files.end(),
                       {tile_file::values(c, tile), tile_file::sorted(c, tile), control_tile_file(transfer, c, tile)});
        }
        return files;
      },
      [&](int tile) -> Work { return [=](const fs::path& f, const RunControl& c) { tiled->survey(tile, f, c); }; });
  stages.add(
      "match", 0, 0.5,
      [&](int tile) {
        std::vector<fs::path> files{tile_file::targets(0, tile)};
        for (std::size_t l = 0; l < num_tiled; ++l) files.push_back(tile_file::links(l, tile));
        return files;
      },
      [&](int tile) -> Work { return [=](const fs::path& f, const RunControl& c) { tiled->match(tile, f, c); }; });
  for (std::size_t l = 1; l <= num_tiled; ++l) {
    stages.add(
        "halve-level" + std::to_string(l), l, 0.2,
        [&](int tile) { return std::vector<fs::path>{tile_file::targets(l, tile)}; },
        [&](int tile) -> Work { return [=](const fs::path& f, const RunControl& c) { tiled->halve(l, tile, f, c); }; });
  }
  std::vector<fs::path> coarse{tile_file::coarse(), tile_file::num_levels()};
  for (std::size_t l = 0; l < num_tiled; ++l) coarse.push_back(tile_file::similar(l));
  stages.add_one("coarse-levels", 10.0 * static_cast<double>(grid.num_texels(num_tiled)), std::move(coarse),
                 [=](const fs::path& f, const RunControl& c) { tiled->synthesize_coarse(f, c); });
  for (std::size_t l = num_tiled; l-- > 0;) {
    const std::string level = "level" + std::to_string(l);
    stages.add(
        level + "-start", l, 0.3,
        [&](int tile) {
          return std::vector<fs::path>{tile_file::places(l, 0, tile), tile_file::counts(l, 0, tile)};
        },
        [&](int tile) -> Work { return [=](const fs::path& f, const RunControl& c) { tiled->start(l, tile, f, c); }; });
    const int num_passes = tiled->num_passes(l);
    for (int pass = 0; pass < num_passes; ++pass) {
      stages.add(
          level + "-pass" + std::to_string(pass), l, 1.0,
          [&](int tile) {
            std::vector<fs::path> files{tile_file::places(l, pass + 1, tile)};
            if (pass + 1 < num_passes) files.push_back(tile_file::counts(l, pass + 1, tile));
            return files;
          },
          [&](int tile) -> Work {
            return [=](const fs::path& f, const RunControl& c) { tiled->pass(l, pass, tile, f, c); };
          });
    }
  }
  stages.add(
      "finish", 0, 0.5,
      [&](int tile) {
        return std::vector<fs::path>{tile_file::figures(tile), coordinate_tile_file(transfer, tile)};
      },
      [&](int tile) -> Work { return [=](const fs::path& f, const RunControl& c) { tiled->finish(tile, f, c); }; });
  plan.join = [=, key = plan.key](const fs::path& folder, const RunControl& control) {
    tiled->join(folder, output, key, control);
  };
  return plan;
}

}  // namespace patinate::transfer
