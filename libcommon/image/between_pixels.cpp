#include "libcommon/image/between_pixels.h"

#include <span>
#include <string>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

template <std::size_t kChannels>
void look_up_row(const ImageF& source, std::span<const float> xy, std::span<float> out) {
  for (std::size_t x = 0; x < xy.size() / 2; ++x) {
    if (xy[2 * x] < 0.0f) continue;
    look_at<kChannels>(source.data(), source.width(), source.height(), xy[2 * x], xy[2 * x + 1], &out[kChannels * x]);
  }
}

}  // namespace

ImageF look_up(const ImageF& source, const ImageF& coordinates, float outside, const RunControl& control) {
  using LookUpRow = void (*)(const ImageF&, std::span<const float>, std::span<float>);
  constexpr std::array<LookUpRow, 4> kByChannels{look_up_row<1>, look_up_row<2>, look_up_row<3>, look_up_row<4>};
  const auto channels = static_cast<std::size_t>(source.channels());
  if (channels < 1 || channels > kByChannels.size())
    throw InvalidInput("lookup: a source of " + std::to_string(channels) + " channels; use 1 to 4");
  ImageF result(coordinates.width(), coordinates.height(), source.channels(), outside);
  parallel_for(coordinates.height(), 64, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
      kByChannels[channels - 1](source, coordinates.row(y), result.row(y));
  });
  return result;
}

}  // namespace patinate
