/// \file
/// The parts of a scene file, each read on its own. For scene_io.cpp.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/history/history_value.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

/// Facts of the whole scene that its parts need.
struct SceneContext {
  std::vector<std::string> materials;
  double mm_per_unit = 1000.0;
  TimeUnit time_unit = TimeUnit::Days;
  double time_per_iteration = 0.0;                 ///< In that unit; 0 = none.
  std::array<bool, kNumWeatherSignals> weather{};  ///< Signals that the scene's weather tells of.
  /// Reads a picture in linear color (3 channels) or as values (1), and remembers it as an input.
  std::function<ImageF(const JsonReader& path, int num_channels)> read_picture;
  /// Remembers another file as an input.
  std::function<void(const std::string& role, const std::filesystem::path& path)> add_input;
};

/// [x, y, z] of any length but 0. @returns it as a unit vector.
[[nodiscard]] Vec3 read_direction(const JsonReader& json);
/// Index of a material. @throws IoError with a did-you-mean.
[[nodiscard]] int material_index(const JsonReader& json, const std::string& name,
                                 const std::vector<std::string>& materials);
/// {"water": 0.8, ...}: what is not named is 0.
[[nodiscard]] MaterialValues read_material_values(JsonReader json, const std::vector<std::string>& materials,
                                                  const Range& range);

/// A path, {"image": path, "width_mm": width} or [r, g, b].
[[nodiscard]] ColorSource read_color_source(JsonReader json, const SceneContext& context);
/// One member of "appearance". @param defaults  What members that are not given keep.
[[nodiscard]] MaterialAppearance read_material_appearance(JsonReader json, MaterialAppearance defaults,
                                                          const SceneContext& context);
/// One member of "presets". Materials of a library that the scene does not have are excluded.
/// @param may_have_others  Whether "composition" may name materials that are not the scene's.
[[nodiscard]] Preset read_preset(JsonReader json, const SceneContext& context, bool may_have_others);
/// Names and what they stand for, from the library that comes with patinate.
[[nodiscard]] std::map<std::string, MaterialAppearance> library_appearance(const SceneContext& context);
[[nodiscard]] std::map<std::string, Preset> library_presets(const SceneContext& context);

/// One element of "emitters". @param defaults  For an event: the emitter as it is.
[[nodiscard]] Emitter read_emitter(JsonReader json, const SceneContext& context);
[[nodiscard]] Behavior read_behavior(JsonReader json);
/// @param t  What is not given: lengths that fit the scene.
[[nodiscard]] TracingOptions read_tracing(JsonReader json, const SceneContext& context, TracingOptions t);
/// @param e  What is not given: a drop of a width that fits the scene.
[[nodiscard]] ExchangeOptions read_exchange(JsonReader json, const SceneContext& context, ExchangeOptions e);
/// "events" into scene.events, by iteration, and scene.series. @param scene  With its objects, emitters, maps and
/// rules.
void read_events(const JsonReader& json, const SceneContext& context, Scene& scene);
/// @throws IoError if a rule asks for weather that the scene does not tell of.
void check_signals(const JsonReader& json, const Rule& rule, const SceneContext& context, const Scene& scene);

}  // namespace patinate::simulation
