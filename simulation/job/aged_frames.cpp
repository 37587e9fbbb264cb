#include "simulation/job/aged_frames.h"

#include <utility>

namespace patinate::simulation {

namespace {

SimulationOptions with_maps(SimulationOptions options, const SceneFile& file) {
  options.parameter_maps = file.controls;
  return options;
}

}  // namespace

AgedFrames::AgedFrames(const SceneFile& file, SimulationOptions options, const RunControl& control)
    : simulation_(file.scene, with_maps(std::move(options), file), control.part(0.0, 0.1)) {
  const RunControl quiet = control.silent();
  const auto num_materials = static_cast<int>(file.scene.materials.size());
  const std::size_t num_layer_maps = simulation_.layer_map_names().size();
  while (true) {
    simulation_.apply_due(quiet);
    if (file.is_frame(simulation_.iteration())) {
      times_.push_back(file.frame_time(simulation_.iteration()));
      amounts_.emplace_back();
      for (int m = 0; m < num_materials; ++m) amounts_.back().push_back(simulation_.amounts(m));
      for (std::size_t k = 0; k < num_layer_maps; ++k) amounts_.back().push_back(simulation_.layer_map(k));
    }
    if (simulation_.iteration() >= file.iterations) break;
    control.throw_if_stopped();
    simulation_.step(quiet);
    control.report(0.1 + 0.9 * static_cast<double>(simulation_.iteration()) / static_cast<double>(file.iterations));
  }
  for (const std::string& name : file.controls)
    controls_.push_back(parameter_control(simulation_, name, file.time_unit));
}

std::vector<ImageF> AgedFrames::compose(const std::vector<MaterialAppearance>& appearance, const RunControl& control) {
  simulation_.set_appearance(appearance);
  std::vector<ImageF> frames;
  for (const std::vector<ImageF>& amounts : amounts_) {
    control.throw_if_stopped();
    const std::size_t num_materials = simulation_.scene().materials.size();
    for (std::size_t m = 0; m < num_materials; ++m) simulation_.set_amounts(static_cast<int>(m), amounts[m]);
    for (std::size_t k = num_materials; k < amounts.size(); ++k)
      simulation_.set_layer_map(k - num_materials, amounts[k]);
    frames.push_back(simulation_.compose(control).color_linear());
  }
  return frames;
}

}  // namespace patinate::simulation
