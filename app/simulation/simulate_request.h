/// \file
/// What a simulation is asked for, over what its scene file says.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"

namespace patinate::app {

/// 0 = as the scene says.
struct SimulateOptions {
  std::int64_t iterations = 0;
  std::int64_t history_every = 0;
  int resolution = 0;
  simulation::ColorForm color_form = simulation::ColorForm::Normalized;
};
void describe(OptionVisitor& v, SimulateOptions& o);
/// @throws UsageError unless it is 0 or [16, 16384].
void require_resolution(const SimulateOptions& options);

struct SimulateRequest {
  std::filesystem::path scene;
  SimulateOptions options;
  std::optional<std::int64_t> seed;   ///< None: the scene's.
  std::vector<std::string> controls;  ///< Parameter maps beside those that the scene asks for.
};

/// The scene as it is to run. @throws UsageError for a resolution or a parameter map that does not exist; IoError
[[nodiscard]] simulation::SceneFile read_requested_scene(const SimulateRequest& request, const RunControl& control);

}  // namespace patinate::app
