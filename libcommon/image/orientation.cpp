#include "libcommon/image/orientation.h"

#include <cstring>
#include <utility>

namespace patinate {

CodedImage upright(CodedImage stored, int orientation) {
  if (orientation <= 1 || orientation > 8) return stored;
  CodedImage turned = stored;
  const bool is_transposed = is_transposing(orientation);
  if (is_transposed) std::swap(turned.width, turned.height);
  // Where the stored picture is read from its end, along its own axes.
  const bool is_x_back = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool is_y_back = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const std::size_t pixel = static_cast<std::size_t>(stored.channels) * bytes_per_value(stored.type);
  std::byte* to = turned.bytes.data();
  for (int y = 0; y < turned.height; ++y) {
    for (int x = 0; x < turned.width; ++x, to += pixel) {
      int from_x = is_transposed ? y : x, from_y = is_transposed ? x : y;
      if (is_x_back) from_x = stored.width - 1 - from_x;
      if (is_y_back) from_y = stored.height - 1 - from_y;
      const std::size_t at =
          static_cast<std::size_t>(from_y) * static_cast<std::size_t>(stored.width) + static_cast<std::size_t>(from_x);
      std::memcpy(to, stored.bytes.data() + at * pixel, pixel);
    }
  }
  return turned;
}

}  // namespace patinate
