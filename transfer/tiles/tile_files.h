/// \file
/// What the items of a transfer by tile leave for one another: arrays of a tile's texels, row by row, as they lie in
/// memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "libcommon/core/mapped_file.h"
#include "transfer/synthesis/amounts.h"
#include "transfer/synthesis/passes.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/tile_grid.h"

namespace patinate::transfer {

/// Relative to the output folder; all below kJobWorkFolder.
namespace tile_file {
using Path = std::filesystem::path;
[[nodiscard]] Path texel_counts(int tile);                         ///< TriangleCount of its covered texels.
[[nodiscard]] Path values(std::size_t control, int tile);          ///< Floats.
[[nodiscard]] Path sorted(std::size_t control, int tile);          ///< Those of covered texels, sorted.
[[nodiscard]] Path targets(std::size_t level, int tile);           ///< std::uint16_t, a channel a control.
[[nodiscard]] Path links(std::size_t level, int tile);             ///< TexelLink, by target.
[[nodiscard]] Path places(std::size_t level, int pass, int tile);  ///< Before that pass, or round: see write_places().
[[nodiscard]] Path counts(std::size_t level, int pass, int tile);  ///< PlaceCounts before that pass.
[[nodiscard]] Path amounts(std::size_t level, int round, int tile);   ///< Amounts::Counts before that round.
[[nodiscard]] Path patience(std::size_t level, int round, int tile);  ///< RegionRefiner::patience() after it.
[[nodiscard]] Path borders(std::size_t level, int tile);              ///< BorderTexel, ascending.
/// Of the zones of a tile with higher ones, after that round's work on zones: see write_moved().
[[nodiscard]] Path moved(std::size_t level, int round, int tile);
[[nodiscard]] Path zone_patience(std::size_t level, int round, int tile);  ///< As patience(), zone after zone.
[[nodiscard]] Path coarse();                    ///< Places of the finest level that is not tiled.
[[nodiscard]] Path similar(std::size_t level);  ///< SimilarPixels.
[[nodiscard]] Path num_levels();                ///< One std::int64_t.
[[nodiscard]] Path figures(int tile);           ///< EnergyFigures.
}  // namespace tile_file

struct TriangleCount {
  std::int64_t triangle = 0, count = 0;
};

/// A texel that another one has beside it, where its grid does not say so.
struct TexelLink {
  TexelId target = -1, source = -1;
  friend auto operator<=>(const TexelLink&, const TexelLink&) = default;
};

/// Bytes of some arrays, one after another.
void write_arrays(const std::filesystem::path& file, std::initializer_list<std::span<const std::byte>> arrays);
template <class T>
void write_array(const std::filesystem::path& file, std::span<const T> values) {
  write_arrays(file, {std::as_bytes(values)});
}

/// Of a rectangle, row by row: pixels (-1 where nothing is covered), how far beside them, and the last turn in which
/// something changed nearby (empty: never).
void write_places(const std::filesystem::path& file, const TexelMap& map, const TexelRect& rect, const PlaceMap& places,
                  std::span<const std::uint8_t> changed_near);

/// Of some texels: which, their pixels, and how far beside them.
void write_moved(const std::filesystem::path& file, std::span<const TexelId> texels, const PlaceMap& places);
/// @param is_wanted  Of a texel: whether it is set.
void read_moved(const std::filesystem::path& file, PlaceMap& places, const std::function<bool(TexelId)>& is_wanted);

/// The places of a level in the files of its tiles, opened when one looks.
class StoredPlaces {
 public:
  /// @param file_of  Of each tile. @param rect_of  Its rectangle.
  StoredPlaces(std::function<std::filesystem::path(int tile)> file_of, std::function<TexelRect(int tile)> rect_of)
      : file_of_(std::move(file_of)), rect_of_(std::move(rect_of)) {}
  /// @param t  A texel of the tile's, at (x, y).
  void load(int tile, TexelId t, int x, int y, PlaceMap& places, std::span<std::uint8_t> changed_near);
  /// The texels of `part` that are the tile's. @param width  Of the level.
  void load(int tile, const TexelRect& part, int width, PlaceMap& places, std::span<std::uint8_t> changed_near);

 private:
  struct Tile {
    TexelRect rect;
    MappedFile file;
    std::span<const std::int32_t> pixels;
    std::span<const std::int8_t> beside;
    std::span<const std::uint8_t> changed_near;
  };
  Tile& open(int tile);
  std::function<std::filesystem::path(int)> file_of_;
  std::function<TexelRect(int)> rect_of_;
  std::map<int, Tile> tiles_;
};

void write_counts(const std::filesystem::path& file, const PlaceCounts& counts);
[[nodiscard]] PlaceCounts read_counts(const std::filesystem::path& file);
void write_amounts(const std::filesystem::path& file, const Amounts::Counts& counts);
[[nodiscard]] Amounts::Counts read_amounts(const std::filesystem::path& file);
void write_figures(const std::filesystem::path& file, const EnergyFigures& figures);
[[nodiscard]] EnergyFigures read_figures(const std::filesystem::path& file);

}  // namespace patinate::transfer
