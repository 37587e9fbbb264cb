#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/history/stated_appearance.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "patinate/history/history.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

int cmd_material(CommandRun& run) {
  fs::path history, file, output;
  app::PlainAppearance plain;
  run.line.positional("HISTORY", "A history or a simulation", history);
  run.line.positional("APPEARANCE", "A JSON file that says it by color, over time, or by control or mask", file);
  run.line.required(false);
  run.line.output("STATED", "Folder to make: the history with maps of its material", output);
  run.line.options(plain);
  run.line.without({"seed"});
  run.line.example("history material copper copper_and_patina.json -o copper_metal");
  run.line.example("history material bronze --metalness 1 --roughness 0.35 -o bronze_metal");
  if (!run.parse()) return 0;
  history = app::history_place(history);
  if (app::kind_of(history) != app::PathKind::History)
    throw InvalidInput(history.string() + ": is no history; state the material of the one it was made from");
  if (file.empty() == plain.is_empty())
    throw app::UsageError("APPEARANCE: expected a file, or --metalness, --roughness or --specular");
  const JobPlan plan = app::plan_appearance(history, app::appearance_of(file, plain), output);
  const std::optional<JobStatus> status = run.make_folder(plan, "material");
  if (!status) return 0;
  const HistoryManifest made = read_history_manifest(output);
  Json frame_maps = Json::array(), maps = Json::array();
  for (const HistoryImage& extra : made.frames.front().extras) frame_maps.push_back(extra.name);
  for (const HistoryMap& map : made.maps) maps.push_back(map.name);
  run.report_output(*status, output, Json{{"frame_maps", frame_maps}, {"constant_maps", maps}});
  return 0;
}

}  // namespace patinate::cli
