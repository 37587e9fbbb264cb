/// \file
/// A finished simulation with another look, as a job: the same amounts, composed anew.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/job/job.h"
#include "patinate/core/options.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"

namespace patinate::simulation {

/// A number of a material's look that changes: "dirt", "strength", 0.5.
struct LookChange {
  std::string material;
  std::string what;  ///< One of look_numbers().
  double value = 0.0;
};

/// Names of the numbers of a look that may change, as scene files have them.
[[nodiscard]] const std::vector<std::string>& look_numbers();
/// Text such as "rust.strength=0.5". @throws InvalidInput with a text that names what was expected.
[[nodiscard]] LookChange parse_look_change(std::string_view text, const std::vector<std::string>& materials);

struct RecomposeOptions {
  ColorForm color_form = ColorForm::Normalized;
  std::shared_ptr<const SimulationDevice> device = {};  ///< Not described: it comes from the command.
};
void describe(OptionVisitor& v, RecomposeOptions& o);

/// A simulation folder as plan_simulation() describes it, which whatever shows simulations takes, but without
/// `state.bin`: it does not go on. Its scene is `scene` with the changes. Items are frames. Of a folder whose frames
/// hold no amounts (made by an earlier version) only textures and model.glb of the end are made.
/// @param source  A finished simulation folder. @param scene  Its own scene, or another with the same materials.
/// @throws IoError if the materials differ or files are missing; InvalidInput if a change is of none of them.
[[nodiscard]] JobPlan plan_recompose(const std::filesystem::path& source, SceneFile scene,
                                     const std::vector<LookChange>& changes, const RecomposeOptions& options,
                                     const std::filesystem::path& output);

}  // namespace patinate::simulation
