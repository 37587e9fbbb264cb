#include "tests/capture/stability/stability_scene.h"

#include <cmath>
#include <numbers>

#include "libcommon/core/random.h"

namespace patinate::testing_support {

namespace {

/// Waves of periods from 6 px on, in fixed random directions: band-limited, so that sampling loses nothing.
double texture(double x, double y) {
  constexpr int kNumWaves = 48;
  double sum = 0.0;
  for (int k = 0; k < kNumWaves; ++k) {
    RandomStream random(11, static_cast<std::uint64_t>(k), 0);
    const double angle = 2.0 * std::numbers::pi * random.uniform(), period = 6.0 + 30.0 * random.uniform(),
                 phase = 6.3 * random.uniform();
    sum += std::cos(2.0 * std::numbers::pi * (x * std::cos(angle) + y * std::sin(angle)) / period + phase);
  }
  return sum / std::sqrt(0.5 * kNumWaves);
}

/// Bright smooth grains that grow.
double grains(double x, double y, double growth) {
  constexpr int kNumGrains = 40;
  double most = 0.0;
  for (int k = 0; k < kNumGrains; ++k) {
    RandomStream random(12, static_cast<std::uint64_t>(k), 0);
    const double cx = 192.0 * random.uniform(), cy = 192.0 * random.uniform(),
                 radius = growth * (4.0 + 8.0 * random.uniform());
    const double inside = 1.0 / (1.0 + std::exp((std::hypot(x - cx, y - cy) - radius) / 0.8));
    if (radius > 0.5) most = std::max(most, inside);
  }
  return most;
}

}  // namespace

ImageF render_scene(const StabilityScene& scene) {
  ImageF image(scene.size, scene.size, 3);
  const Eigen::Affine2d scene_from_frame = scene.frame_from_scene.inverse();
  for (int y = 0; y < scene.size; ++y) {
    for (int x = 0; x < scene.size; ++x) {
      const Eigen::Vector2d p = scene_from_frame * Eigen::Vector2d(x, y);
      const double base = 0.2 * std::exp(0.25 * texture(p.x(), p.y())), grown = grains(p.x(), p.y(), scene.growth);
      const double light = scene.exposure * ((1.0 - grown) * base + 0.55 * grown);
      image.at(x, y, 0) = static_cast<float>(light);
      image.at(x, y, 1) = static_cast<float>(0.8 * light);
      image.at(x, y, 2) = static_cast<float>(0.6 * light);
    }
  }
  return image;
}

}  // namespace patinate::testing_support
