#include "patinate/image/color.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "libcommon/core/text.h"

namespace patinate {

namespace {

double srgb_decode(double code) { return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4); }
double srgb_encode(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// How linear values become 8-bit codes.
class CodeOfLinear {
 public:
  CodeOfLinear() {
    for (std::size_t k = 0; k < edges_.size(); ++k)
      edges_[k] = static_cast<float>(srgb_decode((static_cast<double>(k) + 0.5) / 255.0));
    first_ = std::bit_cast<std::uint32_t>(edges_.front()) >> kShift;
    const std::uint32_t last = std::bit_cast<std::uint32_t>(edges_.back()) >> kShift;
    for (std::uint32_t bucket = first_; bucket <= last; ++bucket) {
      const auto least = std::bit_cast<float>(bucket << kShift);
      code_of_.push_back(
          static_cast<std::uint8_t>(std::upper_bound(edges_.begin(), edges_.end(), least) - edges_.begin()));
    }
  }
  /// How many edges do not lie above. NaN: 255.
  [[nodiscard]] std::uint8_t code(float linear) const {
    if (linear < edges_.front()) return 0;
    if (!(linear < edges_.back())) return 255;
    std::size_t code = code_of_[(std::bit_cast<std::uint32_t>(linear) >> kShift) - first_];
    while (linear >= edges_[code]) ++code;  // At most once: a bucket is narrower than a code.
    return static_cast<std::uint8_t>(code);
  }

 private:
  static constexpr int kShift = 16;    ///< 128 buckets an octave; the last octave has 68 codes.
  std::array<float, 255> edges_{};     ///< Half-way (in code) between codes: code k covers [edges[k - 1], edges[k]).
  std::uint32_t first_ = 0;            ///< Bucket of the first edge.
  std::vector<std::uint8_t> code_of_;  ///< Code of the least value of each bucket.
};

/// srgb_from_linear() of the normal half floats from 2^-14 to below 2, which frames are stored as.
class CodeOfHalf {
 public:
  CodeOfHalf() {
    for (std::uint32_t i = 0; i < codes_.size(); ++i)
      codes_[i] = static_cast<float>(srgb_encode(static_cast<double>(std::bit_cast<float>((kFirst + i) << kShift))));
  }
  [[nodiscard]] static bool has(float linear) {
    const auto bits = std::bit_cast<std::uint32_t>(linear);
    return (bits & ((1U << kShift) - 1U)) == 0 && (bits >> kShift) - kFirst < kCount;
  }
  [[nodiscard]] float code(float linear) const {
    return codes_[(std::bit_cast<std::uint32_t>(linear) >> kShift) - kFirst];
  }

 private:
  static constexpr std::uint32_t kShift = 13;                   ///< Mantissa bits that a half lacks.
  static constexpr std::uint32_t kFirst = (127U - 14U) << 10U;  ///< 2^-14.
  static constexpr std::uint32_t kCount = 15U << 10U;           ///< 15 octaves of 1024.
  std::array<float, kCount> codes_{};
};

const CodeOfLinear& code_table() {
  static const CodeOfLinear table;
  return table;
}

}  // namespace

float linear_from_srgb(float code) {
  const double value = srgb_decode(std::abs(static_cast<double>(code)));
  return static_cast<float>(code < 0.0f ? -value : value);
}

float srgb_from_linear(float linear) {
  static const CodeOfHalf halves;
  if (CodeOfHalf::has(linear)) return halves.code(linear);
  const double value = srgb_encode(std::abs(static_cast<double>(linear)));
  return static_cast<float>(linear < 0.0f ? -value : value);
}

std::uint8_t srgb8_from_linear(float linear) { return code_table().code(linear); }

float Response::linear_from_code(float code) const {
  switch (kind) {
    case Kind::File:
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
    case Kind::File:
      return "as the file says";
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
  const CodeOfLinear& table = code_table();
  std::transform(linear.values().begin(), linear.values().end(), codes.values().begin(),
                 [&](float v) { return table.code(v); });
  return codes;
}

float luminance(std::span<const float> pixel) {
  return pixel.size() < 3 ? pixel[0] : 0.2126f * pixel[0] + 0.7152f * pixel[1] + 0.0722f * pixel[2];
}

}  // namespace patinate
