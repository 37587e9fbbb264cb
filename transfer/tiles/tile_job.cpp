#include "transfer/tiles/tile_job.h"

#include <cmath>
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

/// What an item takes by the texels of its tile: measured in November 2026 on 2 x 2 tiles of 256, 512 and 1024 texels
/// with a history of 256 x 192 pixels and one control (docs/scaling.md).
struct StepCost {
  double seconds = 0.0;        ///< Before the first texel: reading mesh and history, preparing the source.
  double texel_seconds = 0.0;  ///< And for each texel of the tile, on the level of the step.
  double side_seconds = 0.0;   ///< For each texel along a side of the tile: what lies along its borders.
};
constexpr StepCost kSurvey{0.01, 6e-8}, kMatch{0.1, 1.4e-7}, kHalve{0.08, 2e-7}, kStart{0.09, 1e-7},
    kPass{0.12, 1.1e-6}, kRefine{0.45, 1.25e-5}, kBorders{0.45, 0.0, 2.5e-3}, kFinish{0.1, 6e-7}, kCoarse{0.6, 3.5e-6};

/// Adds the items of one stage after the other.
class StageList {
 public:
  StageList(JobPlan& plan, const TileGrid& grid) : plan_(plan), grid_(grid) {}

  /// An item a tile. @param name  Before the tile's number.
  void add(const std::string& name, std::size_t level, const StepCost& step,
           const std::function<std::vector<fs::path>(int tile)>& outputs,
           const std::function<Work(int tile)>& work_of) {
    for (int tile = 0; tile < grid_.num_tiles(); ++tile)
      add_item(name + "." + std::to_string(tile), outputs(tile), work_of(tile),
               weight_of(step, grid_.rect(level, tile).num_texels()));
    ++stage_;
  }
  void add_one(const std::string& name, std::size_t level, const StepCost& step, std::vector<fs::path> outputs,
               Work work) {
    add_item(name, std::move(outputs), std::move(work), weight_of(step, grid_.num_texels(level)));
    ++stage_;
  }

 private:
  [[nodiscard]] static double weight_of(const StepCost& step, std::int64_t texels) {
    const auto here = static_cast<double>(texels);
    return step.seconds + step.texel_seconds * here + step.side_seconds * std::sqrt(here);
  }
  void add_item(const std::string& name, std::vector<fs::path> outputs, Work work, double weight) {
    plan_.items.push_back(
        {.name = name, .outputs = std::move(outputs), .run = std::move(work), .stage = stage_, .weight = weight});
  }

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
      "survey", 0, kSurvey,
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
      "match", 0, kMatch,
      [&](int tile) {
        std::vector<fs::path> files{tile_file::targets(0, tile)};
        for (std::size_t l = 0; l < num_tiled; ++l) {
          files.push_back(tile_file::links(l, tile));
          if (tiled->num_rounds(l) > 0) files.push_back(tile_file::borders(l, tile));
        }
        return files;
      },
      [&](int tile) -> Work { return [=](const fs::path& f, const RunControl& c) { tiled->match(tile, f, c); }; });
  for (std::size_t l = 1; l <= num_tiled; ++l) {
    stages.add(
        "halve-level" + std::to_string(l), l, kHalve,
        [&](int tile) { return std::vector<fs::path>{tile_file::targets(l, tile)}; },
        [&](int tile) -> Work { return [=](const fs::path& f, const RunControl& c) { tiled->halve(l, tile, f, c); }; });
  }
  std::vector<fs::path> coarse{tile_file::coarse(), tile_file::num_levels()};
  for (std::size_t l = 0; l < num_tiled; ++l) coarse.push_back(tile_file::similar(l));
  stages.add_one("coarse-levels", num_tiled, kCoarse, std::move(coarse),
                 [=](const fs::path& f, const RunControl& c) { tiled->synthesize_coarse(f, c); });
  for (std::size_t l = num_tiled; l-- > 0;) {
    const std::string level = "level" + std::to_string(l);
    stages.add(
        level + "-start", l, kStart,
        [&](int tile) {
          return std::vector<fs::path>{tile_file::places(l, 0, tile), tile_file::counts(l, 0, tile)};
        },
        [&](int tile) -> Work { return [=](const fs::path& f, const RunControl& c) { tiled->start(l, tile, f, c); }; });
    const int num_passes = tiled->num_passes(l), num_rounds = tiled->num_rounds(l);
    for (int pass = 0; pass < num_passes; ++pass) {
      stages.add(
          level + "-pass" + std::to_string(pass), l, kPass,
          [&](int tile) {
            std::vector<fs::path> files{tile_file::places(l, pass + 1, tile)};
            if (pass + 1 < num_passes) {
              files.push_back(tile_file::counts(l, pass + 1, tile));
            } else if (num_rounds > 0) {
              files.push_back(tile_file::amounts(l, 0, tile));
            }
            return files;
          },
          [&](int tile) -> Work {
            return [=](const fs::path& f, const RunControl& c) { tiled->pass(l, pass, tile, f, c); };
          });
    }
    for (int round = 0; round < num_rounds; ++round) {
      stages.add(
          level + "-borders" + std::to_string(round), l, kBorders,
          [&](int tile) {
            return std::vector<fs::path>{tile_file::moved(l, round, tile), tile_file::zone_patience(l, round, tile)};
          },
          [&](int tile) -> Work {
            return [=](const fs::path& f, const RunControl& c) { tiled->refine_borders(l, round, tile, f, c); };
          });
      stages.add(
          level + "-refine" + std::to_string(round), l, kRefine,
          [&](int tile) {
            std::vector<fs::path> files{tile_file::places(l, num_passes + round + 1, tile),
                                        tile_file::patience(l, round, tile)};
            if (round + 1 < num_rounds) files.push_back(tile_file::amounts(l, round + 1, tile));
            return files;
          },
          [&](int tile) -> Work {
            return [=](const fs::path& f, const RunControl& c) { tiled->refine(l, round, tile, f, c); };
          });
    }
  }
  stages.add(
      "finish", 0, kFinish,
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
