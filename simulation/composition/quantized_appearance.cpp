#include "simulation/composition/quantized_appearance.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/random.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::simulation::composition {

namespace {

constexpr std::uint32_t kNoisePurpose = 0x6C6F6F6B;  // its own stream of random numbers
constexpr double kMaxHeightChange = 1 << 26;         // quanta by amount 1

void check_range(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw InvalidInput(std::string("the ") + name + " of an appearance is " + number_text(value) + "; use [" +
                     number_text(low) + ", " + number_text(high) + "]");
}

std::uint16_t linear16_of(double linear) { return linear16_of_srgb8()[srgb8_of(Vec3::Constant(linear))[0]]; }

/// Colors by amount: the first as the color itself, then ramps.
void set_ramps(const std::vector<ColorStop>& stops, QuantizedAppearance& out) {
  if (stops.size() < 2 || stops.size() > kMaxColorStops)
    throw InvalidInput("an appearance has " + std::to_string(stops.size()) + " colors by amount; use 2 to " +
                       std::to_string(kMaxColorStops));
  std::vector<std::int32_t> at;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    check_range("amount of a color", stops[i].amount, 0.0, kMostAmount);
    at.push_back(static_cast<std::int32_t>(std::lround(stops[i].amount * kOne)));
    if (i > 0 && !(stops[i].amount - stops[i - 1].amount > 0.999 * kMinColorStep))
      throw InvalidInput("amounts of colors have to rise by " + number_text(kMinColorStep) + " or more");
    if (stops[i].second_color) out.has_second_color = 1;
  }
  out.num_ramps = static_cast<std::int32_t>(stops.size()) - 1;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto channel = static_cast<int>(c);
    for (std::size_t i = 0; i < stops.size(); ++i) {
      const std::uint16_t first = linear16_of(stops[i].color[channel]);
      const std::uint16_t second = linear16_of(stops[i].second_color.value_or(stops[i].color)[channel]);
      (i == 0 ? out.color[c] : out.ramp_color[3 * (i - 1) + c]) = first;
      (i == 0 ? out.second_color[c] : out.ramp_second[3 * (i - 1) + c]) = second;
    }
  }
  for (std::size_t r = 0; r + 1 < stops.size(); ++r) {
    out.ramp_start[r] = at[r];
    out.ramp_width[r] = at[r + 1] - at[r];
    out.ramp_scale[r] = static_cast<std::int32_t>(std::lround(1073741824.0 / out.ramp_width[r]));
  }
}

std::int32_t share(double value) { return static_cast<std::int32_t>(std::lround(value * 32768.0)); }

}  // namespace

const std::array<std::uint16_t, 256>& linear16_of_srgb8() {
  static const std::array<std::uint16_t, 256> table = [] {
    std::array<std::uint16_t, 256> t{};
    for (std::size_t c = 0; c < t.size(); ++c) {
      t[c] = static_cast<std::uint16_t>(
          std::lround(65535.0 * static_cast<double>(linear_from_srgb(static_cast<float>(c) / 255.0f))));
    }
    return t;
  }();
  return table;
}

const std::array<std::uint8_t, kSrgbSize>& srgb8_of_linear16() {
  static const std::array<std::uint8_t, kSrgbSize> table = [] {
    std::array<std::uint8_t, kSrgbSize> t{};
    // Linear codes of 16 bits that one entry of the table stands for.
    constexpr double kStep = 1 << kSrgbShift;
    for (std::size_t i = 0; i < t.size(); ++i) {
      t[i] = srgb8_from_linear(static_cast<float>((static_cast<double>(i) * kStep + 0.5 * (kStep - 1.0)) / 65535.0));
    }
    for (std::size_t c = 0; c < 256; ++c) t[linear16_of_srgb8()[c] >> kSrgbShift] = static_cast<std::uint8_t>(c);
    return t;
  }();
  return table;
}

std::array<std::uint8_t, 3> srgb8_of(const Vec3& linear) {
  std::array<std::uint8_t, 3> codes{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double value = linear[static_cast<int>(c)];
    codes[c] = std::isfinite(value) ? srgb8_from_linear(static_cast<float>(value)) : std::uint8_t{0};
  }
  return codes;
}

void Picture::read_tile(int x0, int y0, std::uint16_t* out) const {
  const std::size_t plane = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  for (std::size_t c = 0; c < 3; ++c) {
    for (int l = 0; l < kTile; ++l) {
      const int x = (x0 + l % 8) % width, y = (y0 + l / 8) % height;
      *out++ = planes[c * plane + static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(x)];
    }
  }
}

Picture make_picture(const ImageF& linear) {
  Picture picture{.width = linear.width(), .height = linear.height(), .planes = {}};
  if (linear.empty()) return picture;
  for (int c = 0; c < 3; ++c) {
    const int channel = std::min(c, linear.channels() - 1);
    for (int y = 0; y < linear.height(); ++y) {
      for (int x = 0; x < linear.width(); ++x) {
        const double value = static_cast<double>(linear.at(x, y, channel));
        picture.planes.push_back(linear16_of_srgb8()[srgb8_of(Vec3::Constant(value))[0]]);
      }
    }
  }
  return picture;
}

QuantizedAppearance quantize(const MaterialAppearance& look, double quanta_per_mm, std::uint32_t noise_key) {
  check_range("strength", look.strength, 0.0, 1000.0);
  check_range("variation", look.variation, 0.0, 1.0);
  check_range("specular change", look.specular, -1.0, 1.0);
  check_range("specular variation", look.specular_variation, 0.0, 1.0);
  check_range("height", look.height_mm, -1e6, 1e6);
  check_range("height variation", look.height_variation, 0.0, 1.0);
  QuantizedAppearance out;
  out.strength = static_cast<std::uint32_t>(std::lround(look.strength * kOne));
  if (out.strength > 0) out.limit = std::min<std::uint32_t>(kMaxWeight, (kMaxWeight << 14) / out.strength);
  out.variation = share(look.variation);
  out.specular = static_cast<std::int32_t>(std::lround(look.specular * 8192.0));
  out.specular_variation = share(look.specular_variation);
  const double height = std::clamp(look.height_mm * quanta_per_mm, -kMaxHeightChange, kMaxHeightChange);
  // height * 2^-14 = mantissa * 2^-shift with |mantissa| in (4096, 8192].
  if (height != 0.0) {
    const int exponent = static_cast<int>(std::ceil(std::log2(std::abs(height))));
    out.height_shift = std::min(30, 14 + 13 - exponent);
    out.height = static_cast<std::int32_t>(std::lround(std::ldexp(height, out.height_shift - 14)));
  }
  out.height_variation = share(look.height_variation);
  for (std::size_t c = 0; c < 3; ++c) out.color[c] = linear16_of_srgb8()[srgb8_of(look.color.color)[c]];
  check_range("grain", look.grain_mm, 0.0, 1e9);
  if (look.second_color && look.grain_mm > 0.0 && look.color.image.empty()) {
    out.has_second_color = 1;
    for (std::size_t c = 0; c < 3; ++c) out.second_color[c] = linear16_of_srgb8()[srgb8_of(*look.second_color)[c]];
  }
  if (!look.colors.empty() && look.color.image.empty()) set_ramps(look.colors, out);
  out.noise_key = noise_key;
  return out;
}

std::uint32_t noise_key(int index) {
  return philox4x32({static_cast<std::uint32_t>(index), 0, 0, 0}, {kNoisePurpose, 0})[0];
}

}  // namespace patinate::simulation::composition
