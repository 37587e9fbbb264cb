#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "simulation/job/frame_maps.h"
#include "simulation/job/simulation_job.h"
#include "simulation/job/simulation_output.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/checked_devices.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// MATERIAL.WHAT=VALUE
struct LookChange {
  std::size_t material = 0;
  std::string what;
  double value = 0.0;
};

struct LookField {
  std::string_view name;
  double simulation::MaterialAppearance::*field;
  Range range;
};
constexpr std::array kFields{
    LookField{"strength", &simulation::MaterialAppearance::strength, {0, 1000}},
    LookField{"variation", &simulation::MaterialAppearance::variation, {0, 1}},
    LookField{"specular", &simulation::MaterialAppearance::specular, {-1, 1}},
    LookField{"specular_variation", &simulation::MaterialAppearance::specular_variation, {0, 1}},
    LookField{"height", &simulation::MaterialAppearance::height_mm, {-1e6, 1e6}},
    LookField{"height_variation", &simulation::MaterialAppearance::height_variation, {0, 1}},
    LookField{"grain", &simulation::MaterialAppearance::grain_mm, {0, 1e9}}};

LookChange parse_change(const std::string& text, const std::vector<std::string>& materials) {
  const auto fail = [&](const std::string& expected) -> UsageError {
    return UsageError("--set: found `" + text + "`; expected " + expected);
  };
  const std::size_t equals = text.find('=');
  const std::size_t dot = text.rfind('.', equals);
  if (equals == std::string::npos || dot == std::string::npos)
    throw fail("MATERIAL.WHAT=VALUE, such as rust.strength=0.5");
  LookChange change{.what = text.substr(dot + 1, equals - dot - 1)};
  const std::string material = text.substr(0, dot);
  const auto found = std::find(materials.begin(), materials.end(), material);
  if (found == materials.end()) throw fail("a material of the simulation" + did_you_mean(material, materials));
  change.material = static_cast<std::size_t>(found - materials.begin());
  const std::optional<double> value = parse_number(text.substr(equals + 1));
  for (const LookField& field : kFields) {
    if (field.name != change.what) continue;
    if (!value || !field.range.contains(*value)) throw fail("a number in " + field.range.text());
    change.value = *value;
    return change;
  }
  std::vector<std::string> names;
  for (const LookField& field : kFields) names.emplace_back(field.name);
  throw fail("strength, variation, specular, specular_variation, height, height_variation or grain" +
             did_you_mean(change.what, names));
}

void apply_change(const LookChange& change, std::vector<simulation::MaterialAppearance>& appearance) {
  for (const LookField& field : kFields) {
    if (field.name == change.what) appearance[change.material].*field.field = change.value;
  }
}

struct RecomposeOptions {
  simulation::ColorForm color_form = simulation::ColorForm::Normalized;
};
void describe(OptionVisitor& v, RecomposeOptions& o) {
  v.visit_choice({"color_form", "How colors mix: normalized weights, or the form of the published shader"},
                 o.color_form, simulation::kColorFormNames);
}

/// A simulation with another look, made when it is first asked for.
struct Recomposed {
  fs::path source;
  simulation::SceneFile file;
  simulation::ColorForm form;
  std::shared_ptr<const simulation::SimulationDevice> device;
  HistoryManifest frames;  ///< Of the source.
  std::unique_ptr<simulation::Simulation> made;

  simulation::Simulation& composed(const RunControl& control) {
    if (!made)
      made = std::make_unique<simulation::Simulation>(
          file.scene, simulation::SimulationOptions{.parameter_maps = {}, .color_form = form, .device = device},
          control);
    return *made;
  }
};

JobItem frame_item(const std::shared_ptr<Recomposed>& work, int index) {
  JobItem item{.name = "frame-" + zero_padded(static_cast<std::uint64_t>(index), 4),
               .outputs = {"history" / HistoryWriter::frame_file(index)},
               .run = {}};
  for (const fs::path& file : simulation::frame_map_files(work->file.scene, index))
    item.outputs.push_back("history" / file);
  item.run = [work, index](const fs::path& folder, const RunControl& control) {
    simulation::Simulation& simulation = work->composed(control);
    const HistoryFrame& frame = work->frames.frames[static_cast<std::size_t>(index)];
    simulation::read_frame_amounts(work->source / "history" / *frame.amounts, simulation);
    HistoryManifest manifest = work->frames;
    manifest.frames.clear();
    HistoryWriter(folder / "history", manifest)
        .write_frame(index, frame.time, simulation.compose(control).color_linear());
    simulation::write_frame_maps(folder / "history", index, simulation, control);
  };
  return item;
}

/// Frames are there; controls and mask are those of the source.
void write_history(const Recomposed& work, const std::string& key, const fs::path& folder) {
  HistoryManifest manifest = work.frames;
  manifest.key = key;
  manifest.frames.clear();
  manifest.controls.clear();
  manifest.mask.reset();
  HistoryWriter writer(folder, manifest);
  for (std::size_t i = 0; i < work.frames.frames.size(); ++i) {
    const auto index = static_cast<int>(i);
    writer.add_written_frame(index, work.frames.frames[i].time);
    for (const std::string& name : simulation::frame_map_names(work.file.scene))
      writer.add_written_frame_extra(index, name);
    writer.add_written_frame_amounts(index);
  }
  const HistoryReader source(work.source / "history");
  for (const ControlFacts& control : source.facts().controls) {
    ImageF values = source.read_control(control.name);
    for (float& v : values.values())
      v = static_cast<float>(control.low + static_cast<double>(v) * (control.high - control.low));
    writer.write_control(control.name, values, control.low, control.high, control.unit);
  }
  writer.write_mask(source.read_mask());
  writer.finish();
}

}  // namespace

int cmd_recompose(CommandRun& run) {
  fs::path folder, scene_path, output;
  std::vector<std::string> texts;
  RecomposeOptions options;
  device::DeviceOptions device;
  run.line.positional("SIMULATION", "A folder that `simulate` made", folder);
  run.line.output("FOLDER", "Folder to make: textures, model.glb and the history", output);
  run.line.repeated("set", "MATERIAL.WHAT=VALUE",
                    "A post-control: strength, variation, specular, specular_variation, height (mm), grain (mm) or "
                    "height_variation of a material",
                    texts);
  run.line.option("scene", "SCENE",
                  "A scene file whose appearance parameters to take; default: the one that was simulated", scene_path);
  run.line.options(options);
  run.line.options(device);
  run.line.example("recompose rust -o rust_pale --set rust.strength=0.5 --set rust.variation=0.8");
  if (!run.parse()) return 0;
  const auto simulation_device = open_simulation_device(device, run);
  const simulation::SimulationManifest manifest = simulation::read_simulation_manifest(folder);
  const fs::path source = manifest_folder(folder, "simulation.json");
  simulation::SceneFile file =
      simulation::read_scene(scene_path.empty() ? manifest.scene : scene_path, run.control("scene"));
  manifest.apply_to(file);
  if (file.scene.materials != manifest.materials) {
    throw IoError(file.file.string(), "has other materials than the simulation " + source.string());
  }
  JobInputs inputs("recompose", 2);
  inputs.add_file("atlas", source / "atlas.exr", source);
  const HistoryManifest frames = read_history_manifest(source / "history");
  for (const HistoryFrame& frame : frames.frames) {
    if (frame.amounts) inputs.add_file("frame " + number_text(frame.time), source / "history" / *frame.amounts, source);
  }
  inputs.add_content("scene", file.file.filename().string(), ContentHash().add(load_json(file.file).dump()).hex());
  for (const auto& [role, path] : file.inputs) {
    inputs.add_file(role, path, folder_of(file.file));
    if (!role.starts_with("mesh of ")) continue;
    for (const std::string& buffer : mesh_buffer_files(path))
      inputs.add_file("buffer of " + role, path.parent_path() / buffer, folder_of(file.file));
  }
  for (const std::string& text : texts) {
    apply_change(parse_change(text, manifest.materials), file.scene.appearance);
    inputs.add_value("--set " + text.substr(0, text.find('=')), text);
  }
  inputs.add_options(option_values(options));
  const auto work = std::make_shared<Recomposed>(
      Recomposed{source, std::move(file), options.color_form, simulation_device, frames, {}});
  JobPlan plan = inputs.plan(output, "recomposed.json");
  plan.parallel_items = false;
  for (std::size_t i = 0; i < frames.frames.size(); ++i) {
    if (frames.frames[i].amounts) plan.items.push_back(frame_item(work, static_cast<int>(i)));
  }
  plan.join = [&, work](const fs::path& made, const RunControl& control) {
    simulation::Simulation& simulation = work->composed(control.part(0.0, 0.5));
    simulation::read_atlas_file(source, simulation);
    simulation::write_composed_files(made, manifest.name, simulation, plan.key, control.part(0.5, 1.0));
    if (!plan.items.empty()) write_history(*work, plan.key, made / "history");
    save_json(made / "recomposed.json", Json{{"format", "patinate.recomposed"},
                                             {"version", 1},
                                             {"simulation", manifest.key},
                                             {"set", texts},
                                             {"key", plan.key}});
  };
  if (plan.items.empty())
    run.note(source.string() +
             " holds no amounts of its frames (made by an earlier version): its end alone is composed");
  const std::optional<JobStatus> status = run.make_folder(plan, "recompose");
  if (status) run.report_output(*status, output);
  return 0;
}

}  // namespace patinate::cli
