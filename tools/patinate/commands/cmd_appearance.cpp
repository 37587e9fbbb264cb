#include <filesystem>
#include <nlohmann/json.hpp>

#include "libcommon/history/appearance_json.h"
#include "libcommon/history/stated_history.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/history/trim_history.h"
#include "patinate/transfer/transfer_io.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// Numbers for the whole history.
struct PlainAppearance {
  std::optional<double> metalness, roughness, specular;
};
void describe(OptionVisitor& v, PlainAppearance& o) {
  v.visit({"metalness", "Everywhere and always: 0 = no metal, 1 = metal", "", between(0, 1)}, o.metalness);
  v.visit({"roughness", "Of the mirror, everywhere and always: 0 = polished, 1 = dull", "", between(0, 1)},
          o.roughness);
  v.visit(
      {"specular", "What is no metal reflects so much at normal incidence, everywhere and always", "", between(0, 1)},
      o.specular);
}

std::optional<StatedValue> constant(const std::optional<double>& value) {
  if (!value) return std::nullopt;
  return StatedValue{.curve = {{{0.0, *value}}}};
}

Appearance appearance_of(const fs::path& file, const PlainAppearance& plain) {
  Appearance numbers;
  numbers.metalness = constant(plain.metalness);
  numbers.roughness = constant(plain.roughness);
  numbers.specular = constant(plain.specular);
  if (file.empty() == numbers.is_empty())
    throw UsageError("APPEARANCE: expected a file, or --metalness, --roughness or --specular");
  return file.empty() ? numbers : read_appearance_file(file);
}

JobPlan plan_appearance(const fs::path& folder, const Appearance& appearance, const fs::path& output) {
  const HistoryReader reader(folder);
  check_appearance(reader.facts(), appearance);
  TrimmedHistory all = trim_history(reader.manifest(), {});
  JobInputs inputs("appearance", 1);
  inputs.add_content("history", "the history", transfer::history_content_key(reader));
  inputs.add_value("appearance", appearance_key(appearance));
  JobPlan plan = inputs.plan(output, kHistoryManifestFile);
  all.manifest.key = plan.key;
  std::vector<fs::path> outputs;
  for (const TrimmedHistory::File& file : all.files) outputs.push_back(file.to);
  plan.items.push_back(
      {.name = "files",
       .outputs = outputs,
       .run = [from = reader.folder(), files = all.files](const fs::path& to, const RunControl& control) {
         copy_history_files(from, files, to, control);
       }});
  plan.join = [manifest = all.manifest, appearance](const fs::path& made, const RunControl& control) {
    write_history_manifest(made / kHistoryManifestFile, manifest);
    state_appearance(made, appearance, mask_reader(facts_of(manifest)), control);
  };
  return plan;
}

}  // namespace

int cmd_appearance(CommandRun& run) {
  fs::path history, file, output;
  PlainAppearance plain;
  run.line.positional("HISTORY", "A history or a simulation", history);
  run.line.positional("APPEARANCE", "A JSON file that says it by color, over time, or by control or mask", file);
  run.line.required(false);
  run.line.output("STATED", "Folder to make: the history with maps of its material", output);
  run.line.options(plain);
  run.line.without({"seed"});
  run.line.example("appearance copper copper_and_patina.json -o copper_metal");
  run.line.example("appearance bronze --metalness 1 --roughness 0.35 -o bronze_metal");
  if (!run.parse()) return 0;
  history = history_place(history);
  if (kind_of(history) != PathKind::History)
    throw InvalidInput(history.string() + ": is no history; state the material of the one it was made from");
  const JobPlan plan = plan_appearance(history, appearance_of(file, plain), output);
  const std::optional<JobStatus> status = run.make_folder(plan, "appearance");
  if (!status) return 0;
  const HistoryManifest made = read_history_manifest(output);
  Json frame_maps = Json::array(), maps = Json::array();
  for (const HistoryImage& extra : made.frames.front().extras) frame_maps.push_back(extra.name);
  for (const HistoryMap& map : made.maps) maps.push_back(map.name);
  run.report_output(*status, output, Json{{"frame_maps", frame_maps}, {"constant_maps", maps}});
  return 0;
}

}  // namespace patinate::cli
