#include "transfer/job/transfer_job.h"

#include <span>

#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/job/job_inputs.h"

namespace patinate::transfer {

namespace fs = std::filesystem;

namespace {

/// Raised when the same input gives other coordinates: of an atlas of one tile, and of several.
constexpr std::int64_t kStageVersion = 13, kTilesVersion = 15;

}  // namespace

JobInputs transfer_inputs(const TransferTask& task, std::string_view stage) {
  const Sheet& sheet = task.input.map->sheet();
  JobInputs inputs(stage, sheet.num_tiles() > 1 ? kTilesVersion : kStageVersion);
  inputs.add_content("history", "the history", history_content_key(*task.history));
  inputs.add_content("mesh", task.mesh_name, mesh_content_key(task.input.map->mesh()));
  inputs.add_value("--resolution", size_text(sheet.tile_width, sheet.tile_height));
  std::string tiles;
  for (const std::string& name : sheet.names) tiles += (tiles.empty() ? "" : ", ") + name;
  inputs.add_value("--atlas", task.atlas && task.atlas->is_unwrapped ? "unwrap"
                              : tiles.empty()                        ? "uv"
                                                                     : "uv: " + tiles);
  inputs.add_value("surface length of a pixel (mm)", number_text(task.input.texel_size_mm));
  inputs.add_value("--unit", task.unit.value_or("none"));
  inputs.add_value("millimeters per unit of the mesh", number_text(task.mm_per_mesh_unit));
  for (const TransferControl& c : task.input.controls) {
    const std::string name = "--control " + c.source;
    inputs.add_value(name, c.destination + ":" + number_text(c.weight) + ":" +
                               std::string(kControlMappingNames[static_cast<std::size_t>(c.mapping)]));
    ContentHash map;
    map.add(std::as_bytes(c.values.values())).add(c.range.low).add(c.range.high).add(c.range.unit);
    inputs.add_content("control", "map of " + name, map.hex());
  }
  if (!task.input.source_mask.empty()) {
    ContentHash mask;
    mask.add(std::as_bytes(task.input.source_mask.values()));
    inputs.add_content("source mask", "--source-mask " + task.source_mask_name, mask.hex());
  }
  inputs.add_value("--flow", task.flow);
  if (task.input.frames) {
    ContentHash frames;
    for (const FlowFrame& f : *task.input.frames)
      frames.add(std::as_bytes(std::span(f.data(), static_cast<std::size_t>(f.size()))));
    inputs.add_content("flow", "directions on the surface", frames.hex());
  }
  inputs.add_options(option_values(task.options));
  inputs.add_value("--seed", std::to_string(task.options.seed));
  return inputs;
}

JobPlan plan_transfer(TransferTask task, const fs::path& output) {
  check_ranges(task.options);
  task.input.history = task.history;
  const auto shared = std::make_shared<const TransferTask>(std::move(task));
  JobPlan plan = transfer_inputs(*shared).plan(output, "transfer.json");
  plan.parallel_items = false;
  // One item: with the manifest's figures in memory only, a killed run starts its synthesis again.
  plan.join = [shared, key = plan.key, output](const fs::path& folder, const RunControl& control) {
    const TransferResult result = transfer(shared->input, shared->options, control);
    write_transfer_files(folder, *shared, result, control);
    write_transfer_manifest(folder, output, *shared, result, key);
  };
  return plan;
}

}  // namespace patinate::transfer
