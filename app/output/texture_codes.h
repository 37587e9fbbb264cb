/// \file
/// Maps as the codes that textures of models hold.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "patinate/image/image.h"

namespace patinate::app {

/// Takes rows of a texture, from top to bottom (GlbTexture::make).
using WriteRows = std::function<void(std::span<const std::uint8_t> rows)>;

/// Codes of one channel. @param values  [0, 1].
[[nodiscard]] ImageU8 unit_codes(const ImageF& values);
/// 1 - roughness.
[[nodiscard]] ImageU8 gloss_codes(const ImageF& roughness);
/// Both side by side. @param roughness  Empty: nobody knows it.
[[nodiscard]] ImageF roughness_and_metalness(const ImageF& roughness, const ImageF& metalness);
/// Codes of roughness_and_metalness(): 1 - roughness and metalness.
[[nodiscard]] ImageU8 gloss_and_metal_codes(const ImageF& both);
/// Unit normals; flat is (128, 128, 255).
[[nodiscard]] ImageU8 normal_codes(const ImageF& normals);

}  // namespace patinate::app
