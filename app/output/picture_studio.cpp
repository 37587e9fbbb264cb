#include "app/output/picture_studio.h"

#include "patinate/image/image_io.h"

namespace patinate::app {

PictureStudio::PictureStudio(std::shared_ptr<const RenderTask> task, std::shared_ptr<const Mesh> mesh, Sample sample,
                             Maps maps)
    : task_(std::move(task)), mesh_(std::move(mesh)), sample_(std::move(sample)), maps_(std::move(maps)) {
  if (task_->environment.empty()) return;
  environment_ = read_color(task_->environment);
  if (!maps_) {
    maps_ = [color = sample_](double time, const RunControl& control) {
      return SurfaceMaps{.color = color(time, control)};
    };
  }
}

ImageF PictureStudio::picture(const PictureShot& shot, const RunControl& control) {
  const RunControl begin = control.part(0.0, 0.6), end = control.part(0.6, 1.0);
  if (maps_) {
    if (!surface_ || time_ != shot.time)
      surface_.emplace(*mesh_, maps_(shot.time, begin), task_->options, task_->surface, environment_, begin);
    time_ = shot.time;
    return surface_->picture(shot.view.azimuth_deg, shot.view.elevation_deg, end);
  }
  RenderOptions options = task_->options;
  options.azimuth_deg = shot.view.azimuth_deg;
  options.elevation_deg = shot.view.elevation_deg;
  if (!color_ || seen_ != std::pair(options.azimuth_deg, options.elevation_deg)) color_.emplace(*mesh_, options, begin);
  seen_ = {options.azimuth_deg, options.elevation_deg};
  return color_->shade(sample_(shot.time, end), end);
}

}  // namespace patinate::app
