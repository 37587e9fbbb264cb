#include "libcommon/media/movie_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>

#include "patinate/core/error.h"

extern "C" {
#include <libavformat/avformat.h>
}

namespace patinate {

std::optional<DisplayTurn> turn_of_matrix(const std::int32_t* matrix) {
  // (x, y) is shown at (a x + c y, b x + d y), and moved so that it begins at 0.
  const std::int64_t a = matrix[0], b = matrix[1], c = matrix[3], d = matrix[4];
  constexpr std::int64_t kRounding = 64;  // In 1/65536: writers compute it by sine and cosine.
  const auto is_zero = [](std::int64_t v) { return std::abs(v) <= kRounding; };
  const bool is_straight = is_zero(b) && is_zero(c), is_turned = is_zero(a) && is_zero(d);
  if (is_straight == is_turned) return std::nullopt;
  if (is_straight) return is_zero(a) || is_zero(d) ? std::nullopt : std::optional(DisplayTurn{false, a < 0, d < 0});
  return is_zero(b) || is_zero(c) ? std::nullopt : std::optional(DisplayTurn{true, c < 0, b < 0});
}

DisplayTurn display_turn(const AVStream* stream) {
  std::size_t size = 0;
  const auto* matrix =
      reinterpret_cast<const std::int32_t*>(av_stream_get_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, &size));
  if (matrix == nullptr || size < 9 * sizeof(std::int32_t)) return {};
  const auto turn = turn_of_matrix(matrix);
  if (!turn)
    throw InvalidInput(
        "is shown rotated by an angle that is no multiple of 90 degrees; convert it, so that its pictures lie upright");
  return *turn;
}

CodedImage turned(const CodedImage& image, const DisplayTurn& turn) {
  if (turn.is_none()) return image;
  CodedImage out = image;
  if (turn.is_swapped) std::swap(out.width, out.height);
  const std::size_t pixel = bytes_per_value(image.type) * static_cast<std::size_t>(image.channels);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const int across = turn.is_x_reversed ? out.width - 1 - x : x, down = turn.is_y_reversed ? out.height - 1 - y : y;
      const int from_x = turn.is_swapped ? down : across, from_y = turn.is_swapped ? across : down;
      const std::size_t from =
          static_cast<std::size_t>(from_y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(from_x);
      const std::size_t to =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(out.width) + static_cast<std::size_t>(x);
      std::copy_n(image.bytes.begin() + static_cast<std::ptrdiff_t>(from * pixel), pixel,
                  out.bytes.begin() + static_cast<std::ptrdiff_t>(to * pixel));
    }
  }
  return out;
}

int square_width(AVFormatContext* file, AVStream* stream, int width) {
  const AVRational aspect = av_guess_sample_aspect_ratio(file, stream, nullptr);
  if (aspect.num <= 0 || aspect.den <= 0) return width;
  const double ratio = static_cast<double>(aspect.num) / aspect.den;
  constexpr double kMost = 8.0;
  if (ratio > kMost || ratio < 1.0 / kMost) {
    throw InvalidInput("has pixels of " + std::to_string(aspect.num) + " : " + std::to_string(aspect.den) +
                       "; at most 8 : 1 is read");
  }
  return std::max(1, static_cast<int>(std::lround(width * ratio)));
}

}  // namespace patinate
