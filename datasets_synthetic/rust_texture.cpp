#include "datasets_synthetic/rust_texture.h"

#include <algorithm>
#include <cmath>

#include "patinate/metrics/difference.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kRustStream = 1540;  // Purposes of random streams.

/// Noise whose cells have a length on the panel, but are never finer than pixels.
SmoothNoise rust_noise(const PanelOptions& o, std::uint32_t number, double cell_mm) {
  const double cell = std::max(1.2, cell_mm / o.pixel_mm);
  return {static_cast<std::uint64_t>(o.seed), kRustStream + number, 1.0 * o.width, 1.0 * o.height, cell, cell};
}

}  // namespace

Vec3 linear_color(const std::array<double, 3>& lab) {
  const std::array<double, 3> rgb = linear_from_lab(lab);
  return {rgb[0], rgb[1], rgb[2]};
}

RustTexture::RustTexture(const PanelOptions& o)
    : mm_(o.pixel_mm),
      broad_(rust_noise(o, 0, 1.6)),
      fine_(rust_noise(o, 1, 0.4)),
      grain_(rust_noise(o, 2, 0.15)),
      rim_(linear_color({46.0, 25.0, 38.0})),
      middle_(linear_color({36.0, 22.0, 28.0})),
      core_(linear_color({22.0, 10.0, 11.0})) {}

Vec3 RustTexture::at(int x, int y, double inside_px) const {
  const double broad = broad_(x, y), fine = fine_(x, y);
  const double deep = std::max(0.0, inside_px) * mm_ * (1.0 + 0.8 * broad) + 0.5 * fine;
  const double middle = smooth_step(-0.1, 0.35, deep + 0.4 * broad), core = smooth_step(0.4, 1.6, deep + 0.8 * broad);
  Vec3 color = rim_ + middle * (middle_ - rim_);
  color += 0.85 * core * (core_ - color);
  // Loose orange products lie on it here and there.
  color += 0.55 * smooth_step(0.18, 0.5, fine - 0.3 * broad) * (rim_ - color);
  return std::max(0.3, 1.0 + 0.5 * grain_(x, y) + 0.3 * fine) * color;
}

}  // namespace patinate::datasets
