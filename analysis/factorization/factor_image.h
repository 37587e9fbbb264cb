/// \file
/// Factors of every pixel as one image, and what they make of a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "patinate/analysis/factorization.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// Channels: for every model status, rate, offset, rate_stddev, residual; then gain and base of red, green, blue.
[[nodiscard]] std::vector<std::string> factor_channel_names(std::size_t num_models);
/// @param factors  For each model, width x height places in reading order.
[[nodiscard]] ImageF factor_image(int width, int height, const std::vector<std::vector<PlaceFactors>>& factors);
/// The inverse for one pixel (y * width + x) and model.
[[nodiscard]] PlaceFactors factors_at(const ImageF& image, std::int64_t pixel, std::size_t model,
                                      std::size_t num_models);

/// Linear color of a pixel at a time, no more than a half float holds. @param models  One, or one per channel.
/// @param lowest  What it is at least.
[[nodiscard]] std::array<float, 3> factored_color(std::span<const TemporalModel> models, const ImageF& image,
                                                  std::int64_t pixel, double time, double lowest = 0.0);
/// Whether all its curves are known at that time.
[[nodiscard]] bool is_covered(std::span<const TemporalModel> models, const ImageF& image, std::int64_t pixel,
                              double time);

}  // namespace patinate::analysis
