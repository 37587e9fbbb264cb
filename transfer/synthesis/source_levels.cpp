#include "transfer/synthesis/source_levels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "patinate/atlas/direction_field.h"

namespace patinate::transfer {

int smallest_side(const History& history) {
  int side = std::min(history.facts().width, history.facts().height);
  for (const LibraryPart& part : history.facts().parts) side = std::min({side, part.width, part.height});
  return side;
}

int source_halvings(double texel_mm, double pixel_mm, int smallest_side) {
  // A level is halved where its pixels are nearer to the texel then, in logarithms.
  constexpr double kSqrt2 = 1.4142135623730951;
  int halvings = 0;
  for (; texel_mm > kSqrt2 * pixel_mm && (smallest_side >> (halvings + 1)) >= kSmallestSide; ++halvings)
    pixel_mm *= 2.0;
  return halvings;
}

SourcePlacement place_source(const TexelMap& map, std::shared_ptr<const FlowFrames> frames, double pixel_mm,
                             int halvings) {
  const double texel_mm = map.median_texel_size_mm();
  return {.frames = frames ? std::move(frames) : std::make_shared<const FlowFrames>(uv_frames(map)),
          .pixel_mm = std::ldexp(pixel_mm, halvings),
          .step_mm = 1.5 * texel_mm > pixel_mm ? texel_mm : pixel_mm};
}

ControlImage interleave(std::span<const ImageF> controls, const RunControl& control) {
  ControlImage result(controls[0].width(), controls[0].height(), static_cast<int>(controls.size()));
  for (std::size_t c = 0; c < controls.size(); ++c) {
    for (int y = 0; y < result.height(); ++y) {
      control.throw_if_stopped();
      for (int x = 0; x < result.width(); ++x) {
        const double value = std::clamp(static_cast<double>(controls[c].at(x, y)), 0.0, 1.0);
        result.at(x, y, static_cast<int>(c)) = static_cast<std::uint16_t>(std::floor(value * kControlSteps + 0.5));
      }
    }
  }
  return result;
}

ControlImage halve(const ControlImage& fine, int width, int height, const std::function<bool(int x, int y)>& counts,
                   const RunControl& control) {
  ControlImage coarse(width, height, fine.channels());
  for (int y = 0; y < height; ++y) {
    control.throw_if_stopped();
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < fine.channels(); ++c) {
        int sum = 0, n = 0;
        for (int dy = 0; dy < 2; ++dy) {
          for (int dx = 0; dx < 2; ++dx) {
            const int fx = 2 * x + dx, fy = 2 * y + dy;
            if (!fine.contains(fx, fy) || !counts(fx, fy)) continue;
            sum += fine.at(fx, fy, c);
            ++n;
          }
        }
        if (n > 0) coarse.at(x, y, c) = static_cast<std::uint16_t>((sum + n / 2) / n);
      }
    }
  }
  return coarse;
}

std::vector<ControlImage> source_control_levels(const AppearanceSpace& appearance, std::span<const ImageF> controls,
                                                const RunControl& control) {
  std::vector<ControlImage> levels{interleave(controls, control)};
  for (std::size_t l = 1; l < appearance.levels.size(); ++l) {
    const ImageU8& fine_mask = appearance.masks[l - 1];
    levels.push_back(halve(
        levels.back(), appearance.levels[l].width(), appearance.levels[l].height(),
        [&](int x, int y) { return fine_mask.at(x, y) != 0; }, control));
  }
  return levels;
}

}  // namespace patinate::transfer
