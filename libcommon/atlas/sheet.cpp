#include "patinate/atlas/sheet.h"

#include <cmath>
#include <string_view>
#include <utility>

#include "patinate/core/error.h"

namespace patinate {

Vec2 Sheet::sheet_uv(int tile, const Vec2& uv) const {
  if (num_tiles() == 1) return uv;
  return {(first_x(tile) + uv.x() * tile_width) / width(),
          1.0 - (first_y(tile) + (1.0 - uv.y()) * tile_height) / height()};
}

Sheet make_sheet(std::vector<std::string> names, int resolution, std::int64_t most) {
  if (names.empty() || resolution < 1) throw InvalidInput("an atlas needs at least one tile and one texel");
  Sheet sheet{.tile_width = resolution, .tile_height = resolution, .columns = 1, .names = std::move(names)};
  const auto count = static_cast<std::int64_t>(sheet.names.size());
  const std::int64_t side = resolution + 2 * sheet.margin();
  while (std::int64_t{sheet.columns} * sheet.columns < count) ++sheet.columns;
  if (std::int64_t{sheet.columns} * sheet.rows() * side * side > most) {
    const auto fits =
        static_cast<int>(std::sqrt(static_cast<double>(most) / (double{1} * sheet.columns * sheet.rows())));
    throw InvalidInput(std::to_string(count) + " tiles of " + std::to_string(resolution) + " x " +
                       std::to_string(resolution) + " texels are too many; use a --resolution of at most " +
                       std::to_string(fits - 2 * sheet.margin()));
  }
  return sheet;
}

std::filesystem::path tile_path(const std::filesystem::path& path, const std::string& tile_name) {
  constexpr std::string_view kPlace = "<UDIM>";
  std::string name = path.filename().string();
  if (const std::size_t at = name.find(kPlace); at != std::string::npos) {
    return path.parent_path() / name.replace(at, kPlace.size(), tile_name.empty() ? "1001" : tile_name);
  }
  if (tile_name.empty()) return path;
  return path.parent_path() / (path.stem().string() + "." + tile_name + path.extension().string());
}

}  // namespace patinate
