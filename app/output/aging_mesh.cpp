#include "app/output/aging_mesh.h"

#include <algorithm>
#include <utility>

#include "app/output/reduced_transfer.h"
#include "app/output/simulated_maps.h"
#include "app/request/path_kind.h"
#include "libcommon/core/files.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "simulation/job/simulation_job.h"

namespace patinate::app {

namespace {

/// Color and all other maps of the surface at a time; empty if the history has none that pictures show.
std::function<SurfaceMaps(double time, const RunControl& control)> surface_maps_of(
    const std::shared_ptr<const transfer::AgedMesh>& aged) {
  const std::vector<MaterialMap> maps = material_maps(aged->shown->facts());
  const auto has = [maps](MaterialMap map) { return std::find(maps.begin(), maps.end(), map) != maps.end(); };
  if (!has(MaterialMap::Normal) && !has(MaterialMap::Roughness) && !has(MaterialMap::Specular) &&
      !has(MaterialMap::Height) && !has(MaterialMap::Metalness))
    return {};
  return [aged, has](double time, const RunControl& control) {
    const History& history = *aged->shown;
    SurfaceMaps surface{.color = aged->gather_sheet(sample_base_color(history, time, Between::Blend), control)};
    const auto sample = [&](MaterialMap map, ImageF& into) {
      if (has(map)) into = aged->material_map(map, time, Between::Blend, control);
    };
    sample(MaterialMap::Normal, surface.normals);
    sample(MaterialMap::Roughness, surface.roughness);
    if (has(MaterialMap::Tint) && has(MaterialMap::Specular)) {
      surface.specular = aged->gather_sheet(sample_reflectance(history, time, Between::Blend), control);
    } else {
      sample(MaterialMap::Specular, surface.specular);
    }
    sample(MaterialMap::Metalness, surface.metalness);
    sample(MaterialMap::Height, surface.height);
    return surface;
  };
}

/// Texels that pictures of a transfer hold when it is too large to be held itself: 800 MB.
constexpr std::int64_t kReducedTexels = std::int64_t{1} << 26;

AgingMesh reduced_mesh_of_transfer(const std::shared_ptr<const transfer::TransferFolder>& transfer,
                                   std::int64_t most_texels) {
  const transfer::TransferManifest& m = transfer->manifest();
  const AtlasMesh atlas = transfer->read_atlas();
  AgingMesh mesh;
  mesh.key = m.key;
  mesh.history = transfer->history().manifest();
  mesh.tile_names = transfer->sheet().names;
  mesh.triangle_tile = atlas.triangle_tile;
  const std::int64_t most = std::min(most_texels, kReducedTexels);
  const Sheet reduced = reduced_sheet(transfer->sheet(), most);
  mesh.mesh = sheet_mesh(atlas, reduced);
  mesh.unit_mesh = unit_square_mesh(atlas);
  mesh.is_reduced = true;
  const auto made = std::make_shared<std::unique_ptr<const ReducedTransfer>>();  // For the first picture.
  mesh.sample = [transfer, most, made](double time, const RunControl& control) {
    if (!*made) *made = std::make_unique<const ReducedTransfer>(transfer, most, control.part(0.0, 0.4));
    return (*made)->sample(time, control.part(0.4, 1.0));
  };
  return mesh;
}

AgingMesh aging_mesh_of_simulation(const std::filesystem::path& path, const OutputDevices& devices, double film,
                                   std::optional<double> relief) {
  const std::filesystem::path folder = manifest_folder(path, "simulation.json");
  const auto history = std::make_shared<const HistoryReader>(folder / "history");
  AgingMesh mesh;
  mesh.key = simulation::read_simulation_manifest(path).key;
  mesh.history = history->manifest();
  mesh.tile_names = {""};
  mesh.mesh = with_normals(read_mesh(folder / "model.glb"));
  scale_mesh(mesh.mesh, 1000.0);  // glTF is in m
  mesh.unit_mesh = mesh.mesh;
  mesh.sample = [history](double time, const RunControl&) { return history->sample(time); };
  const auto made = std::make_shared<std::unique_ptr<SimulatedSurface>>();  // For the first picture that is not there.
  FlakeGround flakes;
  mesh.may_have_flakes = relief && may_have_flakes(folder / "history", mesh.history);
  if (mesh.may_have_flakes) flakes = {.mesh = std::make_shared<const Mesh>(mesh.mesh), .relief = *relief};
  mesh.maps = [folder, film, flakes, made, devices](double time, const RunControl& control) {
    if (!*made)
      *made = std::make_unique<SimulatedSurface>(folder, film, devices.compose(), flakes, control.part(0.0, 0.5));
    return (*made)->at(time, control.part(0.5, 1.0));
  };
  const bool has_course = std::all_of(mesh.history.frames.begin(), mesh.history.frames.end(),
                                      [](const HistoryFrame& frame) { return frame.amounts.has_value(); });
  mesh.maps_from = has_course ? mesh.history.frames.front().time : mesh.history.frames.back().time;
  return mesh;
}

}  // namespace

AgingMesh aging_mesh_of(const std::shared_ptr<const transfer::AgedMesh>& aged) {
  AgingMesh mesh;
  mesh.mesh = aged->mesh;
  if (aged->folder) {
    const transfer::TransferManifest& m = aged->folder->manifest();
    mesh.key = m.key;
    mesh.history = aged->folder->history().manifest();
    mesh.tile_names = aged->sheet().names;
    mesh.triangle_tile = aged->folder->atlas().triangle_tile;
    mesh.unit_mesh = unit_square_mesh(aged->folder->atlas());
  } else {
    const HistoryFacts& facts = aged->history->facts();
    mesh.history.name = facts.name;
    mesh.history.origin = facts.origin;
    mesh.history.time_unit = facts.time_unit;
    for (const FrameFacts& frame : facts.frames) mesh.history.frames.emplace_back().time = frame.time;
    mesh.tile_names = {""};
    mesh.unit_mesh = aged->mesh;
  }
  mesh.sample = [aged](double time, const RunControl& control) { return aged->texture(time, Between::Blend, control); };
  mesh.maps = surface_maps_of(aged);
  return mesh;
}

AgingMesh open_aging_mesh(const std::filesystem::path& path, const OutputDevices& devices, double film,
                          std::optional<double> relief, std::int64_t most_texels) {
  if (kind_of(path) == PathKind::Simulation) return aging_mesh_of_simulation(path, devices, film, relief);
  if (const auto folder = std::make_shared<const transfer::TransferFolder>(path);
      std::int64_t{folder->sheet().width()} * folder->sheet().height() > most_texels)
    return reduced_mesh_of_transfer(folder, most_texels);
  return aging_mesh_of(std::make_shared<const transfer::AgedMesh>(transfer::read_aged_mesh(path)));
}

}  // namespace patinate::app
