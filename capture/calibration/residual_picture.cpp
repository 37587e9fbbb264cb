#include "capture/calibration/residual_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "libcommon/image/filters.h"

namespace patinate::capture {

namespace {

constexpr int kMaxWidth = 1200;  ///< px of the report's picture.
using Color = std::array<float, 3>;
constexpr std::array<Color, 8> kColors{{{0.9f, 0.2f, 0.1f},
                                        {0.1f, 0.6f, 0.9f},
                                        {0.2f, 0.8f, 0.2f},
                                        {0.9f, 0.7f, 0.1f},
                                        {0.8f, 0.2f, 0.8f},
                                        {0.1f, 0.8f, 0.7f},
                                        {0.9f, 0.5f, 0.5f},
                                        {0.7f, 0.7f, 0.9f}}};

class Canvas {
 public:
  Canvas(ImageF image, double scale) : image_(std::move(image)), scale_(scale) {}
  /// Photograph's pixels; `width_px` of the picture.
  void line(const Vec2& a, const Vec2& b, const Color& color, double width_px) {
    const Vec2 from = at(a), to = at(b);
    const int steps = static_cast<int>(std::min(20'000.0, 2.0 * (to - from).norm())) + 1;
    for (int i = 0; i <= steps; ++i) dot(from + (to - from) * i / steps, color, width_px);
  }
  void point(const Vec2& p, const Color& color, double width_px) { dot(at(p), color, width_px); }
  [[nodiscard]] ImageF take() { return std::move(image_); }

 private:
  [[nodiscard]] Vec2 at(const Vec2& p) const { return scale_ * (p + Vec2(0.5, 0.5)) - Vec2(0.5, 0.5); }
  void dot(const Vec2& p, const Color& color, double width) {
    const double reach = 0.5 * width + 1.0;
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > 1e6) return;
    for (int y = static_cast<int>(std::floor(p.y() - reach)); y <= static_cast<int>(std::ceil(p.y() + reach)); ++y) {
      for (int x = static_cast<int>(std::floor(p.x() - reach)); x <= static_cast<int>(std::ceil(p.x() + reach)); ++x) {
        if (!image_.contains(x, y)) continue;
        const auto cover = static_cast<float>(std::clamp(0.5 * width + 0.5 - (Vec2(x, y) - p).norm(), 0.0, 1.0));
        for (int c = 0; c < 3; ++c)
          image_.at(x, y, c) =
              std::max(image_.at(x, y, c) * (1 - cover), cover * color[c] + image_.at(x, y, c) * (1 - cover));
      }
    }
  }
  ImageF image_;
  double scale_;
};

double scale_for(int width) { return std::min(1.0, static_cast<double>(kMaxWidth) / width); }
int scaled(int size, double scale) { return std::max(1, static_cast<int>(std::lround(size * scale))); }

}  // namespace

ImageF view_residuals_picture(const CameraCalibration& calibration, const std::vector<PointView>& views) {
  const CameraParameters& p = calibration.camera;
  const double scale = scale_for(p.width);
  Canvas canvas(ImageF(scaled(p.width, scale), scaled(p.height, scale), 3, 0.02f), scale);
  const double longer = std::max(p.width, p.height) / 40.0 / std::max(calibration.rms_px, 1e-12);
  for (std::size_t v = 0; v < views.size() && v < calibration.views.size(); ++v) {
    CameraParameters of_view = p;
    of_view.rotation = calibration.views[v].camera_from_target.rotation;
    of_view.translation = calibration.views[v].camera_from_target.translation;
    const Camera camera(of_view);
    const Color& color = kColors[v % kColors.size()];
    for (std::size_t i = 0; i < views[v].pixels.size(); ++i) {
      const auto seen = camera.project(views[v].points_mm[i]);
      const Vec2& pixel = views[v].pixels[i];
      if (seen) canvas.line(pixel, pixel + longer * (*seen - pixel), color, 1.2);
      canvas.point(pixel, color, 3.5);
    }
  }
  return canvas.take();
}

ImageF spheres_picture(const ImageF& photo, const Camera& camera, const std::vector<SphereFit>& fits,
                       const std::vector<MirrorSphere>& spheres, const Highlights& highlights) {
  const CameraParameters& p = camera.parameters();
  const double scale = scale_for(p.width);
  const int width = scaled(p.width, scale), height = scaled(p.height, scale);
  ImageF ground(width, height, 3, 0.02f);
  if (!photo.empty() && photo.channels() == 3) {
    ground = downscale_area(photo, width, height);
    for (float& v : ground.values()) v *= 0.6f;
  }
  Canvas canvas(std::move(ground), scale);
  for (std::size_t s = 0; s < fits.size(); ++s) {
    const Vec3 axis = fits[s].center - camera.center();
    const double distance = axis.norm(), radius = spheres[s].radius_mm;
    const Vec3 u = axis.unitOrthogonal(), v = axis.normalized().cross(u);
    const double rim = radius * std::sqrt(1.0 - radius * radius / (distance * distance));
    const Vec3 middle = fits[s].center - radius * radius / (distance * distance) * axis;
    constexpr int kSides = 180;  // Sides of the drawn outline.
    const auto at = [&](int i) {
      const double angle = 2.0 * std::numbers::pi * i / kSides;
      return camera.project(middle + rim * (std::cos(angle) * u + std::sin(angle) * v));
    };
    for (int i = 0; i < kSides; ++i) {
      const auto a = at(i), b = at(i + 1);
      if (a && b) canvas.line(*a, *b, {0.9f, 0.9f, 0.9f}, 1.2);
    }
  }
  const double arm = 8.0 / scale;
  for (std::size_t k = 0; k < highlights.size(); ++k) {
    for (const auto& pixel : highlights[k]) {
      if (!pixel) continue;
      canvas.line(*pixel - Vec2(arm, 0), *pixel + Vec2(arm, 0), kColors[k % kColors.size()], 1.5);
      canvas.line(*pixel - Vec2(0, arm), *pixel + Vec2(0, arm), kColors[k % kColors.size()], 1.5);
    }
  }
  return canvas.take();
}

}  // namespace patinate::capture
