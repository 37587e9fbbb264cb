#include "tools/studio/preview.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::studio {

namespace {

constexpr std::int64_t kMostPixels = 400'000'000;

bool has_channel(const ImageInfo& info, const char* name) {
  return std::find(info.channels.begin(), info.channels.end(), name) != info.channels.end();
}

/// Every channel over its own range of values.
ImageU8 spread_out(const ImageF& image) {
  ImageU8 codes(image.width(), image.height(), image.channels());
  for (int c = 0; c < image.channels(); ++c) {
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (std::int64_t i = c; i < static_cast<std::int64_t>(image.values().size()); i += image.channels()) {
      low = std::min(low, image.data()[i]);
      high = std::max(high, image.data()[i]);
    }
    const float scale = high > low ? 255.0f / (high - low) : 0.0f;
    for (std::int64_t i = c; i < static_cast<std::int64_t>(image.values().size()); i += image.channels()) {
      codes.data()[i] = static_cast<std::uint8_t>(std::floor((image.data()[i] - low) * scale + 0.5f));
    }
  }
  return codes;
}

}  // namespace

ImageU8 preview_of(const std::filesystem::path& file, int width) {
  const ImageInfo info = probe_image(file);
  if (std::int64_t{info.width} * info.height > kMostPixels)
    throw IoError(file.string(), "is too large to look at: " + size_text(info.width, info.height));
  const bool is_color = info.is_integer || info.is_raw || has_channel(info, "R");
  ImageF image;
  if (is_color) {
    image = read_color(file);
  } else if (has_channel(info, "X") && has_channel(info, "Y") && has_channel(info, "Z")) {
    image = read_channels(file, {"X", "Y", "Z"});
  } else {
    image = read_channels(file, {info.channels.at(0)});
  }
  const int w = std::clamp(width, 1, image.width());
  if (w < image.width()) {
    const auto h =
        static_cast<int>(std::clamp<std::int64_t>(std::int64_t{image.height()} * w / image.width(), 1, image.height()));
    image = downscale_area(image, w, h);
  }
  return is_color ? srgb8_from_linear(image) : spread_out(image);
}

}  // namespace patinate::studio
