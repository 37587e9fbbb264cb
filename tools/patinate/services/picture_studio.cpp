#include "tools/patinate/services/picture_studio.h"

#include "patinate/image/image_io.h"

namespace patinate::cli {

PictureStudio::PictureStudio(std::shared_ptr<const RenderTask> task, std::shared_ptr<const Mesh> mesh, Sample sample,
                             Maps maps, double num_texels)
    : task_(std::move(task)),
      mesh_(std::move(mesh)),
      sample_(std::move(sample)),
      maps_(std::move(maps)),
      num_texels_(num_texels) {
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

JobCost PictureStudio::cost() const {
  // Measured in November 2026 with 360 thousand to 5.8 million rays and textures of 256 to 1024 texels
  // (docs/scaling.md); a ray that looks for occlusion takes what others do. Memory is that of an object that fills
  // half of the picture.
  const RenderOptions& o = task_->options;
  const double rays = static_cast<double>(o.width) * o.height * o.samples;
  const double hidden = static_cast<double>(o.occlusion_samples) * static_cast<double>(mesh_->positions.size());
  if (maps_) {  // Simulations of 256 and 512 texels, 5.8 and 13 million rays.
    return {.core_seconds = 0.05 + 1.07e-6 * (rays + hidden) + 7.8e-6 * num_texels_,
            .megabytes = 34.0 + 2.8e-6 * rays + 5.5e-4 * num_texels_};
  }
  return {.core_seconds = 0.2 + 7.7e-7 * (rays + hidden) + 2e-7 * num_texels_,
          .megabytes = 36.0 + 1.8e-5 * rays + 2.8e-5 * num_texels_};
}

}  // namespace patinate::cli
