/// \file
/// How a movie's pictures are shown: turned, and with pixels that are not square. Inside of media only.
#pragma once

#include <cstdint>
#include <optional>

#include "libcommon/image/image_decoder.h"

struct AVFormatContext;
struct AVStream;

namespace patinate {

/// A quarter turn, perhaps mirrored: where the picture's x and y axis lie on the screen.
struct DisplayTurn {
  bool is_swapped = false;     ///< Columns become rows.
  bool is_x_reversed = false;  ///< Screen axis is reversed.
  bool is_y_reversed = false;

  [[nodiscard]] bool is_none() const { return !is_swapped && !is_x_reversed && !is_y_reversed; }
  friend bool operator==(const DisplayTurn&, const DisplayTurn&) = default;
};

/// Turn of a display matrix as libavutil has it (display.h). @returns nothing if it is no quarter turn
[[nodiscard]] std::optional<DisplayTurn> turn_of_matrix(const std::int32_t* matrix);
/// Turn that the file states for its pictures. @throws InvalidInput if it is no quarter turn
[[nodiscard]] DisplayTurn display_turn(const AVStream* stream);
[[nodiscard]] CodedImage turned(const CodedImage& image, const DisplayTurn& turn);

/// Columns of square pixels for pictures of so many columns; height stays, as players do.
/// @throws InvalidInput beyond 1 : 8 or 8 : 1
[[nodiscard]] int square_width(AVFormatContext* file, AVStream* stream, int width);

}  // namespace patinate
