/// \file
/// Lookups at the speed of memory: where a texel looks as one number, and rows that continue in the source copied as
/// pieces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "libcommon/atlas/gutter_fill.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// y * width + x of a pixel of the history; kNoValue outside the charts.
using PackedCoordinates = Image<std::uint32_t>;

/// @param coordinates  H x W x 2, whole numbers inside the source, or -1. @param source_width  > 0.
[[nodiscard]] PackedCoordinates pack_coordinates(const ImageF& coordinates, int source_width,
                                                 const RunControl& control = {});

/// The same of anyone's numbers, each checked. @throws InvalidInput naming the first texel that points outside the
/// source or between its pixels.
[[nodiscard]] PackedCoordinates pack_checked_coordinates(const ImageF& coordinates, int source_width, int source_height,
                                                         const RunControl& control = {});

/// The same of rows as a file has them.
/// @param xy  Two a texel. @param first_row,width  Where the rows stand in the file, for the message.
/// @throws IoError naming the texel that points outside the source or between its pixels.
void pack_checked_rows(const std::filesystem::path& file, std::span<const float> xy, int first_row, int width,
                       int source_width, int source_height, std::span<std::uint32_t> indices);

/// The source's pixel for every texel of `indices`; `outside` where it is kNoValue. Equal to gather() of
/// transfer_reader.h, the simple version.
/// @param source    Any width and height; 1 to 4 channels. @param indices  Inside the source.
/// @param out       indices.size() * channels values. On one thread.
/// @throws InvalidInput on other channels or sizes.
void gather_packed(const ImageF& source, std::span<const std::uint32_t> indices, float outside, std::span<float> out);
void gather_packed(const ImageU8& source, std::span<const std::uint32_t> indices, std::uint8_t outside,
                   std::span<std::uint8_t> out);

/// The same for a whole image.
[[nodiscard]] ImageF gather_packed(const ImageF& source, const PackedCoordinates& indices, float outside = 0.0f,
                                   const RunControl& control = {});
[[nodiscard]] ImageU8 gather_packed(const ImageU8& source, const PackedCoordinates& indices, std::uint8_t outside = 0,
                                    const RunControl& control = {});

}  // namespace patinate::transfer
