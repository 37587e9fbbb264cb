/// \file
/// A scene whose numbers become fields: the rate of a rule, or an initial amount, times a map of the scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/fit/field_job.h"
#include "tools/patinate/services/fit_scene.h"

namespace patinate::cli {

/// Copies are cheap: they share what was read.
class FieldScene {
 public:
  /// @throws what FitScene does; UsageError for a pointer to anything but /rules/N/rate or /objects/N/initial/MATERIAL;
  /// InvalidInput for a scene of several objects.
  FieldScene(const std::filesystem::path& file, const std::vector<analysis::FitRange>& ranges,
             const RunControl& control);

  [[nodiscard]] const FitScene& scene() const { return scene_; }
  /// Where the atlas shows the surface: 0 / 255.
  [[nodiscard]] ImageU8 coverage() const;
  /// Rules' factors and amounts are the maps over their largest value, which becomes the number.
  [[nodiscard]] analysis::AgeWithFields age() const;
  /// Writes `folder / scene.json`, and the maps (EXR, 1 is the number) beside it. @param output  The folder's name in
  /// the end.
  void write(const std::filesystem::path& folder, const std::filesystem::path& output,
             const std::vector<ImageF>& values) const;

 private:
  struct Placed;
  [[nodiscard]] Placed placed(const std::vector<ImageF>& values) const;

  FitScene scene_;
};

}  // namespace patinate::cli
