#include "capture/gloss/gloss_rig.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/core/median.h"
#include "libcommon/output/microfacet.h"

namespace patinate::capture {

namespace {

constexpr double kMinCosine = 0.05;  ///< Cosine to lamp and camera; beyond 87 degrees a pixel is not used.
constexpr int kGridSide = 48;        ///< Geometry is smooth: so many pixels along a side tell it.

Vec3 vector_at(const ImageF& image, int x, int y) {
  const auto p = image.pixel(x, y);
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

template <class Visit>
void visit_grid(const GlossRig& rig, int num_frames, const Visit& visit) {
  const int step = std::max(1, std::max(rig.normal.width(), rig.normal.height()) / kGridSide);
  for (int frame = 0; frame < (rig.is_moving() ? num_frames : 1); ++frame) {
    for (int y = step / 2; y < rig.normal.height(); y += step) {
      for (int x = step / 2; x < rig.normal.width(); x += step) {
        const GlossPixel pixel = gloss_pixel(rig, frame, x, y);
        if (pixel.is_lit) visit(pixel);
      }
    }
  }
}

}  // namespace

const Light& GlossRig::light(int frame) const {
  return lights[lights.size() == 1 ? 0 : static_cast<std::size_t>(frame)];
}
const Vec3& GlossRig::camera(int frame) const {
  return cameras[cameras.size() == 1 ? 0 : static_cast<std::size_t>(frame)];
}

double GlossPixel::lobe(double roughness) const {
  return std::numbers::pi * Lobe(normal, to_camera, roughness).value(to_light).shape / normal.dot(to_light);
}

double GlossPixel::half_angle() const {
  const Vec3 half = (to_light + to_camera).normalized();
  return std::atan2(half.cross(normal).norm(), half.dot(normal));
}

GlossPixel gloss_pixel(const GlossRig& rig, int frame, int x, int y) {
  GlossPixel pixel;
  if (!is_inside(rig.mask, x, y)) return pixel;
  pixel.normal = vector_at(rig.normal, x, y);
  if (!(pixel.normal.squaredNorm() > 0.5)) return pixel;
  const Vec3 p = vector_at(rig.position_mm, x, y);
  const Light& light = rig.light(frame);
  pixel.to_light = direction_to(light, p);
  pixel.to_camera = (rig.camera(frame) - p).normalized();
  const double cosine = pixel.normal.dot(pixel.to_light);
  pixel.is_lit = cosine > kMinCosine && pixel.normal.dot(pixel.to_camera) > kMinCosine;
  pixel.matt = rig.exposure * cosine / std::numbers::pi * light_at(light, p);
  return pixel;
}

std::array<double, 2> half_angles_deg(const GlossRig& rig, int num_frames) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  std::array<double, 2> range{180.0, 0.0};
  visit_grid(rig, num_frames, [&](const GlossPixel& pixel) {
    const double angle = kDegrees * pixel.half_angle();
    range = {std::min(range[0], angle), std::max(range[1], angle)};
  });
  return range;
}

void normalize_exposure(GlossRig& rig, int num_frames) {
  std::vector<double> shown;
  rig.exposure = 1.0;
  visit_grid(rig, num_frames, [&](const GlossPixel& pixel) { shown.push_back(pixel.matt.mean()); });
  if (!shown.empty()) rig.exposure = 1.0 / median(std::move(shown));
}

}  // namespace patinate::capture
