#include "transfer/transfer_job.h"

#include "libcommon/core/hash.h"
#include "libcommon/geometry/mesh_key.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 1;  ///< Raised when the same input gives other coordinates.

/// Of everything that coordinates depend on: by content, never by path.
std::string transfer_key(const TransferTask& task, const std::string& history_key) {
  ContentHash hash;
  hash.add("transfer").add(kStageVersion).add(history_key).add(mesh_content_key(task.map->mesh()));
  hash.add(std::int64_t{task.map->width()}).add(std::int64_t{task.map->height()}).add(task.texel_size_mm).add(task.mm_per_mesh_unit);
  hash.add(task.unit.value_or(""));
  for (const TransferControl& c : task.controls) {
    hash.add(c.source).add(c.destination).add(c.weight).add(static_cast<std::int64_t>(c.mapping));
    hash.add(std::as_bytes(c.values.values())).add(c.range.low).add(c.range.high).add(c.range.unit);
  }
  for (const auto& [name, value] : option_values(task.options)) hash.add(name).add(value);
  return hash.add(task.options.seed).hex();
}

}  // namespace

JobPlan plan_transfer(TransferTask task, const fs::path& output) {
  check_ranges(task.options);
  const auto shared = std::make_shared<const TransferTask>(std::move(task));
  const auto result = std::make_shared<TransferResult>();
  JobPlan plan;
  plan.output = output;
  plan.manifest = "transfer.json";
  plan.key = transfer_key(*shared, history_content_key(HistoryReader(shared->history)));
  plan.parallel_items = false;
  // One item: with the manifest's figures in memory only, a killed run starts its synthesis again.
  plan.join = [shared, result, key = plan.key, output](const fs::path& folder, const RunControl& control) {
    const HistoryReader history(shared->history);
    *result = transfer(history, shared->map, shared->texel_size_mm, shared->controls, shared->options, control);
    write_transfer_files(folder, *shared, *result, history.manifest().width);
    write_transfer_manifest(folder, output, *shared, result->energy, result->explained_variance, key);
  };
  return plan;
}

}  // namespace patinate
