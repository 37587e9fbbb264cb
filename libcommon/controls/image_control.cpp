#include "libcommon/controls/image_control.h"

#include <algorithm>
#include <cmath>

#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate {

ImageF lay_over_tiles(const Sheet& sheet, std::span<const ImageF> images) {
  const auto count = static_cast<std::size_t>(sheet.num_tiles());
  if (images.size() != 1 && images.size() != count)
    throw InvalidInput("image control: one image, or one per tile, is needed");
  for (const ImageF& image : images) {
    if (image.empty() || image.channels() != 1) throw InvalidInput("image control: an image of one channel is needed");
  }
  ImageF laid(sheet.width(), sheet.height());
  for (std::size_t i = 0; i < count; ++i) {
    const ImageF& image = images.size() == 1 ? images.front() : images[i];
    paste_tile(laid, sheet, static_cast<int>(i), resize_bilinear(image, sheet.tile_width, sheet.tile_height));
  }
  return laid;
}

std::vector<std::filesystem::path> tile_map_files(const std::filesystem::path& path,
                                                  const std::vector<std::string>& tile_names) {
  std::error_code error;
  const bool has_place = path.filename().string().find("<UDIM>") != std::string::npos;
  if (!has_place && (tile_names.size() == 1 || std::filesystem::exists(path, error))) return {path};
  std::vector<std::filesystem::path> files;
  files.reserve(tile_names.size());
  for (const std::string& name : tile_names) files.push_back(tile_path(path, name));
  return files;
}

ControlMap image_map(const TexelMap& map, const ImageF& image) {
  if (image.empty() || image.channels() != 1) throw InvalidInput("image control: an image of one channel is needed");
  const auto values = image.values();
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) {
    throw InvalidInput("image control: the image holds NaN or infinity");
  }
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  ValueRange range;
  if (*least < 0.0F || *greatest > 1.0F) {
    range = {static_cast<double>(*least), static_cast<double>(*greatest)};
    if (!(range.high > range.low)) range.high = range.low + 1.0;
  }
  return normalized_control(resize_bilinear(image, map.width(), map.height()), map, range, "relative");
}

}  // namespace patinate
