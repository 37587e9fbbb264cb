/// \file
/// An object that a camera goes around while it ages.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "app/output/render_work.h"

namespace patinate::app {

/// One picture: when, and from where.
struct PictureShot {
  double time = 0.0;
  PictureView view;
};

/// What one picture needs is kept for the next. One thread at a time.
class PictureStudio {
 public:
  using Sample = std::function<ImageF(double time, const RunControl& control)>;
  using Maps = std::function<SurfaceMaps(double time, const RunControl& control)>;
  /// @param sample  Color at a time. @param maps  All that is known at a time, or nothing. @throws IoError
  PictureStudio(std::shared_ptr<const RenderTask> task, std::shared_ptr<const Mesh> mesh, Sample sample, Maps maps);

  [[nodiscard]] ImageF picture(const PictureShot& shot, const RunControl& control);

 private:
  std::shared_ptr<const RenderTask> task_;
  std::shared_ptr<const Mesh> mesh_;
  Sample sample_;
  Maps maps_;
  ImageF environment_;
  std::optional<SurfaceView> surface_;
  double time_ = 0.0;  ///< Of surface_.
  std::optional<RenderView> color_;
  std::pair<double, double> seen_;  ///< Azimuth and elevation of color_.
};

}  // namespace patinate::app
