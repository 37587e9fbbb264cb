// Emitters under the weather.
#include <Eigen/Geometry>
#include <algorithm>

#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

namespace {

constexpr double kMmPerM = 1000.0;  ///< Unit.

/// Level directions: east along +x where that is level, north a quarter turn from it (-z where +y is up, +y where +z
/// is).
struct Compass {
  Vec3 east{1, 0, 0}, north{0, 0, -1};
};

Compass compass_of(const Vec3& gravity) {
  const double pull = gravity.norm();
  if (!(pull > 0.0)) return {};
  const Vec3 up = -gravity / pull;
  Vec3 east = Vec3::UnitX() - up.x() * up;
  if (!(east.norm() > 1e-6)) east = Vec3::UnitZ() - up.z() * up;
  east.normalize();
  return {.east = east, .north = up.cross(east)};
}

}  // namespace

void Simulation::State::apply_weather() {
  if (scene.weather.empty()) return;
  const double begin = static_cast<double>(iteration) * scene.time_per_iteration;
  const WeatherMean now =
      mean_weather(scene.weather, begin, static_cast<double>(iteration + 1) * scene.time_per_iteration);
  const Compass compass = compass_of(scene.gravity_mm_s2);
  for (Emitter& emitter : scene.emitters) {
    if (!emitter.follows) {
      emitter.born_share = 1.0;
      emitter.wind_mm_s = Vec3::Zero();
      continue;
    }
    const double full =
        emitter.full_at > 0.0 ? emitter.full_at : weather_peaks[static_cast<std::size_t>(*emitter.follows)];
    const double value = now.values[static_cast<std::size_t>(*emitter.follows)];
    emitter.born_share = full > 0.0 ? std::clamp(value / full, 0.0, 1.0) : 0.0;
    // In a calm the direction stays: one that is not looked at need not be placed anew.
    if (emitter.born_share > 0.0)
      emitter.wind_mm_s = kMmPerM * (now.wind_east_m_s * compass.east + now.wind_north_m_s * compass.north);
  }
}

}  // namespace patinate::simulation
