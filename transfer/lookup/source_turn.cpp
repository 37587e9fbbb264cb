#include "transfer/lookup/source_turn.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "libcommon/atlas/gutter_fill.h"
#include "patinate/core/error.h"
#include "transfer/files/flow_io.h"

namespace patinate::transfer {

namespace {

constexpr std::uint32_t kSteps = 1u << 20;  ///< Steps of a full turn in the packed angle.

struct Axes {
  float x_u, x_v, y_u, y_v;
};

Axes axes_of(std::uint32_t turn) {
  const double angle = 2.0 * std::numbers::pi * static_cast<double>(turn % kSteps) / kSteps;
  const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
  const float side = turn >= kSteps ? -1.0f : 1.0f;
  return {c, s, -side * s, side * c};
}

}  // namespace

std::uint32_t pack_turn(float angle, bool is_mirrored) {
  const double turns = static_cast<double>(angle) / (2.0 * std::numbers::pi);
  const auto step = static_cast<std::int64_t>(std::llround((turns - std::floor(turns)) * kSteps));
  return static_cast<std::uint32_t>(step % kSteps) + (is_mirrored ? kSteps : 0);
}

void pack_checked_turns(const std::filesystem::path& file, std::span<const float> angle_mirror, int first_row,
                        int width, std::span<const std::uint32_t> indices, std::span<std::uint32_t> turns) {
  for (std::size_t i = 0; i < turns.size(); ++i) {
    turns[i] = kNoValue;
    if (indices[i] == kNoValue) continue;
    const float angle = angle_mirror[2 * i], mirror = angle_mirror[2 * i + 1];
    if ((mirror != 0.0f && mirror != 1.0f) || !(std::abs(angle) < 1e6f)) {
      const auto w = static_cast<std::size_t>(width);
      throw IoError(
          file.string(),
          "texel (" + std::to_string(i % w) + ", " + std::to_string(static_cast<std::size_t>(first_row) + i / w) +
              ") has no rotation (`source.angle` in radians, `source.mirror` 0 or 1); make the transfer again");
    }
    turns[i] = pack_turn(angle, mirror == 1.0f);
  }
}

Image<std::uint32_t> packed_turns(const TexelMap& map, const FlowFrames& frames, std::span<const std::int16_t> turns) {
  Image<std::uint32_t> packed(map.width(), map.height(), 1, kNoValue);
  ImageF row(map.width(), 1, 4);
  for (int y = 0; y < map.height(); ++y) {
    put_patch(row, 0, y, map, frames,
              [&](TexelId t) { return SourcePlace{.turn = turns.empty() ? std::int16_t{0} : turns[t]}; });
    for (int x = 0; x < map.width(); ++x) {
      if (map.is_covered(TexelId{y} * map.width() + x))
        packed.at(x, y) = pack_turn(row.at(x, 0, 2), row.at(x, 0, 3) == 1.0f);
    }
  }
  return packed;
}

void turn_normals(std::span<const std::uint32_t> turns, std::span<float> xyz) {
  std::uint32_t known = 0;  // Neighbors mostly lie alike.
  Axes axes = axes_of(0);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    if (turns[i] == kNoValue) continue;
    if (turns[i] != known) {
      known = turns[i];
      axes = axes_of(known);
    }
    const float x = xyz[3 * i], y = xyz[3 * i + 1];
    xyz[3 * i] = x * axes.x_u + y * axes.y_u;
    xyz[3 * i + 1] = x * axes.x_v + y * axes.y_v;
  }
}

void normal_codes(std::span<const float> xyz, std::span<std::uint8_t> codes) {
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes[i] =
        static_cast<std::uint8_t>(std::clamp(128.0f + 127.5f * xyz[i], 0.0f, 255.0f));  // Rounded: 127.5 and a half.
  }
}

}  // namespace patinate::transfer
