/// \file
/// A simulation as a job: killed, it resumes from its last checkpoint; the folder is whole or absent.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/job/job.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"
#include "simulation/job/layer_rows.h"
#include "simulation/job/outcome.h"
#include "simulation/tracing/gammatons.h"
#include "simulation/transport/ledger_json.h"

namespace patinate::simulation {

/// The folder of formats.md: simulation.json, scene/ (the scene with what it names), state.bin, atlas.exr, color.png,
/// normal.png, height.exr, specular.png, model.glb, controls/, history/. Items are stretches of iterations that end at
/// frames of the history (and after 200 iterations at the latest); what is done in one lies in a checkpoint, so that a
/// killed run loses at most one stretch.
[[nodiscard]] JobPlan plan_simulation(SceneFile scene, const SimulationOptions& options,
                                      const std::filesystem::path& output);

/// Name of what a saved simulation depends on if it was changed by more than its steps.
inline constexpr const char* kChangedByHand = "what was done by hand";

/// A running simulation as it is now.
struct SimulationState {
  std::int64_t iteration = 0;
  std::vector<std::byte> snapshot;  ///< Simulation::snapshot().
  bool is_changed_by_hand = false;  ///< By more than its steps: strokes, events, amounts that were set.
  bool has_set_amounts = false;     ///< The ledger does not describe these amounts (Simulation::set_amounts()).
};
/// The folder of `patinate simulate` with `state.iteration` iterations and frames at both ends; the same bytes unless
/// it was changed by hand. @param scene  That it was made from, whose file can be read again.
[[nodiscard]] JobPlan plan_saved_simulation(SceneFile scene, const SimulationOptions& options, SimulationState state,
                                            const std::filesystem::path& output);

/// A parameter map of a finished folder.
struct SimulatedControl {
  std::string name;
  std::filesystem::path file;  ///< From the folder.
  double low = 0.0, high = 1.0;
  std::string unit = {};
  Named<std::filesystem::path> objects = {};  ///< Of several objects: on the UVs of each.
};

/// simulation.json.
struct SimulationManifest {
  std::string name;
  std::filesystem::path
      scene;  ///< The scene file: the folder's own; in folders of earlier versions the one that the user gave.
  Named<std::string> scene_files;  ///< Files of the folder's own scene, from its folder, and keys of their bytes; empty
                                   ///< when it has none.
  std::int64_t iterations = 0;
  double time = 0.0;
  TimeUnit time_unit = TimeUnit::Seconds;
  int resolution = 0;
  std::optional<std::uint64_t> seed;  ///< That was used; folders of earlier versions do not say.
  double texel_size_mm = 0.0;
  std::vector<std::string> objects, materials;
  ColorForm color_form = ColorForm::Normalized;
  TraceCounters counters;
  Named<LedgerRow> ledger;
  std::vector<LayerRow> layers;
  std::vector<ObjectOutcome> outcome;  ///< Is not read.
  std::string atlas_hash;
  std::vector<SimulatedControl> controls;
  std::string key;
  std::vector<std::string> outside;  ///< Files of the scene that stay where they are.

  [[nodiscard]] std::vector<std::string> control_names() const;
  /// The scene as it was run: with what the command line said in place of the file.
  void apply_to(SceneFile& file) const;
};
void save_simulation_manifest(const std::filesystem::path& folder, SimulationManifest manifest);
/// @param path  A simulation folder, or its simulation.json. @throws IoError
[[nodiscard]] SimulationManifest read_simulation_manifest(const std::filesystem::path& path);
[[nodiscard]] Json simulation_schema();
/// What of a finished folder's inputs is not as it was ("scene.json", "urn/mesh.obj"), "" if all is; lengths of the run
/// do not count. Of a folder that holds its scene, what of that is not as it was written.
/// @param path  The folder, or its simulation.json. @param scene  Its scene file, read again.
[[nodiscard]] std::string changed_inputs(const std::filesystem::path& path, const SceneFile& scene);

}  // namespace patinate::simulation
