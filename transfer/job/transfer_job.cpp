#include "transfer/job/transfer_job.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/job/job.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/transfer/age.h"
#include "transfer/editing/transfer_editor.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate::transfer {

namespace fs = std::filesystem;

namespace {

/// Raised when the same input gives other coordinates: of an atlas of one tile, and of several.
constexpr std::int64_t kStageVersion = 14, kTilesVersion = 16;

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

namespace {

constexpr double kTransferShare = 0.7;  // Of the progress of a transfer that is edited.

/// @throws InvalidInput naming the edit, from 1, that cannot be applied
void apply_edits(const fs::path& folder, const TransferEdits& edits, const AppearanceSource& appearance,
                 const RunControl& control) {
  constexpr double kOpened = 0.3;  // Share of the progress.
  TransferEditor editor(folder, appearance, control.part(0.0, kOpened));
  const std::size_t count = edits.edits.size();
  for (std::size_t i = 0; i < count; ++i) {
    try {
      (void)editor.apply(edits.edits[i], control.silent());
    } catch (const InvalidInput& error) {
      throw InvalidInput("edit " + std::to_string(i + 1) + ": " + error.what());
    }
    control.report(kOpened + (1.0 - kOpened) * static_cast<double>(i + 1) / static_cast<double>(count));
  }
  editor.write(control.silent());
}

/// Says before the search what cannot be applied after it.
void check_edits(const TransferEdits& edits, const TransferTask& task) {
  std::vector<std::string> followed;
  for (const TransferControl& c : task.input.controls) followed.push_back(c.source);
  check_edits(edits, followed);
  if (edits.edits.empty()) return;
  const SurfaceBrush brush(*task.input.map);
  for (std::size_t i = 0; i < edits.edits.size(); ++i) {
    const TransferEdit& edit = edits.edits[i];
    if (edit.kind == EditKind::Stroke && brush.find(edit.stroke).empty())
      throw InvalidInput("edit " + std::to_string(i + 1) + ": " + unreached_text(edit.stroke));
  }
}

using MakeResult = std::function<TransferResult(const TransferTask& task, const RunControl& control)>;

JobPlan plan_made_by(TransferTask task, const fs::path& output, TransferEdits edits, MakeResult make) {
  check_ranges(task.options);
  task.input.history = task.history;
  check_edits(edits, task);
  const auto shared = std::make_shared<const TransferTask>(std::move(task));
  JobInputs inputs = transfer_inputs(*shared);
  if (!edits.edits.empty()) inputs.add_content("edits", "--edits", ContentHash().add(edits_json(edits).dump()).hex());
  JobPlan plan = inputs.plan(output, "transfer.json");
  plan.parallel_items = false;
  // One item: with the manifest's figures in memory only, a killed run starts its synthesis again.
  plan.join = [shared, key = plan.key, output, edits = std::move(edits), make = std::move(make)](
                  const fs::path& folder, const RunControl& control) {
    const double share = edits.edits.empty() ? 1.0 : kTransferShare;
    const TransferResult result = make(*shared, control.part(0.0, share));
    write_transfer_files(folder, *shared, result, control);
    write_transfer_manifest(folder, output, *shared, result, key);
    if (!edits.edits.empty()) apply_edits(folder, edits, shared->input.appearance, control.part(share, 1.0));
  };
  return plan;
}

/// Result of the synthesis, as far as files keep it.
TransferResult result_of(const AgedMesh& aged) {
  const HistoryFacts& facts = aged.history->facts();
  const PackedPlaces places = pack_coordinates(aged.coordinates, facts.width, facts.height);
  TransferResult result;
  result.energy = aged.energy;
  result.explained_variance = aged.explained_variance;
  result.used = aged.used;
  result.structure = aged.structure;
  result.refused_line_share = aged.refused_line_share;
  const auto num_texels = static_cast<std::size_t>(aged.coordinates.num_pixels());
  result.coordinates = CoordinateMap(num_texels);
  if (!places.beside.empty()) result.fractions = ZeroedVector<std::int8_t>(2 * num_texels);
  for (std::size_t t = 0; t < num_texels; ++t) {
    const std::uint32_t pixel = places.pixels.values()[t];
    result.coordinates[t] = pixel == kNoValue ? -1 : static_cast<std::int32_t>(pixel);
    if (pixel == kNoValue || places.beside.empty()) continue;
    const BesidePixel beside = unpack_beside(places.beside.values()[t]);
    result.fractions[2 * t] = beside.x, result.fractions[2 * t + 1] = beside.y;
  }
  if (!aged.turns.empty()) {
    result.turns = ZeroedVector<std::int16_t>(num_texels);
    std::copy(aged.turns.begin(), aged.turns.end(), result.turns.begin());
  }
  return result;
}

}  // namespace

JobPlan plan_transfer(TransferTask task, const fs::path& output, TransferEdits edits) {
  return plan_made_by(std::move(task), output, std::move(edits), [](const TransferTask& t, const RunControl& control) {
    return transfer(t.input, t.options, control);
  });
}

void AgedMesh::save(const fs::path& path, const SaveOptions& options, const RunControl& run) const {
  if (folder) throw InvalidInput("this aged mesh was read from a folder; copy that folder");
  TransferTask task{.history = std::dynamic_pointer_cast<const HistoryReader>(history),
                    .input = {.history = history,
                              .map = surface.map,
                              .texel_size_mm = surface.texel_size_mm,
                              .controls = controls,
                              .frames = frames},
                    .options = asked,
                    .atlas = surface.atlas,
                    .mesh_name = surface.name,
                    .unit = surface.unit,
                    .mm_per_mesh_unit = surface.mm_per_mesh_unit,
                    .is_history_installed = options.is_history_installed,
                    .flow = std::string(kDirectionKindNames[static_cast<std::size_t>(flow)]),
                    .source_mask_name = ""};
  if (!task.history)
    throw InvalidInput(
        "the history of this transfer is in memory only: save it, read it again, and transfer from that");
  const JobPlan plan = plan_made_by(std::move(task), path, {},
                                    [this](const TransferTask&, const RunControl&) { return result_of(*this); });
  (void)run_job(plan, {.force = options.force}, run);
}

}  // namespace patinate::transfer
