/// \file
/// What steps are called in the list that undo goes back in. For live_*.cpp.
#pragma once

#include <string>

#include "patinate/simulation/scene.h"

namespace patinate::studio {

/// A few words: "Ratio 0.6", "spout: spread 12 deg". @param scene  Before the event.
[[nodiscard]] std::string label_of(const simulation::SceneEvent& event, const simulation::Scene& scene);

}  // namespace patinate::studio
