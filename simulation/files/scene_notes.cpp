#include "simulation/files/scene_notes.h"

#include <algorithm>
#include <variant>

#include "libcommon/core/text.h"

namespace patinate::simulation {

std::vector<std::string> scene_notes(const SceneFile& file, double mm_per_unit) {
  const Scene& scene = file.scene;
  std::vector<std::string> notes;
  const TracingOptions& t = scene.tracing;
  if (t.pull * t.reach_mm < t.epsilon_mm * (1.0 - 1e-9))
    notes.push_back("tracing: floating drops sink by `pull`, " + short_number_text(t.pull * t.reach_mm / mm_per_unit) +
                    ", and hover by `epsilon`, " + short_number_text(t.epsilon_mm / mm_per_unit) +
                    ": those that hover higher leave the surface; let `pull` be larger");
  const auto is_late = [&](const SceneEvent& event) { return event.iteration > file.iterations; };
  const auto num_late = std::count_if(scene.events.begin(), scene.events.end(), is_late);
  if (num_late > 0) {
    const auto first = std::find_if(scene.events.begin(), scene.events.end(), is_late);
    notes.push_back(std::to_string(num_late) + (num_late == 1 ? " event comes" : " events come") +
                    " after the run's end, the first at iteration " + std::to_string(first->iteration) + " of " +
                    std::to_string(file.iterations) + ": let `iterations` be more, or their times earlier");
  }
  const bool rates_change = std::any_of(scene.events.begin(), scene.events.end(), [](const SceneEvent& event) {
    return std::holds_alternative<RateEvent>(event.what);
  });
  for (const Emitter& emitter : scene.emitters) {
    for (std::size_t m = 0; m < scene.materials.size() && !rates_change; ++m) {
      if (!(emitter.carries[m] > 0.0) || scene.exchange.rates[m] > 0.0) continue;
      notes.push_back("emitter '" + emitter.name + "' carries " + scene.materials[m] +
                      ", which drops never give away: it has no rate in `exchange`");
    }
  }
  return notes;
}

}  // namespace patinate::simulation
