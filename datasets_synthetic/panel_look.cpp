#include "datasets_synthetic/panel_look.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/image/filters.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/color.h"
#include "patinate/metrics/difference.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kRustStream = 1540, kCameraStream = 1600;  // Of random streams; the camera's has many.
constexpr std::int64_t kLookRows = 16;

Vec3 linear_color(const std::array<double, 3>& lab) {
  const std::array<double, 3> rgb = linear_from_lab(lab);
  return {rgb[0], rgb[1], rgb[2]};
}

/// Rust by how deep it lies inside of a mark: a thin orange rim, red-brown, and a dark core.
class RustColor {
 public:
  explicit RustColor(const PanelOptions& o)
      : mm_(o.pixel_mm),
        broad_(static_cast<std::uint64_t>(o.seed), kRustStream, o.width, o.height, cell(1.6), cell(1.6)),
        fine_(static_cast<std::uint64_t>(o.seed), kRustStream + 1, o.width, o.height, cell(0.4), cell(0.4)),
        grain_(static_cast<std::uint64_t>(o.seed), kRustStream + 2, o.width, o.height, cell(0.15), cell(0.15)) {}

  [[nodiscard]] Vec3 at(int x, int y, double inside_px) const {
    const double broad = broad_(x, y), fine = fine_(x, y);
    const double deep = std::max(0.0, inside_px) * mm_ * (1.0 + 0.8 * broad) + 0.25 * fine;
    const double middle = smooth_step(0.02, 0.35, deep), core = smooth_step(0.4, 1.5, deep + 0.5 * broad);
    Vec3 color = rim_ + middle * (middle_ - rim_);
    color += 0.9 * core * (core_ - color);
    // Loose orange products lie on the core here and there.
    color += 0.55 * smooth_step(0.18, 0.5, fine - 0.3 * broad) * (rim_ - color);
    return std::max(0.3, 1.0 + 0.5 * grain_(x, y) + 0.3 * fine) * color;
  }

 private:
  [[nodiscard]] double cell(double mm) const { return std::max(1.2, mm / mm_); }
  double mm_;
  SmoothNoise broad_, fine_, grain_;
  Vec3 rim_ = linear_color({50.0, 25.0, 42.0});
  Vec3 middle_ = linear_color({35.0, 22.0, 27.0});
  Vec3 core_ = linear_color({22.0, 10.0, 11.0});
};

/// The scribe before it rusts, at how deep its middle line lies: bare steel with a shadow along both sides.
Vec3 bare_steel(double inside_px, double half_px) {
  const double shade = 0.25 + 0.75 * smooth_step(0.0, 0.5 * half_px, inside_px);
  return shade * Vec3(0.36, 0.37, 0.39);
}

/// Pairs of independent standard normal values from 32 random bits: Box and Muller's formula for 65,536 radii and as
/// many angles, up to 4.9 standard deviations.
class NormalPairs {
 public:
  static const NormalPairs& get() {
    static const NormalPairs pairs;
    return pairs;
  }
  [[nodiscard]] std::array<float, 2> at(std::uint32_t bits) const {
    const std::size_t r = bits >> 16, a = bits & 0xffff;
    return {radii_[r] * cosines_[a], radii_[r] * cosines_[(a + kCount / 4) % kCount]};
  }

 private:
  NormalPairs() : radii_(kCount), cosines_(kCount) {
    for (std::size_t i = 0; i < kCount; ++i) {
      const double share = (static_cast<double>(i) + 0.5) / kCount;
      radii_[i] = static_cast<float>(std::sqrt(-2.0 * std::log(share)));
      cosines_[i] = static_cast<float>(std::cos(2.0 * std::numbers::pi * share));
    }
  }
  static constexpr std::size_t kCount = 65536;
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
  const Vec3 tint(0.80, 0.42, 0.13);  // What a layer of rust's wash lets through.
  const RustColor rust(o);
  const double scribe_half = layout.scribe ? 0.5 * layout.scribe->width_mm / o.pixel_mm : 0.0;
  const double scribe_rust = std::min(1.0, 20.0 * hours / o.hours);  // All of it within a twentieth of the time.
  ImageF out(o.width, o.height, 3);
  parallel_for(o.height, kLookRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < o.width; ++x) {
        Vec3 color = (1.0 + static_cast<double>(layout.grain.at(x, y))) * paint +
                     static_cast<double>(layout.uneven.at(x, y)) * change;
        if (!marks.stain.empty()) {
          const auto opacity = static_cast<double>(marks.stain.at(x, y));
          color = color.cwiseProduct(Vec3::Ones() + opacity * (tint - Vec3::Ones()));
        }
        if (!marks.cracks.empty()) color *= 1.0 - 0.8 * sample_share(marks.cracks.at(x, y));
        if (const std::uint64_t bits = marks.rust.samples.at(x, y); bits != 0) {
          color += sample_share(bits) * (rust.at(x, y, static_cast<double>(marks.rust.inside_px.at(x, y))) - color);
        }
        if (const std::uint64_t bits = marks.scribe ? marks.scribe->samples.at(x, y) : 0; bits != 0) {
          const auto inside = static_cast<double>(marks.scribe->inside_px.at(x, y));
          const Vec3 steel = bare_steel(inside, scribe_half);
          color += sample_share(bits) * (steel + scribe_rust * (rust.at(x, y, inside) - steel) - color);
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
      for (int x = 0; x < o.width; ++x) {
        const auto item =
            static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(o.width) + static_cast<std::uint64_t>(x);
        RandomStream random(static_cast<std::uint64_t>(o.seed), item,
                            kCameraStream + static_cast<std::uint32_t>(frame));
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
