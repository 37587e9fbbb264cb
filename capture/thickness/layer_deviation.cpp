#include "capture/thickness/layer_deviation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kSquares = 4.0;  ///< To a spatial sigma of the window.

/// The squares of one color that lie in the layer.
ImageU8 half_of(const ImageU8& known, int side, bool is_black) {
  ImageU8 half(known.width(), known.height());
  for (int y = 0; y < half.height(); ++y) {
    for (int x = 0; x < half.width(); ++x) {
      if (((x / side + y / side) % 2 == 1) == is_black) half.at(x, y) = known.at(x, y);
    }
  }
  return half;
}

}  // namespace

ImageF layer_deviation(const ImageF& transmittance, const ImageU8& known, const ThicknessOptions& options,
                       const RunControl& control) {
  if (!transmittance.same_size(known)) throw InvalidInput("thickness: the light and its mask differ in size");
  const double sigma = options.mode_filter.spatial_sigma_px;
  const int side = std::max(2, static_cast<int>(std::lround(sigma / kSquares)));
  const RunControl quiet = control.silent();
  std::array<ImageF, 2> filled;
  for (std::size_t h = 0; h < 2; ++h) {
    const ImageU8 half = half_of(known, side, h == 1);
    const auto values = half.values();
    if (std::all_of(values.begin(), values.end(), [](std::uint8_t v) { return v == 0; }))
      return ImageF(known.width(), known.height());
    const double begin = 0.45 * static_cast<double>(h);
    // Blurred, since both have to say something of every place.
    filled[h] =
        gaussian_blur(fill_cracks(transmittance, half, options, control.part(begin, begin + 0.45)), half, side, quiet);
  }
  ImageF squares(known.width(), known.height());
  for (std::int64_t i = 0; i < squares.num_pixels(); ++i) {
    const float half = 0.5f * (filled[0].data()[i] - filled[1].data()[i]);
    squares.data()[i] = half * half;
  }
  squares = gaussian_blur(squares, known, sigma, quiet);
  for (std::int64_t i = 0; i < squares.num_pixels(); ++i)
    squares.data()[i] = known.data()[i] != 0 ? std::sqrt(squares.data()[i]) : 0.0f;
  return squares;
}

}  // namespace patinate::capture
