// Photographs of crackle(): the plate under light.
#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "patinate/datasets/crackle.h"
#include "patinate/image/color.h"

namespace patinate::datasets {

namespace {

constexpr std::array<double, 3> kSubstrate = {0.030, 0.018, 0.011};  // A dark brown card behind the glass.
constexpr std::array<double, 3> kDirt = {0.62, 0.56, 0.47};          // Color that dirt along an edge leaves.
constexpr std::array<double, 3> kAged = {0.30, 0.42, 1.0};           // Yellowing per channel, times the option.
constexpr std::uint32_t kCameraNoise = 100;
constexpr std::int64_t kChunk = 16384;

// Share of a pixel that a straight band covers.
double band_share(double distance, double width) {
  return std::clamp(std::min(distance + 0.5, 0.5 * width) - std::max(distance - 0.5, -0.5 * width), 0.0, 1.0);
}

struct EdgeState {
  double crack = 0.0;  // Share of the pixel.
  double rim = 0.0;    // [0, 1]: how near a lifted edge is.
  double dirt = 0.0;
};

// Everything the cracks do at every pixel at a time.
std::vector<EdgeState> edge_states(const CrackleDataset& d, double time_s) {
  std::vector<EdgeState> states(static_cast<std::size_t>(d.thickness_mm.num_pixels()));
  for (const auto& i : d.influences) {
    const double open = crack_opening(d, time_s, static_cast<double>(i.start_s));
    if (!(open > 0.0)) continue;
    EdgeState& state = states[i.pixel];
    const double width = static_cast<double>(i.width_px) * open;
    const double distance = static_cast<double>(i.distance_px);
    state.crack = std::max(state.crack, band_share(distance, width));
    const double strength = open * std::min(1.0, 0.45 * static_cast<double>(i.width_px));
    const double away = std::max(0.0, distance - 0.5 * width);
    state.rim = std::max(state.rim, strength * std::exp(-away / (0.5 + 0.6 * static_cast<double>(i.width_px))));
    state.dirt = std::max(state.dirt, strength * std::exp(-away / (0.9 + 1.1 * static_cast<double>(i.width_px))));
  }
  return states;
}

}  // namespace

ImageF crack_share(const CrackleDataset& dataset, double time_s) {
  ImageF share(dataset.options.width, dataset.options.height);
  for (const auto& i : dataset.influences) {
    const double width =
        static_cast<double>(i.width_px) * crack_opening(dataset, time_s, static_cast<double>(i.start_s));
    float& value = share.values()[i.pixel];
    value = std::max(value, static_cast<float>(band_share(static_cast<double>(i.distance_px), width)));
  }
  return share;
}

ImageF reflected(const CrackleDataset& d, double time_s, const RunControl& control) {
  const int w = d.options.width, h = d.options.height;
  const std::vector<EdgeState> states = edge_states(d, time_s);
  const double age = std::clamp(time_s / d.duration_s(), 0.0, 1.0);
  const auto height_at = [&](int x, int y) {
    const EdgeState& s = states[static_cast<std::size_t>(std::clamp(y, 0, h - 1)) * static_cast<std::size_t>(w) +
                                static_cast<std::size_t>(std::clamp(x, 0, w - 1))];
    return s.rim * (1.0 - s.crack);
  };
  ImageF out(w, h, 3);
  parallel_for(d.thickness_mm.num_pixels(), kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p) {
      const int x = static_cast<int>(p % w), y = static_cast<int>(p / w);
      const EdgeState& s = states[p];
      // Edges curl up; light from the upper left.
      const double slope =
          0.5 * (height_at(x + 1, y) - height_at(x - 1, y) + height_at(x, y + 1) - height_at(x, y - 1));
      const double shade = 1.0 + std::clamp(0.55 * slope, -0.25, 0.25) + 0.06 * s.rim;
      for (int c = 0; c < 3; ++c) {
        const std::size_t i = c;
        const double aged = 1.0 - d.options.yellowing * age * kAged[i];
        const double dirt = 1.0 - 0.55 * s.dirt * (1.0 - kDirt[i]);
        const double paint = static_cast<double>(d.paint.at(x, y, c)) * aged * dirt * shade;
        out.at(x, y, c) = static_cast<float>(s.crack * kSubstrate[i] + (1.0 - s.crack) * paint);
      }
    }
  });
  return out;
}

ImageF transmitted(const CrackleDataset& d) {
  ImageF out = crack_share(d, d.duration_s());
  for (std::size_t i = 0; i < out.values().size(); ++i) {
    const double share = static_cast<double>(out.values()[i]);
    const double through = transmittance(d.options, static_cast<double>(d.thickness_mm.values()[i]));
    out.values()[i] =
        static_cast<float>(static_cast<double>(d.backlight.values()[i]) * (share + (1.0 - share) * through));
  }
  return out;
}

ImageU8 photograph(const ImageF& linear, double noise, std::int64_t seed, int picture) {
  ImageU8 codes(linear.width(), linear.height(), linear.channels());
  const std::size_t channels = linear.channels();
  for (std::size_t p = 0; p < static_cast<std::size_t>(linear.num_pixels()); ++p) {
    RandomStream random(static_cast<std::uint64_t>(seed), p, kCameraNoise + static_cast<std::uint32_t>(picture));
    for (std::size_t c = 0; c < channels; ++c) {
      const std::size_t i = p * channels + c;
      double code = static_cast<double>(srgb_from_linear(std::clamp(linear.values()[i], 0.0f, 1.0f)));
      if (noise > 0.0) code += noise * random.normal();
      codes.values()[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(code, 0.0, 1.0)));
    }
  }
  return codes;
}

}  // namespace patinate::datasets
