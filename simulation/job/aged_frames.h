/// \file
/// A simulation from beginning to end in memory, to be looked at again and again: for what asks "and how would it look
/// with".
#pragma once

#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"
#include "simulation/job/simulation_output.h"

namespace patinate::simulation {

/// Amounts of all materials at every frame that `simulate` would write; composed with any appearance parameters without
/// simulating again. Memory: 4 bytes x materials x texels x frames. Not thread-safe.
class AgedFrames {
 public:
  /// Runs the whole scene. @param options  Its parameter maps are those of `file.controls`, whatever it says.
  /// @throws as Simulation; Canceled.
  AgedFrames(const SceneFile& file, SimulationOptions options, const RunControl& control = {});

  /// Times of the frames, in the scene's unit of time.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  /// Color at every frame, H x W x 3, linear: what the history of a simulation with these appearance parameters holds,
  /// before rounding to half. Same bits for any number of threads. @throws InvalidInput unless there is a look for each
  /// material, in range.
  [[nodiscard]] std::vector<ImageF> compose(const std::vector<MaterialAppearance>& appearance,
                                            const RunControl& control = {});
  /// Parameter maps at the end, as the history has them as controls.
  [[nodiscard]] const std::vector<ParameterControl>& controls() const { return controls_; }
  /// 0 / 255.
  [[nodiscard]] ImageU8 coverage() const { return simulation_.coverage(); }
  [[nodiscard]] double texel_size_mm() const { return simulation_.texel_size_mm(); }

 private:
  Simulation simulation_;
  std::vector<double> times_;
  std::vector<std::vector<ImageF>> amounts_;  ///< [frame][material]
  std::vector<ParameterControl> controls_;
};

}  // namespace patinate::simulation
