/// \file
/// An atlas of several tiles (UDIM, or a square per material) as one grid of texels: the tiles side by side.
#pragma once

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate {

/// Tiles of one size in rows, the first at the top left. A single tile is the whole sheet; several have a margin of
/// kTileMargin texels around each, which nothing covers, so that filtering at a tile's border never reaches the next
/// one.
struct Sheet {
  int tile_width = 0;   ///< Texels.
  int tile_height = 0;  ///< Texels.
  int columns = 1;
  std::vector<std::string> names = {""};  ///< One a tile: "1001", a material's name; "" for a tile alone.

  static constexpr int kMaxSide = 65536;  ///< Texels, of a whole sheet.
  static constexpr int kTileMargin = 2;
  static constexpr std::int64_t kMaxTexels = std::int64_t{1} << 28;  ///< Limit for all tiles together: 16384 x 16384.

  static constexpr std::int64_t kMaxPartTexels = std::int64_t{1}
                                                 << 31;  ///< Limit if no process holds more than a part of the texels.

  [[nodiscard]] int num_tiles() const { return static_cast<int>(names.size()); }
  [[nodiscard]] int margin() const { return num_tiles() > 1 ? kTileMargin : 0; }
  [[nodiscard]] int rows() const { return (num_tiles() + columns - 1) / columns; }
  [[nodiscard]] int width() const { return columns * (tile_width + 2 * margin()); }
  [[nodiscard]] int height() const { return rows() * (tile_height + 2 * margin()); }
  /// The sheet's texel where a tile begins.
  [[nodiscard]] int first_x(int tile) const { return tile % columns * (tile_width + 2 * margin()) + margin(); }
  [[nodiscard]] int first_y(int tile) const { return tile / columns * (tile_height + 2 * margin()) + margin(); }
  /// UV over the whole sheet, of a UV in the unit square of a tile. Exactly the same for a tile alone.
  [[nodiscard]] Vec2 sheet_uv(int tile, const Vec2& uv) const;
};

/// The squarest sheet of `names.size()` tiles of `resolution` x `resolution` texels.
/// @throws InvalidInput if there are no names or more than `most` texels.
[[nodiscard]] Sheet make_sheet(std::vector<std::string> names, int resolution, std::int64_t most = Sheet::kMaxTexels);

/// The texels of one tile. @param image  Of the sheet's size.
template <class T>
[[nodiscard]] Image<T> cut_tile(const Image<T>& image, const Sheet& sheet, int tile) {
  Image<T> out(sheet.tile_width, sheet.tile_height, image.channels());
  for (int y = 0; y < out.height(); ++y) {
    const std::span<const T> from = image.row(sheet.first_y(tile) + y);
    const auto channels = static_cast<std::size_t>(image.channels());
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(sheet.first_x(tile)) * channels),
                out.row(y).size(), out.row(y).begin());
  }
  return out;
}

/// Puts a tile in its place, its outermost texels repeated over its margin. @param image  Of the sheet's size.
template <class T>
void paste_tile(Image<T>& image, const Sheet& sheet, int tile, const Image<T>& values) {
  const int m = sheet.margin(), x0 = sheet.first_x(tile), y0 = sheet.first_y(tile);
  for (int y = -m; y < sheet.tile_height + m; ++y) {
    for (int x = -m; x < sheet.tile_width + m; ++x) {
      const auto from = values.pixel(std::clamp(x, 0, sheet.tile_width - 1), std::clamp(y, 0, sheet.tile_height - 1));
      std::copy(from.begin(), from.end(), image.pixel(x0 + x, y0 + y).begin());
    }
  }
}

/// File of one tile: `<UDIM>` in the name gives way to the tile's name ("1001" for a tile that has none); without it
/// the name goes before the extension, tex.png to tex.1002.png; a tile without name keeps the path.
[[nodiscard]] std::filesystem::path tile_path(const std::filesystem::path& path, const std::string& tile_name);

}  // namespace patinate
