#include "simulation/job/estimate.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace patinate::simulation {

namespace {

constexpr int kResolution = 192;      ///< Texels along the coarse atlas of --estimate.
constexpr double kMaxContacts = 4e6;  ///< Contacts of all iterations: a few seconds.
constexpr double kMaxCarried = 16.0;  ///< Emitter::carries.

/// How many gammatons stand for an emitter's, and by how much more each carries.
struct Thinning {
  std::int64_t gammatons = 1;
  double load = 1.0;
};

Thinning thinned(const Emitter& emitter, double share, double more_load) {
  Thinning t;
  const double wanted = share * static_cast<double>(emitter.gammatons);
  t.gammatons = std::max<std::int64_t>(1, std::llround(wanted));
  double largest = 0.0;
  for (const double c : emitter.carries) largest = std::max(largest, c);
  t.load = more_load * wanted / static_cast<double>(t.gammatons);
  if (largest > 0.0) t.load = std::min(t.load, kMaxCarried / largest);
  return t;
}

void thin(Emitter& emitter, double share, double more_load) {
  const Thinning t = thinned(emitter, share, more_load);
  emitter.gammatons = t.gammatons;
  for (double& c : emitter.carries) c *= t.load;
}

std::int64_t count_of(const Scene& scene) {
  std::int64_t count = 0;
  for (const Emitter& e : scene.emitters) count += e.gammatons;
  return count;
}

}  // namespace

RunEstimate estimate_run(SceneFile file, const SimulationOptions& options, const RunControl& control) {
  RunEstimate estimate;
  Scene& scene = file.scene;
  estimate.all_gammatons = count_of(scene);
  const int resolution = std::min(scene.resolution, kResolution);
  // Where what a gammaton carries is counted in texels, as many of them a texel make the same picture; drops of a width
  // in mm carry the same on any atlas.
  const double side = scene.exchange.splat_mm > 0.0 ? 1.0 : static_cast<double>(resolution) / scene.resolution;
  const double share = side * side;
  const double contacts = share * static_cast<double>(estimate.all_gammatons) *
                          static_cast<double>(std::max<std::int64_t>(1, file.iterations));
  const double fewer = std::min(1.0, kMaxContacts / contacts);
  for (Emitter& e : scene.emitters) thin(e, share * fewer, 1.0 / fewer);
  for (SceneEvent& event : scene.events) {
    if (auto* changed = std::get_if<EmitterEvent>(&event.what)) thin(changed->emitter, share * fewer, 1.0 / fewer);
  }
  scene.resolution = resolution;
  estimate.resolution = resolution;
  estimate.gammatons = count_of(scene);

  Simulation simulation(std::move(scene), options, control.part(0.0, 0.1));
  const RunControl quiet = control.silent();
  simulation.apply_due(quiet);
  const ImageF before = simulation.compose(quiet).color_linear();
  while (simulation.iteration() < file.iterations) {
    control.throw_if_stopped();
    simulation.step(quiet);
    control.report(0.1 + 0.8 * static_cast<double>(simulation.iteration()) / static_cast<double>(file.iterations));
  }
  simulation.apply_due(quiet);
  estimate.outcome = outcome_of(simulation, before, quiet);
  control.report(1.0);
  return estimate;
}

}  // namespace patinate::simulation
