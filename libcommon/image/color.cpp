#include "libcommon/image/color.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/text.h"

namespace patinate {

namespace {

double srgb_decode(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}
double srgb_encode(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// Linear values half-way (in code) between 8-bit codes: code k covers [edges[k - 1], edges[k]).
const std::array<float, 255>& code_edges() {
  static const std::array<float, 255> edges = [] {
    std::array<float, 255> e{};
    for (std::size_t k = 0; k < e.size(); ++k) {
      e[k] = static_cast<float>(srgb_decode((static_cast<double>(k) + 0.5) / 255.0));
    }
    return e;
  }();
  return edges;
}

}  // namespace

float linear_from_srgb(float code) {
  const double value = srgb_decode(std::abs(static_cast<double>(code)));
  return static_cast<float>(code < 0.0f ? -value : value);
}

float srgb_from_linear(float linear) {
  const double value = srgb_encode(std::abs(static_cast<double>(linear)));
  return static_cast<float>(linear < 0.0f ? -value : value);
}

std::uint8_t srgb8_from_linear(float linear) {
  const auto& edges = code_edges();
  return static_cast<std::uint8_t>(std::upper_bound(edges.begin(), edges.end(), linear) - edges.begin());
}

float Response::linear_from_code(float code) const {
  switch (kind) {
    case Kind::Srgb:
      return linear_from_srgb(code);
    case Kind::Linear:
      return code;
    case Kind::Gamma:
      return static_cast<float>(std::pow(std::max(0.0, static_cast<double>(code)), gamma));
  }
  return code;
}

std::string Response::text() const {
  switch (kind) {
    case Kind::Srgb:
      return "srgb";
    case Kind::Linear:
      return "linear";
    case Kind::Gamma:
      return "gamma " + number_text(gamma);
  }
  return "";
}

ImageU8 srgb8_from_linear(const ImageF& linear) {
  ImageU8 codes(linear.width(), linear.height(), linear.channels());
  std::transform(linear.values().begin(), linear.values().end(), codes.values().begin(),
                 [](float v) { return srgb8_from_linear(v); });
  return codes;
}

float luminance(std::span<const float> pixel) {
  return pixel.size() < 3 ? pixel[0] : 0.2126f * pixel[0] + 0.7152f * pixel[1] + 0.0722f * pixel[2];
}

}  // namespace patinate
