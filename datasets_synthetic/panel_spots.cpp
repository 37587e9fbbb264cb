#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets_synthetic/panel_marks.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kOutlineStream = 1500;  // Purpose of random streams.
constexpr std::int64_t kSpotRows = 16;
constexpr double kBend = 0.55;     ///< Largest of the bend k, times k.
constexpr double kMaxBends = 0.5;  ///< Sum of all bends: an outline never comes nearer to its middle than half.

/// @param c, s  Cosine and sine of the angle. Real numbers: a product of std::complex looks for infinities each time.
double relative_radius(const SpotOutline& spot, double c, double s) {
  double real = c, imaginary = s, r = 1.0;
  for (const std::complex<double>& bend : spot.bends) {
    const double next = real * c - imaginary * s;
    imaginary = real * s + imaginary * c;
    real = next;
    r += bend.real() * real - bend.imag() * imaginary;
  }
  return r;
}

/// Bound of |grad(rho / s(angle))| = sqrt(1 + (s' / s)^2) / s, from 256 angles and 10 % for what lies between them:
/// harmonics up to 9 change by less there.
double outline_slope(const SpotOutline& spot) {
  constexpr int kAngles = 256;
  double slope = 0.0;
  for (int i = 0; i < kAngles; ++i) {
    const std::complex<double> direction = std::polar(1.0, 2.0 * std::numbers::pi * i / kAngles);
    std::complex<double> power = direction;
    double s = 1.0, turn = 0.0;
    for (int k = 0; k < SpotOutline::kNumBends; ++k) {
      power *= direction;
      const std::complex<double> wave = spot.bends[static_cast<std::size_t>(k)] * power;
      s += wave.real();
      turn -= (k + 2) * wave.imag();
    }
    slope = std::max(slope, std::hypot(1.0, turn / s) / s);
  }
  return 1.1 * slope;
}

}  // namespace

double mark_growth(double hours, double start_h, double end_h) {
  return hours > start_h ? std::pow((hours - start_h) / (end_h - start_h), 0.6) : 0.0;
}

double SpotOutline::inside_px(double x, double y, double radius) const {
  const double dx = x - x_px, dy = y - y_px, distance = std::sqrt(dx * dx + dy * dy);
  return distance > 0.0 ? radius - distance / relative_radius(*this, dx / distance, dy / distance) : radius;
}

double SpotOutline::area_px2() const {
  double sum = 1.0;
  for (const std::complex<double>& bend : bends) sum += 0.5 * std::norm(bend);
  return std::numbers::pi * radius_px * radius_px * sum;
}

SpotOutline bent_outline(std::uint64_t seed, std::uint64_t item) {
  RandomStream random(seed, item, kOutlineStream);
  SpotOutline spot;
  double sum = 0.0;
  for (int k = 0; k < SpotOutline::kNumBends; ++k) {
    const double size = kBend * random.uniform() / (k + 2), angle = 2.0 * std::numbers::pi * random.uniform();
    spot.bends[static_cast<std::size_t>(k)] = std::polar(size, angle);
    sum += size;
  }
  if (sum > kMaxBends) {
    for (std::complex<double>& bend : spot.bends) bend *= kMaxBends / sum;
    sum = kMaxBends;
  }
  spot.reach = 1.0 + sum;
  spot.slope = outline_slope(spot);
  return spot;
}

Marks draw_spots(const std::vector<SpotOutline>& spots, const PanelOptions& o, bool is_edge, double hours, double scale,
                 bool wants_inside, const RunControl& control) {
  Marks marks{.samples = SampleImage(o.width, o.height)};
  if (wants_inside) marks.inside_px = ImageF(o.width, o.height, 1, -1.0f);
  parallel_for(o.height, kSpotRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (const SpotOutline& spot : spots) {
      const double radius = scale * spot.radius_px * mark_growth(hours, spot.start_h, o.hours);
      if (spot.is_edge != is_edge || !(radius > 0.0)) continue;
      const double reach = radius * spot.reach;
      PixelBox box =
          pixel_box(spot.x_px - reach, spot.y_px - reach, spot.x_px + reach, spot.y_px + reach, o.width, o.height);
      box.y0 = std::max(box.y0, static_cast<int>(begin));
      box.y1 = std::min(box.y1, static_cast<int>(end));
      const auto depth = [&](double x, double y) { return spot.inside_px(x, y, radius); };
      for (int y = box.y0; y < box.y1; ++y) {
        for (int x = box.x0; x < box.x1; ++x) {
          const double at_center = depth(x + 0.5, y + 0.5);
          marks.samples.at(x, y) |= samples_inside(x, y, spot.slope, at_center, depth);
          if (!wants_inside) continue;
          float& inside = marks.inside_px.at(x, y);
          inside = std::max(inside, static_cast<float>(at_center));
        }
      }
    }
  });
  return marks;
}

}  // namespace patinate::datasets
