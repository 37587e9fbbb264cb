#include <algorithm>
#include <utility>

#include "analysis/evaluation/map_figures.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"

namespace patinate::analysis {

namespace {

constexpr int kLongestPicture = 1600;       ///< Longest side of the whole sheet, pixels.
constexpr float kGrayBetweenTiles = 0.18f;  ///< Between tiles.
constexpr int kGap = 2;

/// Size of a tile's picture.
struct TileSize {
  int width = 0, height = 0;
};
TileSize tile_size(const Sheet& sheet) {
  const int columns = std::max(sheet.columns, sheet.rows());
  const int longest = std::max(1, kLongestPicture / columns - kGap),
            side = std::max(sheet.tile_width, sheet.tile_height);
  const auto limited = [&](int n) {
    return side <= longest ? n : std::max(1, static_cast<int>(std::int64_t{n} * longest / side));
  };
  return {limited(sheet.tile_width), limited(sheet.tile_height)};
}

}  // namespace

ImageF tile_picture(ImageF picture, const Sheet& sheet, const RunControl& control) {
  if (sheet.num_tiles() == 1) return picture;
  const TileSize size = tile_size(sheet);
  picture = crop(picture, sheet.margin(), sheet.margin(), sheet.tile_width, sheet.tile_height);
  return size.width == sheet.tile_width ? picture : downscale_area(picture, size.width, size.height, control);
}

std::vector<Picture> sheet_pictures(std::vector<std::vector<Picture>> parts, const Sheet& sheet) {
  if (sheet.num_tiles() == 1) return std::move(parts.front());
  const TileSize size = tile_size(sheet);
  std::vector<Picture> out;
  for (std::size_t p = 0; p < parts.front().size(); ++p) {
    Picture whole{.name = parts.front()[p].name,
                  .caption = parts.front()[p].caption,
                  .image = ImageF(sheet.columns * (size.width + kGap) - kGap,
                                  sheet.rows() * (size.height + kGap) - kGap, 3, kGrayBetweenTiles)};
    if (size.width < sheet.tile_width)
      whole.caption += " (tiles of " + size_text(sheet.tile_width, sheet.tile_height) + ", shown at " +
                       size_text(size.width, size.height) + ")";
    for (std::size_t tile = 0; tile < parts.size(); ++tile) {
      const int x0 = static_cast<int>(tile) % sheet.columns * (size.width + kGap),
                y0 = static_cast<int>(tile) / sheet.columns * (size.height + kGap);
      const ImageF& from = parts[tile][p].image;
      for (int y = 0; y < from.height(); ++y)
        std::copy(from.row(y).begin(), from.row(y).end(), whole.image.pixel(x0, y0 + y).data());
    }
    out.push_back(std::move(whole));
  }
  return out;
}

}  // namespace patinate::analysis
