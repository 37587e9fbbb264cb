/// \file
/// The parts of a scene file, each read on its own. For scene_io.cpp.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

/// What the parts need to know of the whole.
struct SceneContext {
  std::vector<std::string> materials;
  double mm_per_unit = 1000.0;
  /// Reads a picture in linear color (3 channels) or as values (1), and remembers it as an input.
  std::function<ImageF(const JsonReader& path, int num_channels)> read_picture;
};

/// Index of a material. @throws IoError with a did-you-mean.
[[nodiscard]] int material_index(const JsonReader& json, const std::string& name,
                                 const std::vector<std::string>& materials);
/// {"water": 0.8, ...}: what is not named is 0.
[[nodiscard]] MaterialValues read_material_values(JsonReader json, const std::vector<std::string>& materials,
                                                  const Range& range);

/// A path or [r, g, b].
[[nodiscard]] ColorSource read_color_source(const JsonReader& json, const SceneContext& context);
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
/// "events", by iteration. @param scene  With its objects, emitters and rules.
[[nodiscard]] std::vector<SceneEvent> read_events(const JsonReader& json, const SceneContext& context,
                                                  const Scene& scene);

}  // namespace patinate::simulation
