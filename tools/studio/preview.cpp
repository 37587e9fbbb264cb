#include "tools/studio/preview.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/image/frame_stream.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::studio {

namespace {

constexpr std::int64_t kMaxPixels = 400'000'000;

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

/// At most so many pixels wide.
ImageF shrunk(ImageF image, int width) {
  const int w = std::clamp(width, 1, image.width());
  if (w == image.width()) return image;
  const std::int64_t h = std::int64_t{image.height()} * w / image.width();
  return downscale_area(image, w, static_cast<int>(std::clamp<std::int64_t>(h, 1, image.height())));
}

}  // namespace

ImageU8 preview_of(const std::filesystem::path& file, int width, std::optional<int> image) {
  if (image) return srgb8_from_linear(shrunk(color_of(FrameStream(file, {*image}).read(*image), Response{}), width));
  const ImageInfo info = probe_image(file);
  if (std::int64_t{info.width} * info.height > kMaxPixels)
    throw IoError(file.string(), "is too large to look at: " + size_text(info.width, info.height));
  const bool is_color = info.is_integer || info.is_raw || has_channel(info, "R");
  if (is_color) return srgb8_from_linear(shrunk(read_color(file), width));
  const bool is_map = has_channel(info, "X") && has_channel(info, "Y") && has_channel(info, "Z");
  const std::vector<std::string> channels =
      is_map ? std::vector<std::string>{"X", "Y", "Z"} : std::vector{info.channels.at(0)};
  return spread_out(shrunk(read_channels(file, channels), width));
}

}  // namespace patinate::studio
