/// \file
/// A scene as a model to be fitted: numbers named by JSON pointers, and the simulator behind them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "analysis/fit/aged_surface.h"
#include "analysis/fit/fit_parameter.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/simulation/scene_io.h"
#include "simulation/job/aged_frames.h"

namespace patinate::app {

/// Copies are cheap: they share what was read.
class FitScene {
 public:
  /// Reads the scene, finds every pointer, and reads the scene again with both ends of every range.
  /// @param controls  Parameter maps to write beside those that the scene asks for, as far as its materials have them:
  /// what the history has.
  /// @throws UsageError (IoError where a file names it) for a pointer that is no number of the scene (with those that
  /// are named nearly so), is named twice or cannot be varied; IoError for a scene that cannot be read, or not with an
  /// end of a range.
  FitScene(const std::filesystem::path& file, const std::vector<analysis::FitRange>& ranges,
           const std::vector<std::string>& controls, const RunControl& control);

  [[nodiscard]] const std::vector<analysis::FitParameter>& parameters() const { return parameters_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return base_->notes; }
  [[nodiscard]] analysis::SurfaceOutline outline() const;
  [[nodiscard]] analysis::AgeWith age() const;
  void add_inputs(JobInputs& inputs) const;
  /// Writes `folder / FILE.json` with these values. @param output  The folder's name in the end: paths are relative to
  /// it.
  void write(const std::filesystem::path& folder, const std::string& file, const std::filesystem::path& output,
             const std::vector<double>& values) const;
  /// Scene as read, with the starting values.
  [[nodiscard]] const simulation::SceneFile& base() const { return *base_; }
  /// The scene file with these values.
  [[nodiscard]] Json with(const std::vector<double>& values) const;
  /// Frames of a scene file of the same folder. @param change  Of the scene that was read.
  [[nodiscard]] analysis::AgedSurface aged(const Json& json, const RunControl& control,
                                           const std::function<void(simulation::Scene& scene)>& change) const;
  /// Makes the paths of a scene file of the same folder relative to another. @param output  That one, in the end.
  void move_paths(Json& json, const std::filesystem::path& output) const;
  /// Scene with another seed: chance of its own.
  [[nodiscard]] FitScene with_seed_shift(std::uint64_t shift) const;

 private:
  /// How it looks: frames of what has aged.
  [[nodiscard]] analysis::AgedSurface surface_of(simulation::AgedFrames& aged,
                                                 const std::vector<simulation::MaterialAppearance>& appearance,
                                                 const RunControl& control) const;
  [[nodiscard]] simulation::SceneFile read(const Json& json) const;
  void add_parameter(const analysis::FitRange& range);

  std::filesystem::path file_;
  std::string given_;  ///< The scene's content, as it was.
  std::shared_ptr<Json> root_;
  std::shared_ptr<simulation::SceneAssets> assets_ = std::make_shared<simulation::SceneAssets>();
  std::shared_ptr<const simulation::SceneFile> base_;  ///< With the starting values.
  std::vector<std::string> controls_;
  std::vector<analysis::FitParameter> parameters_;
  std::uint64_t seed_shift_ = 0;  ///< Added to the scene's seed.
};

}  // namespace patinate::app
