#include "simulation/job/simulation_job.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/job/job_record.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "simulation/files/scene_files.h"
#include "simulation/job/frame_maps.h"
#include "simulation/job/simulation_output.h"

namespace patinate::simulation {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 6;           ///< Raised when the same scene gives other amounts or maps.
constexpr std::int64_t kMaxIterationsAnItem = 200;  ///< At most this many are lost by a kill.

/// Everything that the items of one job share: the running simulation goes from item to item in memory, and a file
/// stands in for it after a kill.
struct SimulationWork {
  SceneFile file;
  SceneCopy copy;
  SimulationOptions options;
  std::string key;
  bool has_set_amounts = false;
  std::unique_ptr<Simulation> simulation;

  [[nodiscard]] static fs::path checkpoint_file() { return fs::path(kJobWorkFolder) / "checkpoint.bin"; }
  [[nodiscard]] static fs::path checkpoint(const fs::path& folder) { return folder / checkpoint_file(); }

  /// The simulation after at most `begin` iterations, from memory, the checkpoint or the start.
  Simulation& at(std::int64_t begin, std::int64_t end, const fs::path& folder, const RunControl& control) {
    if (simulation && simulation->iteration() >= begin && simulation->iteration() <= end) return *simulation;
    simulation = std::make_unique<Simulation>(file.scene, options, control.part(0.0, 0.1));
    std::error_code error;
    if (begin > 0 && fs::is_regular_file(checkpoint(folder), error)) {
      try {
        const std::string bytes = read_file(checkpoint(folder), std::uint64_t{1} << 36);
        simulation->restore(std::as_bytes(std::span(bytes)));
      } catch (const InputError&) {  // half-written or foreign: from the start, which takes longer and gives the same
        simulation = std::make_unique<Simulation>(file.scene, options, control.part(0.0, 0.1));
      }
      if (simulation->iteration() > end)
        simulation = std::make_unique<Simulation>(file.scene, options, control.part(0.0, 0.1));
    }
    return *simulation;
  }

  void save(const fs::path& folder) const {
    const std::vector<std::byte> bytes = simulation->snapshot();
    fs::create_directories(checkpoint(folder).parent_path());
    write_atomically(checkpoint(folder), std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
};

[[nodiscard]] int frame_index(const SceneFile& file, std::int64_t iteration) {
  return static_cast<int>((iteration + file.history_every - 1) / file.history_every);
}

/// Iterations at which items end: every frame, and between frames that are far apart.
[[nodiscard]] std::vector<std::int64_t> item_ends(const SceneFile& file) {
  std::vector<std::int64_t> ends{0};
  while (ends.back() < file.iterations) {
    const std::int64_t next_frame = (ends.back() / file.history_every + 1) * file.history_every;
    ends.push_back(std::min({ends.back() + kMaxIterationsAnItem, next_frame, file.iterations}));
  }
  return ends;
}

HistoryManifest history_manifest(const SimulationWork& work, const Simulation& simulation) {
  HistoryManifest m;
  m.name = work.file.name;
  m.origin = "simulated";
  m.width = m.height = work.file.scene.resolution;
  m.texel_size_mm = simulation.texel_size_mm();
  m.time_unit = work.file.time_unit;
  m.key = work.key;
  return m;
}

/// The scene as it was simulated, so that the folder needs nothing outside.
JobItem scene_item(const std::shared_ptr<SimulationWork>& work) {
  JobItem item;
  item.name = "scene";
  item.outputs = {fs::path(kSceneFolder) / work->copy.name};
  for (const SceneCopy::File& file : work->copy.files) item.outputs.push_back(fs::path(kSceneFolder) / file.to);
  item.run = [work](const fs::path& folder, const RunControl& control) {
    write_scene_copy(work->copy, folder / kSceneFolder);
    control.report(1.0);
  };
  return item;
}

JobItem make_item(const std::shared_ptr<SimulationWork>& work, std::int64_t begin, std::int64_t end, int stage) {
  JobItem item;
  item.name = "iterations-" + zero_padded(static_cast<std::uint64_t>(end), 8);
  item.stage = stage;
  const bool has_frame = work->file.is_frame(end);
  if (has_frame) {
    const int index = frame_index(work->file, end);
    item.outputs = {fs::path("history") / HistoryWriter::frame_file(index)};
    for (const fs::path& file : frame_map_files(work->file.scene, index)) item.outputs.push_back("history" / file);
  }
  item.run = [work, begin, end, has_frame](const fs::path& folder, const RunControl& control) {
    Simulation& simulation = work->at(begin, end, folder, control);
    const std::int64_t first = simulation.iteration();
    const RunControl quiet = control.silent();
    while (simulation.iteration() < end) {
      simulation.step(quiet);
      control.report(0.1 +
                     0.8 * static_cast<double>(simulation.iteration() - first) / static_cast<double>(end - first));
    }
    simulation.apply_due(quiet);  // a stroke takes no time: it is in the picture of its iteration
    if (has_frame) {
      HistoryWriter writer(folder / "history", history_manifest(*work, simulation));
      writer.write_frame(frame_index(work->file, end), work->file.frame_time(end),
                         simulation.compose(quiet).color_linear());
      write_frame_maps(folder / "history", frame_index(work->file, end), simulation, quiet);
    }
    work->save(folder);
    control.report(1.0);
  };
  return item;
}

void write_simulated_history(const SimulationWork& work, const Simulation& simulation, const fs::path& folder,
                             const std::vector<ParameterControl>& controls) {
  HistoryWriter writer(folder / "history", history_manifest(work, simulation));
  for (const std::int64_t end : item_ends(work.file)) {
    if (!work.file.is_frame(end)) continue;
    const int index = frame_index(work.file, end);
    writer.add_written_frame(index, work.file.frame_time(end));
    for (const std::string& name : frame_map_names(work.file.scene)) writer.add_written_frame_extra(index, name);
    writer.add_written_frame_amounts(index);
  }
  for (const ParameterControl& c : controls) {
    ImageF physical = c.values;
    for (float& v : physical.values()) v = static_cast<float>(static_cast<double>(v) * c.high);
    writer.write_control(c.name, physical, c.low, c.high, c.unit);
  }
  writer.write_mask(simulation.coverage());
  writer.finish();
}

std::vector<std::string> object_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneObject& object : scene.objects) names.push_back(object.name);
  return names;
}

void join_simulated(SimulationWork& work, const fs::path& folder, const RunControl& control) {
  const SceneFile& file = work.file;
  Simulation& simulation = work.at(file.iterations, file.iterations, folder, control.part(0.0, 0.1));
  const RunControl quiet = control.silent();
  while (simulation.iteration() < file.iterations) simulation.step(quiet);  // only when a checkpoint was lost
  simulation.apply_due(quiet);
  if (const std::string wrong = work.has_set_amounts ? "" : simulation.audit(quiet); !wrong.empty())
    throw CannotComplete("the mass balance is violated: " + wrong);
  write_atlas_file(folder, simulation);
  write_state_file(folder, simulation);
  control.report(0.4);
  write_composed_files(folder, file.name, simulation, work.key, control.part(0.4, 0.8));
  std::vector<SimulatedControl> listed;
  std::vector<ParameterControl> controls;
  fs::create_directories(folder / "controls");
  for (const std::string& name : file.controls) {
    controls.push_back(parameter_control(simulation, name, file.time_unit));
    const ParameterControl& c = controls.back();
    const fs::path path = fs::path("controls") / (name + ".exr");
    write_scaled_exr(folder / path, c.values, {c.low, c.high, c.unit});
    listed.push_back({name, path, c.low, c.high, c.unit, write_object_controls(folder, simulation, c)});
  }
  write_simulated_history(work, simulation, folder, controls);
  save_simulation_manifest(folder, {.name = file.name,
                                    .scene = kSceneFolder / work.copy.name,
                                    .scene_files = scene_file_keys(folder, work.copy),
                                    .iterations = file.iterations,
                                    .time = file.frame_time(file.iterations),
                                    .time_unit = file.time_unit,
                                    .resolution = file.scene.resolution,
                                    .seed = file.scene.seed,
                                    .texel_size_mm = simulation.texel_size_mm(),
                                    .objects = object_names(file.scene),
                                    .materials = file.scene.materials,
                                    .color_form = work.options.color_form,
                                    .counters = simulation.counters(),
                                    .ledger = ledger_rows(simulation.ledger(), file.scene.materials),
                                    .layers = layer_rows(simulation),
                                    .outcome = outcome_of(simulation, first_color(folder), quiet),
                                    .atlas_hash = simulation.state_hash(),
                                    .controls = listed,
                                    .key = work.key,
                                    .outside = work.copy.excluded});
  control.report(1.0);
}

JobInputs simulation_inputs(const SceneFile& file, const SimulationOptions& options) {
  JobInputs inputs("simulate", kStageVersion);
  ContentHash scene;
  scene.add(load_json(file.file).dump());
  inputs.add_content("scene", file.file.filename().string(), scene.hex());
  for (const auto& [role, path] : file.inputs) {
    inputs.add_file(role, path, folder_of(file.file));
    if (!role.starts_with("mesh of ")) continue;
    for (const std::string& buffer : mesh_buffer_files(path))
      inputs.add_file("buffer of " + role, path.parent_path() / buffer, folder_of(file.file));
  }
  inputs.add_value("--iterations", std::to_string(file.iterations));
  inputs.add_value("--history-every", std::to_string(file.history_every));
  inputs.add_value("--seed", std::to_string(file.scene.seed));
  inputs.add_value("--resolution", std::to_string(file.scene.resolution));
  inputs.add_value("--color-form", std::string(kColorFormNames[static_cast<std::size_t>(options.color_form)]));
  std::string controls;
  for (const std::string& name : file.controls) controls += (controls.empty() ? "" : ", ") + name;
  inputs.add_value("--controls", controls);
  return inputs;
}

}  // namespace

namespace {

/// The plan of the scene, with `ends` for where its stretches end. @param inputs  Of the scene and what else counts.
JobPlan plan_stretches(const std::shared_ptr<SimulationWork>& work, const JobInputs& inputs, const fs::path& output,
                       const std::vector<std::int64_t>& ends) {
  work->options.parameter_maps = work->file.controls;
  work->key = inputs.key();
  work->copy = plan_scene_copy(work->file.file, load_json(work->file.file), output / kSceneFolder);
  JobPlan plan = inputs.plan(output, "simulation.json");
  plan.parallel_items = false;
  plan.shared_work = {SimulationWork::checkpoint_file()};
  std::int64_t begin = 0;
  int stage = 0;
  plan.items.push_back(scene_item(work));
  for (const std::int64_t end : ends) {
    plan.items.push_back(make_item(work, begin, end, ++stage));
    begin = end;
  }
  plan.join = [work](const fs::path& folder, const RunControl& control) { join_simulated(*work, folder, control); };
  return plan;
}

}  // namespace

JobPlan plan_simulation(SceneFile scene, const SimulationOptions& options, const fs::path& output) {
  auto work = std::make_shared<SimulationWork>();
  work->file = std::move(scene);
  work->options = options;
  return plan_stretches(work, simulation_inputs(work->file, options), output, item_ends(work->file));
}

JobPlan plan_saved_simulation(SceneFile scene, const SimulationOptions& options, SimulationState state,
                              const fs::path& output) {
  auto work = std::make_shared<SimulationWork>();
  work->file = std::move(scene);
  work->file.iterations = state.iteration;
  work->file.history_every = std::max<std::int64_t>(1, state.iteration);
  work->options = options;
  work->has_set_amounts = state.has_set_amounts;
  JobInputs inputs = simulation_inputs(work->file, options);
  if (state.is_changed_by_hand) {
    ContentHash snapshot;
    snapshot.add(std::span<const std::byte>(state.snapshot));
    inputs.add_content("state", kChangedByHand, snapshot.hex());
  }
  std::vector<std::int64_t> ends{0};
  if (state.iteration > 0) ends.push_back(state.iteration);
  JobPlan plan = plan_stretches(work, inputs, output, ends);
  plan.items.back().run = [work, state = std::move(state), run = plan.items.back().run](const fs::path& folder,
                                                                                        const RunControl& control) {
    work->simulation = std::make_unique<Simulation>(work->file.scene, work->options, control.part(0.0, 0.1));
    work->simulation->restore(state.snapshot);
    run(folder, control);
  };
  return plan;
}

namespace {

/// Changed files of the scene that the folder holds.
std::string changed_files(const SimulationManifest& manifest) {
  std::string names;
  for (const auto& [name, key] : manifest.scene_files) {
    const fs::path file = manifest.scene.parent_path() / name;
    std::error_code error;
    if (!fs::is_regular_file(file, error) || hash_file(file) != key)
      names += (names.empty() ? "" : ", ") + (fs::path(kSceneFolder) / name).generic_string();
  }
  return names;
}

}  // namespace

std::string changed_inputs(const fs::path& path, const SceneFile& scene) {
  const fs::path folder = manifest_folder(path, "simulation.json");
  const SimulationManifest manifest = read_simulation_manifest(folder);
  if (!manifest.scene_files.empty()) return changed_files(manifest);
  const JobRecord record = read_job_record(folder, manifest.key);
  if (record.key.empty()) return "what it was made from";
  std::string names;
  for (const JobChange& change : changes_between(record.depends_on, simulation_inputs(scene, {}).list())) {
    if (change.name.starts_with("--")) continue;
    names += (names.empty() ? "" : ", ") + change.name;
  }
  return names;
}

}  // namespace patinate::simulation
