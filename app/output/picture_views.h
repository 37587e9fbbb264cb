/// \file
/// From where pictures of an object are taken.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/output/render.h"

namespace patinate::app {

struct PictureView {
  std::string name;
  double azimuth_deg = 0.0;
  double elevation_deg = 0.0;
};

/// Where the camera stands, and how often.
struct ViewChoice {
  std::string views;
  std::optional<double> turntable;
  std::vector<double> target;
  std::optional<double> distance;

  /// Takes target and distance over. @throws UsageError
  void apply_to(RenderOptions& options) const;
  /// All views that were asked for, at least that of the options. @throws UsageError
  [[nodiscard]] std::vector<PictureView> resolve(const RenderOptions& options) const;
  [[nodiscard]] bool is_given() const { return !views.empty() || turntable || !target.empty() || distance; }
};

}  // namespace patinate::app
