#include "app/output/texture_codes.h"

#include <algorithm>

#include "patinate/history/history_sampling.h"

namespace patinate::app {

namespace {

/// [0, 1] as a code.
std::uint8_t unit_code(float value) {
  return static_cast<std::uint8_t>(std::clamp(255.0f * value + 0.5f, 0.0f, 255.0f));
}
/// 1 - roughness as a code.
std::uint8_t gloss_code(float roughness) {
  return static_cast<std::uint8_t>(std::clamp(255.5f - 255.0f * roughness, 0.0f, 255.0f));
}

}  // namespace

ImageU8 unit_codes(const ImageF& values) {
  ImageU8 codes(values.width(), values.height());
  std::transform(values.values().begin(), values.values().end(), codes.data(), unit_code);
  return codes;
}
ImageU8 gloss_codes(const ImageF& roughness) {
  ImageU8 gloss(roughness.width(), roughness.height());
  std::transform(roughness.values().begin(), roughness.values().end(), gloss.data(), gloss_code);
  return gloss;
}

ImageF roughness_and_metalness(const ImageF& roughness, const ImageF& metalness) {
  ImageF both(metalness.width(), metalness.height(), 2, kUnknownRoughness);
  for (std::int64_t i = 0; i < both.num_pixels(); ++i) {
    if (!roughness.empty()) both.data()[2 * i] = roughness.data()[i];
    both.data()[2 * i + 1] = metalness.data()[i];
  }
  return both;
}

ImageU8 gloss_and_metal_codes(const ImageF& both) {
  ImageU8 codes(both.width(), both.height(), 2);
  for (std::size_t i = 0; i < codes.values().size(); i += 2) {
    codes.data()[i] = gloss_code(both.data()[i]);
    codes.data()[i + 1] = unit_code(both.data()[i + 1]);
  }
  return codes;
}

ImageU8 normal_codes(const ImageF& normals) {
  ImageU8 codes(normals.width(), normals.height(), 3);
  for (std::size_t i = 0; i < codes.values().size(); ++i)
    codes.data()[i] = static_cast<std::uint8_t>(std::clamp(128.0f + 127.5f * normals.data()[i], 0.0f, 255.0f));
  return codes;
}

}  // namespace patinate::app
