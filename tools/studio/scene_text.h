/// \file
/// A scene as the browser gets it (docs/studio_protocol.md, "What a scene looks like") and its events as scene files
/// have them.
#pragma once

#include <optional>
#include <span>

#include "patinate/core/json.h"
#include "patinate/simulation/scene.h"
#include "simulation/rules/rule_io.h"

namespace patinate::studio {

/// Lengths in mm, everything written out.
[[nodiscard]] Json emitters_json(const simulation::Scene& scene);
[[nodiscard]] Json objects_json(const simulation::Scene& scene);
[[nodiscard]] Json appearance_json(const simulation::Scene& scene,
                                   std::span<const simulation::MaterialAppearance> looks);
[[nodiscard]] Json behavior_json(const simulation::Behavior& behavior);
[[nodiscard]] Json exchange_json(const simulation::Scene& scene);
[[nodiscard]] Json rules_json(const simulation::Scene& scene);
/// Those of `fitting` that the scene does not have: [{"name", "about"}].
/// @param fitting  built_in_rules_for() its materials.
[[nodiscard]] Json more_rules_json(const simulation::Scene& scene, std::span<const simulation::RuleAsset> fitting);

/// An emitter as a scene file with this unit has it.
[[nodiscard]] Json emitter_of_file(const simulation::Emitter& emitter, const std::vector<std::string>& materials,
                                   double mm_per_unit);

/// A document as a person writes it: indented by two, but what fits stands in one line. Ends with a newline.
[[nodiscard]] std::string readable_text(const Json& json);

/// Event of a client (lengths in mm) as an element of a scene file's "events": lengths in its unit, with the
/// iteration. Numbers are not checked here. @throws InvalidInput if it is no object or has an iteration.
[[nodiscard]] Json event_of_file(const Json& event, double mm_per_unit, std::int64_t iteration);

}  // namespace patinate::studio
