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
constexpr double kBend = 0.7;      ///< Largest of the bend k, times k^1.5: rounder than a star.
constexpr double kMaxBends = 0.5;  ///< Sum of all bends: an outline never comes nearer to its middle than half.

/// Places in a row, all at once, which compilers turn into vector instructions.
struct OutlineRow {
  static constexpr std::size_t kCount = 8;
  std::array<float, kCount> distance{};  ///< From the spot's middle, pixels.
  std::array<float, kCount> outline{};   ///< How far the outline of radius 1 is from the middle in that direction.

  /// @param x, y  The first place. @param step  From one to the next.
  OutlineRow(const SpotOutline& spot, double x, double step, double y) {
    std::array<float, kCount> c{}, s{}, real{}, imaginary{};
    const auto left = static_cast<float>(x - spot.x_px), by = static_cast<float>(step);
    const auto dy = static_cast<float>(y - spot.y_px);
    for (std::size_t i = 0; i < kCount; ++i) {
      const float dx = left + by * static_cast<float>(i);
      distance[i] = std::sqrt(dx * dx + dy * dy);
      const float inverse = 1.0f / std::max(distance[i], 1e-12f);
      real[i] = c[i] = dx * inverse;
      imaginary[i] = s[i] = dy * inverse;
      outline[i] = 1.0f;
    }
    for (const std::complex<double>& bend : spot.bends) {
      const auto by_real = static_cast<float>(bend.real()), by_imaginary = static_cast<float>(bend.imag());
      for (std::size_t i = 0; i < kCount; ++i) {
        const float next = real[i] * c[i] - imaginary[i] * s[i];
        imaginary[i] = real[i] * s[i] + imaginary[i] * c[i];
        real[i] = next;
        outline[i] += by_real * real[i] - by_imaginary * imaginary[i];
      }
    }
  }
  /// How far inside place `i` lies, as a radius: that of the spot minus that of the outline scaled to pass through it.
  [[nodiscard]] float inside(std::size_t i, float radius) const { return radius - distance[i] / outline[i]; }
};
static_assert(kSamplesPerSide == OutlineRow::kCount);

/// Samples of a pixel inside of a spot. @param at_center  How far inside the pixel's center lies.
std::uint64_t spot_samples(const SpotOutline& spot, float radius, int x, int y, float at_center) {
  const auto margin = static_cast<float>(spot.slope * kSampleReach);
  if (at_center > margin) return ~std::uint64_t{0};
  std::uint64_t bits = 0;
  for (int j = 0; at_center >= -margin && j < kSamplesPerSide; ++j) {
    const OutlineRow row(spot, sample_place(x, 0), 1.0 / kSamplesPerSide, sample_place(y, j));
    for (std::size_t i = 0; i < row.kCount; ++i)
      bits |= static_cast<std::uint64_t>(row.inside(i, radius) >= 0.0f)
              << (kSamplesPerSide * static_cast<std::size_t>(j) + i);
  }
  return bits;
}

/// Adds a spot to the rows [begin, end).
void draw_spot(Marks& marks, const SpotOutline& spot, double radius, int begin, int end) {
  const double reach = radius * spot.reach;
  const PixelBox box = pixel_box(spot.x_px - reach, spot.y_px - reach, spot.x_px + reach, spot.y_px + reach,
                                 marks.samples.width(), marks.samples.height());
  for (int y = std::max(box.y0, begin); y < std::min(box.y1, end); ++y) {
    for (int x0 = box.x0; x0 < box.x1; x0 += static_cast<int>(OutlineRow::kCount)) {
      const OutlineRow row(spot, x0 + 0.5, 1.0, y + 0.5);
      for (std::size_t i = 0; i < row.kCount && x0 + static_cast<int>(i) < box.x1; ++i) {
        const int x = x0 + static_cast<int>(i);
        const float at_center = row.inside(i, static_cast<float>(radius));
        std::uint64_t& bits = marks.samples.at(x, y);
        if (bits != ~std::uint64_t{0}) bits |= spot_samples(spot, static_cast<float>(radius), x, y, at_center);
        if (!marks.inside_px.empty()) marks.inside_px.at(x, y) = std::max(marks.inside_px.at(x, y), at_center);
      }
    }
  }
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
    const double size = kBend * random.uniform() * std::pow(k + 2, -1.5),
                 angle = 2.0 * std::numbers::pi * random.uniform();
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
      draw_spot(marks, spot, radius, static_cast<int>(begin), static_cast<int>(end));
    }
  });
  return marks;
}

}  // namespace patinate::datasets
