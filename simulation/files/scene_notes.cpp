#include "simulation/files/scene_notes.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "libcommon/core/text.h"
#include "patinate/geometry/mesh.h"

namespace patinate::simulation {

namespace {

/// Diagonal of the largest object, mm.
double largest_size_mm(const Scene& scene) {
  double size = 0.0;
  for (const SceneObject& object : scene.objects)
    size = std::max(size, object.scale * bounding_box(object.mesh).diagonal());
  return size;
}

/// About an emitter whose speed is a hundred times what a fall through the largest object gives, or a hundredth: then
/// its drops fly straight, or fall straight down. Scenes that are copied to a mesh of another unit or size are so;
/// rain, 9 m/s, is 20 times that of a fall of 10 mm. "" = nothing.
std::string speed_note(const Emitter& emitter, double size_mm, double gravity_mm_s2, double mm_per_unit) {
  constexpr double kMaxTimes = 100.0;
  const double fall_mm_s = std::sqrt(2.0 * gravity_mm_s2 * size_mm);
  const double times = emitter.speed_mm_s / fall_mm_s;
  if (!emitter.is_on || !(fall_mm_s > 0.0) || (times <= kMaxTimes && times >= 1.0 / kMaxTimes)) return "";
  return "emitter '" + emitter.name + "': its `speed`, " + short_number_text(emitter.speed_mm_s / mm_per_unit) +
         " a second, is " + figure_text(times) + " times what a fall through the largest object, " +
         figure_text(size_mm / mm_per_unit) + " large, gives: its drops " +
         (times > 1.0 ? "fly straight, as without gravity" : "fall straight down, wherever they are sent") +
         "; speeds are in the scene's unit a second";
}

}  // namespace

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
  const double size_mm = largest_size_mm(scene);
  for (const Emitter& emitter : scene.emitters) {
    if (std::string note = speed_note(emitter, size_mm, scene.gravity_mm_s2.norm(), mm_per_unit); !note.empty())
      notes.push_back(std::move(note));
    for (std::size_t m = 0; m < scene.materials.size() && !rates_change; ++m) {
      if (!(emitter.carries[m] > 0.0) || scene.exchange.rates[m] > 0.0) continue;
      notes.push_back("emitter '" + emitter.name + "' carries " + scene.materials[m] +
                      ", which drops never give away: it has no rate in `exchange`");
    }
  }
  return notes;
}

}  // namespace patinate::simulation
