#include "app/output/simulated_maps.h"

#include <algorithm>
#include <utility>

#include "app/output/simulated_flakes.h"
#include "libcommon/core/files.h"
#include "patinate/atlas/dilate.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/simulation/scene_io.h"
#include "simulation/job/frame_maps.h"
#include "simulation/job/simulation_job.h"
#include "simulation/job/simulation_output.h"

namespace patinate::app {

namespace {

constexpr float kMinRoughness = 0.05f;  // Least roughness in the GLB that `simulate` writes, too.

ImageF decoded_normals(const ImageU8& codes) {
  ImageF normals(codes.width(), codes.height(), 3);
  for (std::size_t i = 0; i < normals.values().size(); ++i)
    normals.values()[i] = (static_cast<float>(codes.values()[i]) - 127.5f) / 127.5f;
  return normals;
}

ImageF roughness_of(const ImageU8& gloss) {
  ImageF roughness(gloss.width(), gloss.height());
  for (std::size_t i = 0; i < roughness.values().size(); ++i)
    roughness.values()[i] = std::max(kMinRoughness, 1.0f - static_cast<float>(gloss.values()[i]) / 255.0f);
  return roughness;
}

}  // namespace

bool may_have_flakes(const std::filesystem::path& history, const HistoryManifest& frames) {
  const std::optional<std::filesystem::path>& amounts = frames.frames.back().amounts;
  if (!amounts) return false;
  const std::vector<std::string> channels = probe_image(history / *amounts).channels;
  return std::any_of(channels.begin(), channels.end(),
                     [](const std::string& name) { return name.starts_with("layer") && name.ends_with(".crack"); });
}

SimulatedSurface::SimulatedSurface(const std::filesystem::path& folder, std::optional<double> film,
                                   std::shared_ptr<const simulation::SimulationDevice> device, FlakeGround flakes,
                                   const RunControl& control)
    : folder_(manifest_folder(folder, "simulation.json")), film_(film), flakes_(std::move(flakes)) {
  const simulation::SimulationManifest manifest = simulation::read_simulation_manifest(folder);
  simulation::SceneFile file = simulation::read_scene(manifest.scene, control.part(0.0, 0.4));
  manifest.apply_to(file);
  if (file.scene.materials != manifest.materials)
    throw IoError(file.file.string(), "has other materials than the simulation " + folder.string());
  if (film) file.scene.appearance = simulation::looks_below_film(file.scene, std::move(file.scene.appearance));
  frames_ = read_history_manifest(folder_ / "history");
  has_course_ = std::all_of(frames_.frames.begin(), frames_.frames.end(),
                            [](const HistoryFrame& frame) { return frame.amounts.has_value(); });
  simulation_ = std::make_unique<simulation::Simulation>(
      std::move(file.scene),
      simulation::SimulationOptions{
          .parameter_maps = {}, .color_form = manifest.color_form, .device = std::move(device)},
      control.part(0.4, 1.0));
}

SurfaceMaps SimulatedSurface::at(double time, const RunControl& control) {
  simulation::Simulation& simulation = *simulation_;
  if (!has_course_ || time >= frames_.frames.back().time) {
    simulation::read_atlas_file(folder_, simulation);
  } else {
    simulation::read_frame_amounts(folder_ / "history", frames_, time, simulation);
  }
  const auto compose = [this](const RunControl& part) { return composed(part); };
  if (!flakes_.mesh) return compose(control);
  const auto map = [this]() -> const TexelMap& {
    const ImageU8 coverage = simulation_->coverage();
    if (!map_) map_.emplace(*flakes_.mesh, coverage.width(), coverage.height());
    return *map_;
  };
  return maps_and_flakes(simulation, compose, map, flakes_.relief, control);
}

SurfaceMaps SimulatedSurface::composed(const RunControl& control) {
  simulation::Simulation& simulation = *simulation_;
  const simulation::Scene& scene = simulation.scene();
  const simulation::Composer& look = simulation.compose(control);
  const int water = simulation::film_material(scene), plant = simulation::plant_material(scene);
  SurfaceMaps maps{.color = look.color_linear(),
                   .normals = decoded_normals(look.normal8()),
                   .roughness = roughness_of(look.specular8()),
                   .metalness = simulation::metalness_of(simulation),
                   .height = look.height_mm()};
  if (!maps.metalness.empty()) dilate(maps.metalness, simulation.coverage(), -1);
  if (film_ && water >= 0) {
    maps.wetness = simulation.amounts(water);
    for (float& w : maps.wetness.values()) w = std::min(1.0f, w / static_cast<float>(*film_));
    dilate(maps.wetness, simulation.coverage(), -1);
  }
  if (plant >= 0) {
    maps.plants = simulation.amounts(plant);
    dilate(maps.plants, simulation.coverage(), -1);
  }
  return maps;
}

}  // namespace patinate::app
