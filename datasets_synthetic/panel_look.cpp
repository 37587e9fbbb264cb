#include "datasets_synthetic/panel_look.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/image/filters.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/color.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kCameraStream = 1600;  // Stream of random numbers, one a photograph.
constexpr std::int64_t kLookRows = 16;

/// Bare steel, before the scribe rusts.
const Vec3 kSteel(0.36, 0.37, 0.39);

/// Pairs of independent standard normal values from 32 random bits: Box and Muller's formula for 16,384 radii, up to
/// 4.6 standard deviations, and 4,096 angles. The tables stay in a processor's nearest caches.
class NormalPairs {
 public:
  static const NormalPairs& get() {
    static const NormalPairs pairs;
    return pairs;
  }
  [[nodiscard]] std::array<float, 2> at(std::uint32_t bits) const {
    const float radius = radii_[bits >> (32 - kRadiusBits)];
    const std::size_t angle = bits % kAngles;
    return {radius * cosines_[angle], radius * cosines_[(angle + kAngles / 4) % kAngles]};
  }

 private:
  NormalPairs() {
    for (std::size_t i = 0; i < kRadii; ++i)
      radii_.push_back(static_cast<float>(std::sqrt(-2.0 * std::log((static_cast<double>(i) + 0.5) / kRadii))));
    for (std::size_t i = 0; i < kAngles; ++i)
      cosines_.push_back(
          static_cast<float>(std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / kAngles)));
  }
  static constexpr unsigned kRadiusBits = 14;
  static constexpr std::size_t kRadii = 1U << kRadiusBits, kAngles = 4096;
  std::vector<float> radii_, cosines_;
};

/// sRGB codes in [0, 255] of linear light, by straight lines between 8193 values: within 0.01 of a code.
class CodeTable {
 public:
  static const CodeTable& get() {
    static const CodeTable table;
    return table;
  }
  [[nodiscard]] float code(float linear) const {
    const float at = kCount * std::clamp(linear, 0.0f, 1.0f);
    const int i = std::min(static_cast<int>(at), kCount - 1);
    const float low = values_[static_cast<std::size_t>(i)], high = values_[static_cast<std::size_t>(i) + 1];
    return low + (at - static_cast<float>(i)) * (high - low);
  }

 private:
  CodeTable() {
    for (int i = 0; i <= kCount; ++i) values_.push_back(255.0f * srgb_from_linear(static_cast<float>(i) / kCount));
  }
  static constexpr int kCount = 8192;
  std::vector<float> values_;
};

}  // namespace

std::array<double, 3> paint_lab(const PanelOptions& o, double hours) {
  std::array<double, 3> lab = o.paint;
  for (std::size_t i = 0; i < 3; ++i) lab[i] += hours / o.hours * o.color_change[i];
  return lab;
}

ImageF panel_light(const PanelLayout& layout, const PanelMarks& marks, double hours, const RunControl& control) {
  const PanelOptions& o = layout.options;
  const Vec3 paint = linear_color(paint_lab(o, hours)), change = paint - linear_color(o.paint);
  // A stain's wash lets through less of blue, and scatters some light of its own.
  const Vec3 lets_through(0.70, 0.42, 0.20), scatters(0.15, 0.065, 0.018);
  const double scribe_rust = std::min(1.0, 20.0 * hours / o.hours);  // All of it within a twentieth of the time.
  ImageF out(o.width, o.height, 3);
  parallel_for(o.height, kLookRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < o.width; ++x) {
        Vec3 color = (1.0 + static_cast<double>(layout.grain.at(x, y))) * paint +
                     static_cast<double>(layout.uneven.at(x, y)) * change;
        if (!marks.stain.empty()) {
          const auto opacity = static_cast<double>(marks.stain.at(x, y));
          color += opacity * (color.cwiseProduct(lets_through) + scatters - color);
        }
        if (!marks.cracks.empty()) color *= 1.0 - 0.8 * sample_share(marks.cracks.at(x, y));
        if (const std::uint64_t bits = marks.rust.samples.at(x, y); bits != 0) {
          color +=
              sample_share(bits) * (layout.rust.at(x, y, static_cast<double>(marks.rust.inside_px.at(x, y))) - color);
        }
        if (const std::uint64_t bits = marks.scribe ? marks.scribe->samples.at(x, y) : 0; bits != 0) {
          const Vec3 rust = layout.rust.at(x, y, static_cast<double>(marks.scribe->inside_px.at(x, y)));
          const double groove = 1.0 - 0.55 * sample_share(marks.cut.at(x, y));  // It lies in its own shadow.
          color += sample_share(bits) * (groove * (kSteel + scribe_rust * (rust - kSteel)) - color);
        }
        for (int c = 0; c < 3; ++c) out.at(x, y, c) = static_cast<float>(color[c]);
      }
    }
  });
  return out;
}

ImageU8 panel_photo(const ImageF& light, const PanelOptions& o, int frame, const RunControl& control) {
  const ImageF blurred = o.blur_px > 0.0 ? gaussian_blur(light, o.blur_px, control) : light;
  const NormalPairs& pairs = NormalPairs::get();
  const CodeTable& table = CodeTable::get();
  const auto deviation = static_cast<float>(255.0 * o.noise);
  ImageU8 codes(o.width, o.height, 3);
  parallel_for(o.height, kLookRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      RandomStream random(static_cast<std::uint64_t>(o.seed), static_cast<std::uint64_t>(y),
                          kCameraStream + static_cast<std::uint32_t>(frame));
      for (int x = 0; x < o.width; ++x) {
        const std::array<float, 2> first = pairs.at(random.next_u32()), second = pairs.at(random.next_u32());
        const std::array<float, 3> noise{first[0], first[1], second[0]};
        for (int c = 0; c < 3; ++c) {
          const float code = table.code(blurred.at(x, y, c)) + deviation * noise[static_cast<std::size_t>(c)];
          codes.at(x, y, c) = static_cast<std::uint8_t>(std::clamp(code, 0.0f, 255.0f) + 0.5f);
        }
      }
    }
  });
  return codes;
}

}  // namespace patinate::datasets
