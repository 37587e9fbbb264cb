#include <array>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/history/history_documents.h"
#include "patinate/core/error.h"
#include "simulation/job/outcome_json.h"
#include "simulation/job/simulation_job.h"

namespace patinate::simulation {

namespace fs = std::filesystem;

namespace {

constexpr DocumentKind kSimulationDocument{.format = "patinate.simulation",
                                           .version = 2,
                                           .title = "patinate simulation",
                                           .about = "simulation.json: what a simulation folder holds."};

}  // namespace

void describe(DocumentVisitor& v, SimulatedControl& c) {
  std::array<double, 2> range{c.low, c.high};
  v.member({.name = "name", .rule = &file_name_rule()}, c.name);
  v.member({"file"}, c.file);
  v.member({"range", "What 0 and 1 stand for."}, range);
  c.low = range[0], c.high = range[1];
  v.member({"unit"}, c.unit);
  v.member(if_set("objects", "Of a scene with several objects: the same map on each object's own UVs, by its name."),
           c.objects);
}

void describe(DocumentVisitor& v, TraceCounters& c) {
  for (const auto& [name, value] : {std::pair("emitted", &c.emitted),
                                    {"absorbed", &c.absorbed},
                                    {"left", &c.left},
                                    {"rested", &c.rested},
                                    {"alive", &c.alive},
                                    {"segments", &c.segments},
                                    {"contacts", &c.contacts}})
    v.member({name, "", at_least(0), Presence::Optional}, *value);
}

void describe(DocumentVisitor& v, SimulationManifest& m) {
  const auto may_lack = [](std::string_view name, std::string_view help, Range range = {}) {
    return Member{name, help, range, Presence::Optional};
  };
  v.member({"name", "Of the scene."}, m.name);
  v.member({"scene", "The scene file: a copy in the folder, or in folders of earlier versions the one that was given."},
           m.scene);
  v.member(may_lack("scene_files", "Files of the folder's own scene, relative to it, and content keys."),
           m.scene_files);
  v.member({"iterations", "Done.", at_least(0)}, m.iterations);
  v.member({"time", "At the end.", at_least(0)}, m.time);
  v.choice({"time_unit", "Of time and of the rules' rates."}, m.time_unit, kTimeUnitNames);
  v.member({"resolution", "Texels along each side.", between(16, 16384)}, m.resolution);
  v.member(if_set("seed", "That was used.", at_least(0)), m.seed);
  v.member(may_lack("texel_size_mm", "Median.", at_least(0)), m.texel_size_mm);
  v.member(may_lack("objects", "Names of the scene's objects, which share the atlas."), m.objects);
  v.member({.name = "materials", .max_size = kMaxMaterials}, m.materials);
  v.choice({"color_form", "How colors were mixed."}, m.color_form, kColorFormNames);
  v.member(may_lack("counters", "Gammatons. emitted = absorbed + left + rested + alive."), m.counters);
  v.member(may_lack("ledger",
                    "Mass by material: emitted + made = on_surfaces + carried + absorbed + rested + left + used, "
                    "exactly."),
           m.ledger);
  v.member(if_set("layers", "What became of the objects' layers."), m.layers);
  v.object(may_lack("outcome", "What the run has done. Means and shares are of the surface's area."), true,
           [&] { describe_outcome(v, m.outcome); });
  v.member(may_lack("atlas_hash", "Of all amounts, and of layers: equal for equal states."), m.atlas_hash);
  v.member({.name = "controls", .help = "Parameter maps.", .max_size = 100}, m.controls);
  v.member({"key", "Content key: of all that this was made from."}, m.key);
  v.member(if_set("outside", "Files of the scene that are too large to be kept here and stay where they are."),
           m.outside);
}

void save_simulation_manifest(const fs::path& folder, SimulationManifest m) {
  save_json(folder / "simulation.json", document_json(kSimulationDocument, described(m)));
}

SimulationManifest read_simulation_manifest(const fs::path& path) {
  const fs::path folder = manifest_folder(path, "simulation.json");
  if (!fs::is_directory(folder)) throw IoError(path.string(), "is no simulation folder");
  Json root = load_json(folder / "simulation.json");
  update_spelling(root, 1, {{"normalised", "normalized"}});
  SimulationManifest m;
  read_document(kSimulationDocument, folder / "simulation.json", root, described(m));
  m.scene = folder / m.scene;
  return m;
}

Json simulation_schema() { return document_schema(kSimulationDocument, described<SimulationManifest>()); }

std::vector<std::string> SimulationManifest::control_names() const {
  std::vector<std::string> names;
  for (const SimulatedControl& c : controls) names.push_back(c.name);
  return names;
}

void SimulationManifest::apply_to(SceneFile& file) const {
  file.scene.resolution = resolution;
  if (seed) file.scene.seed = *seed;
  file.iterations = iterations;
  file.controls = control_names();
}

}  // namespace patinate::simulation
