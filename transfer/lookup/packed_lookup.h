/// \file
/// Lookups at the speed of memory: where a texel looks as one number, and rows that continue in the source copied as
/// pieces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "libcommon/atlas/gutter_fill.h"
#include "libcommon/image/between_pixels.h"
#include "patinate/atlas/sheet.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// y * width + x of a pixel of the history; kNoValue outside the charts.
using PackedCoordinates = Image<std::uint32_t>;

/// A BesidePixel as one number, so that gutters are filled with it; kNoValue outside the charts.
[[nodiscard]] constexpr std::uint32_t pack_beside(BesidePixel b) {
  return std::uint32_t{static_cast<std::uint8_t>(b.x)} | std::uint32_t{static_cast<std::uint8_t>(b.y)} << 8;
}
[[nodiscard]] constexpr BesidePixel unpack_beside(std::uint32_t packed) {
  return {static_cast<std::int8_t>(packed & 0xFFu), static_cast<std::int8_t>(packed >> 8 & 0xFFu)};
}

/// Where some texels look.
struct PlacesView {
  std::span<const std::uint32_t> pixels;  ///< Pixels as PackedCoordinates.
  std::span<const std::uint32_t> beside;  ///< Fractions by pack_beside(); empty: all look at the middles of pixels.

  [[nodiscard]] std::size_t size() const { return pixels.size(); }
  [[nodiscard]] PlacesView part(std::size_t begin, std::size_t size) const {
    return {pixels.subspan(begin, size), beside.empty() ? beside : beside.subspan(begin, size)};
  }
};

/// Where all texels of an image look.
struct PackedPlaces {
  PackedCoordinates pixels;
  Image<std::uint32_t> beside;  ///< Fractions by pack_beside(); empty: all look at the middles of pixels.

  [[nodiscard]] PlacesView view() const { return {pixels.values(), beside.values()}; }
  friend bool operator==(const PackedPlaces&, const PackedPlaces&) = default;
};

/// @param coordinates   H x W x 2: places inside the source, whole numbers in the middles of pixels, or -1. Each is
/// checked. @param source_width,source_height  > 0.
/// @throws InvalidInput naming the first texel that points outside the source.
[[nodiscard]] PackedPlaces pack_coordinates(const ImageF& coordinates, int source_width, int source_height,
                                            const RunControl& control = {});

/// Fills gutters, and repeats borders over the margins, tile by tile, so that no tile bleeds into another.
void fill_sheet(Image<std::uint32_t>& values, const Sheet& sheet);
/// pack_coordinates() over all tiles of a sheet, filled by fill_sheet().
[[nodiscard]] PackedPlaces filled_places(const ImageF& coordinates, int source_width, int source_height,
                                         const Sheet& sheet);

/// Looks up rows as a file has them.
/// @param xy  Two a texel. @param first_row,width  Where the rows stand in the file, for the message.
/// @param beside  As many as pixels; empty: places must be middles of pixels.
/// @returns whether a place lies beside the middle of its pixel.
/// @throws IoError naming the texel that points outside the source, or between pixels that it must not.
bool pack_checked_rows(const std::filesystem::path& file, std::span<const float> xy, int first_row, int width,
                       int source_width, int source_height, std::span<std::uint32_t> pixels,
                       std::span<std::uint32_t> beside);

/// The source's pixel for every texel of `indices`; `outside` where it is kNoValue. Equal to gather() of
/// transfer_reader.h, the simple version.
/// @param source    Any width and height; 1 to 4 channels. @param indices  Inside the source.
/// @param out       indices.size() * channels values. On one thread.
/// @throws InvalidInput on other channels or sizes.
void gather_packed(const ImageF& source, std::span<const std::uint32_t> indices, float outside, std::span<float> out);
void gather_packed(const ImageU8& source, std::span<const std::uint32_t> indices, std::uint8_t outside,
                   std::span<std::uint8_t> out);

/// Looks up between pixels (look_between()); where a place is the middle of its pixel, the pixel's own values.
void gather_packed(const ImageF& source, const PlacesView& places, float outside, std::span<float> out);

/// Makes normals unit again where gather_packed() has made them between pixels. @param xyz  3 a texel.
void make_unit_between(const PlacesView& places, std::span<float> xyz);

/// gather_packed() for a whole image.
[[nodiscard]] ImageF gather_packed(const ImageF& source, const PackedCoordinates& indices, float outside = 0.0f,
                                   const RunControl& control = {});
[[nodiscard]] ImageF gather_packed(const ImageF& source, const PackedPlaces& places, float outside = 0.0f,
                                   const RunControl& control = {});
[[nodiscard]] ImageU8 gather_packed(const ImageU8& source, const PackedCoordinates& indices, std::uint8_t outside = 0,
                                    const RunControl& control = {});

}  // namespace patinate::transfer
