#include "simulation/job/recompose_job.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"
#include "simulation/files/scene_files.h"
#include "simulation/job/frame_maps.h"
#include "simulation/job/outcome_json.h"
#include "simulation/job/simulation_job.h"
#include "simulation/job/simulation_output.h"

namespace patinate::simulation {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kRecomposeVersion = 3;

struct LookNumber {
  std::string_view name;  ///< In scene files too.
  double MaterialAppearance::*field;
  Range range;
};
constexpr std::array kLookNumbers{LookNumber{"strength", &MaterialAppearance::strength, {0, 1000}},
                                  LookNumber{"variation", &MaterialAppearance::variation, {0, 1}},
                                  LookNumber{"specular", &MaterialAppearance::specular, {-1, 1}},
                                  LookNumber{"specular_variation", &MaterialAppearance::specular_variation, {0, 1}},
                                  LookNumber{"height", &MaterialAppearance::height_mm, {-1e6, 1e6}},
                                  LookNumber{"height_variation", &MaterialAppearance::height_variation, {0, 1}},
                                  LookNumber{"grain", &MaterialAppearance::grain_mm, {0, 1e9}}};

std::string change_name(const LookChange& change) { return change.material + "." + change.what; }
std::string change_text(const LookChange& change) { return change_name(change) + "=" + number_text(change.value); }

void apply(const LookChange& change, Scene& scene) {
  const auto material = std::find(scene.materials.begin(), scene.materials.end(), change.material);
  const auto number = std::find_if(kLookNumbers.begin(), kLookNumbers.end(),
                                   [&](const LookNumber& each) { return each.name == change.what; });
  if (material == scene.materials.end() || number == kLookNumbers.end() || !number->range.contains(change.value))
    throw InvalidInput(change_text(change) + ": no look of the scene has this");
  scene.appearance[material - scene.materials.begin()].*number->field = change.value;
}

/// Everything that the items of one job share: the simulation is made when it is first asked for.
struct RecomposeWork {
  fs::path source;
  SceneFile file;  ///< With the new look.
  RecomposeOptions options;
  HistoryManifest frames;   ///< Frames of the source.
  bool has_course = false;  ///< All of them have amounts.
  SceneCopy copy;
  Json record;  ///< The source's simulation.json.
  std::vector<std::string> changes;
  std::string key;
  std::unique_ptr<Simulation> made;

  Simulation& composed(const RunControl& control) {
    if (!made)
      made = std::make_unique<Simulation>(
          file.scene,
          SimulationOptions{.parameter_maps = {}, .color_form = options.color_form, .device = options.device}, control);
    return *made;
  }
};

JobItem frame_item(const std::shared_ptr<RecomposeWork>& work, int index) {
  JobItem item{.name = "frame-" + zero_padded(static_cast<std::uint64_t>(index), 4),
               .outputs = {"history" / HistoryWriter::frame_file(index)},
               .run = {}};
  for (const fs::path& file : frame_map_files(work->file.scene, index)) item.outputs.push_back("history" / file);
  item.run = [work, index](const fs::path& folder, const RunControl& control) {
    Simulation& simulation = work->composed(control);
    const HistoryFrame& frame = work->frames.frames[index];
    read_frame_amounts(work->source / "history" / *frame.amounts, simulation);
    HistoryManifest manifest = work->frames;
    manifest.frames.clear();
    HistoryWriter(folder / "history", manifest)
        .write_frame(index, frame.time, simulation.compose(control).color_linear());
    write_frame_maps(folder / "history", index, simulation, control);
  };
  return item;
}

/// Frames are there; controls and mask are those of the source.
void write_recomposed_history(const RecomposeWork& work, const fs::path& folder) {
  HistoryManifest manifest = work.frames;
  manifest.key = work.key;
  manifest.frames.clear();
  manifest.controls.clear();
  manifest.mask.reset();
  HistoryWriter writer(folder, manifest);
  for (std::size_t i = 0; i < work.frames.frames.size(); ++i) {
    const auto index = static_cast<int>(i);
    writer.add_written_frame(index, work.frames.frames[i].time);
    for (const std::string& name : frame_map_names(work.file.scene)) writer.add_written_frame_extra(index, name);
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

/// Copies what does not depend on the look.
void copy_from_source(const RecomposeWork& work, const fs::path& folder) {
  for (const char* name : {"atlas.exr", "controls"}) {
    std::error_code error;
    fs::copy(work.source / name, folder / name, fs::copy_options::recursive | fs::copy_options::overwrite_existing,
             error);
    if (error)
      throw CannotComplete((folder / name).string() + ": cannot be copied from " + work.source.string() + "; " +
                           error.message());
  }
}

/// Outcome of the new look; where gammatons never were is as it was.
Json new_outcome(const RecomposeWork& work, Simulation& simulation, const fs::path& folder, const RunControl& control) {
  std::vector<ObjectOutcome> outcome = outcome_of(simulation, first_color(folder), control);
  const Json& before = work.record.at("outcome").at("objects");
  for (ObjectOutcome& object : outcome) {
    if (before.contains(object.object) && before[object.object].contains("never_met_share"))
      object.never_met_share = before[object.object]["never_met_share"].get<double>();
  }
  return outcome_json(outcome);
}

void write_manifest(const RecomposeWork& work, Simulation& simulation, const fs::path& folder,
                    const RunControl& control) {
  Json json = work.record;
  json["scene"] = (kSceneFolder / work.copy.name).generic_string();
  json["scene_files"] = Json::object();
  for (const auto& [name, key] : scene_file_keys(folder, work.copy)) json["scene_files"][name] = key;
  json["color_form"] = kColorFormNames[static_cast<std::size_t>(work.options.color_form)];
  if (json.contains("outcome")) json["outcome"] = new_outcome(work, simulation, folder, control);
  json.erase("outside");
  if (!work.copy.excluded.empty()) json["outside"] = work.copy.excluded;
  json["key"] = work.key;
  save_json(folder / "simulation.json", json);
}

void join_recomposed(RecomposeWork& work, const fs::path& folder, const RunControl& control) {
  Simulation& simulation = work.composed(control.part(0.0, 0.5));
  read_atlas_file(work.source, simulation);
  write_composed_files(folder, work.record.at("name").get<std::string>(), simulation, work.key, control.part(0.5, 0.9));
  if (work.has_course) {
    write_recomposed_history(work, folder / "history");
    copy_from_source(work, folder);
    write_scene_copy(work.copy, folder / kSceneFolder);
    write_manifest(work, simulation, folder, control.part(0.9, 1.0));
  }
  save_json(folder / "recomposed.json", Json{{"format", "patinate.recomposed"},
                                             {"version", 1},
                                             {"simulation", work.record.at("key")},
                                             {"set", work.changes},
                                             {"key", work.key}});
}

/// The scene as its file says it, with the changes.
Json changed_scene(const SceneFile& scene, const std::vector<LookChange>& changes) {
  Json root = load_json(scene.file);
  for (const LookChange& change : changes) root["appearance"][change.material][change.what] = change.value;
  return root;
}

JobInputs recompose_inputs(const RecomposeWork& work, const std::vector<LookChange>& changes) {
  const SceneFile& scene = work.file;
  JobInputs inputs("recompose", kRecomposeVersion);
  inputs.add_file("atlas", work.source / "atlas.exr", work.source);
  for (const HistoryFrame& frame : work.frames.frames) {
    if (frame.amounts)
      inputs.add_file("frame " + number_text(frame.time), work.source / "history" / *frame.amounts, work.source);
  }
  inputs.add_content("scene", scene.file.filename().string(), ContentHash().add(load_json(scene.file).dump()).hex());
  for (const auto& [role, path] : scene.inputs) {
    inputs.add_file(role, path, folder_of(scene.file));
    if (!role.starts_with("mesh of ")) continue;
    for (const std::string& buffer : mesh_buffer_files(path))
      inputs.add_file("buffer of " + role, path.parent_path() / buffer, folder_of(scene.file));
  }
  for (const LookChange& change : changes) inputs.add_value("--set " + change_name(change), change_text(change));
  inputs.add_value("--color-form", std::string(kColorFormNames[static_cast<std::size_t>(work.options.color_form)]));
  return inputs;
}

}  // namespace

void describe(OptionVisitor& v, RecomposeOptions& o) {
  v.visit_choice({"color_form", "How colors mix: normalized weights, the published shader or the printed equation"},
                 o.color_form, kColorFormNames);
}

const std::vector<std::string>& look_numbers() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const LookNumber& number : kLookNumbers) all.emplace_back(number.name);
    return all;
  }();
  return names;
}

LookChange parse_look_change(std::string_view text, const std::vector<std::string>& materials) {
  const auto fail = [&](const std::string& expected) {
    return InvalidInput("found `" + std::string(text) + "`; expected " + expected);
  };
  const std::size_t equals = text.find('='), dot = text.rfind('.', equals);
  if (equals == std::string_view::npos || dot == std::string_view::npos)
    throw fail("MATERIAL.WHAT=VALUE, such as rust.strength=0.5");
  LookChange change{.material = std::string(text.substr(0, dot)),
                    .what = std::string(text.substr(dot + 1, equals - dot - 1))};
  if (std::find(materials.begin(), materials.end(), change.material) == materials.end())
    throw fail("a material of the simulation" + did_you_mean(change.material, materials));
  const auto number = std::find_if(kLookNumbers.begin(), kLookNumbers.end(),
                                   [&](const LookNumber& each) { return each.name == change.what; });
  if (number == kLookNumbers.end())
    throw fail("strength, variation, specular, specular_variation, height, height_variation or grain" +
               did_you_mean(change.what, look_numbers()));
  const std::optional<double> value = parse_number(std::string(text.substr(equals + 1)));
  if (!value || !number->range.contains(*value)) throw fail("a number in " + number->range.text());
  change.value = *value;
  return change;
}

JobPlan plan_recompose(const fs::path& source, SceneFile scene, const std::vector<LookChange>& changes,
                       const RecomposeOptions& options, const fs::path& output) {
  auto work = std::make_shared<RecomposeWork>();
  work->source = manifest_folder(source, "simulation.json");
  const SimulationManifest manifest = read_simulation_manifest(source);
  work->record = load_json(work->source / "simulation.json");
  work->frames = read_history_manifest(work->source / "history");
  work->has_course = std::all_of(work->frames.frames.begin(), work->frames.frames.end(),
                                 [](const HistoryFrame& frame) { return frame.amounts.has_value(); });
  manifest.apply_to(scene);
  if (scene.scene.materials != manifest.materials)
    throw IoError(scene.file.string(), "has other materials than the simulation " + work->source.string());
  for (const LookChange& change : changes) apply(change, scene.scene);
  for (const LookChange& change : changes) work->changes.push_back(change_text(change));
  work->file = std::move(scene);
  work->options = options;
  work->copy = plan_scene_copy(work->file.file, changed_scene(work->file, changes), output / kSceneFolder);
  const JobInputs inputs = recompose_inputs(*work, changes);
  work->key = inputs.key();
  JobPlan plan = inputs.plan(output, "recomposed.json");
  plan.parallel_items = false;
  for (std::size_t i = 0; work->has_course && i < work->frames.frames.size(); ++i)
    plan.items.push_back(frame_item(work, static_cast<int>(i)));
  plan.join = [work](const fs::path& folder, const RunControl& control) { join_recomposed(*work, folder, control); };
  return plan;
}

}  // namespace patinate::simulation
