#include "simulation/transport/splat.h"

namespace patinate {

namespace {

constexpr int kMaxSteps = 4;  // 8^4 = kWhole: shares stay whole

/// round(radius / (texel's side / median side)), without a root: the largest h with (h - 1/2) side <= radius.
int num_steps(int radius, std::uint32_t weight) {
  const auto reach = static_cast<std::uint64_t>(4 * radius * radius) * SurfaceAtlas::kMedianWeight;
  int steps = 0;
  while (steps < kMaxSteps && static_cast<std::uint64_t>((2 * steps + 1) * (2 * steps + 1)) * weight <= reach) ++steps;
  return steps;
}

void add(Splat& splat, TexelIndex texel, std::uint32_t share) {
  for (int i = 0; i < splat.num_parts; ++i) {
    SplatPart& part = splat.parts[static_cast<std::size_t>(i)];
    if (part.texel == texel) {
      part.share += share;
      return;
    }
  }
  if (splat.num_parts == Splat::kMaxParts) {
    splat.parts[0].share += share;
  } else {
    splat.parts[static_cast<std::size_t>(splat.num_parts++)] = {texel, share};
  }
}

}  // namespace

Splat splat_of(const SurfaceAtlas& surface, TexelIndex texel, int width) {
  Splat splat;
  add(splat, texel, Splat::kWhole);
  const int steps = num_steps(width / 2, surface.weight(texel));
  for (int s = 0; s < steps; ++s) {
    Splat next;
    for (int i = 0; i < splat.num_parts; ++i) {
      const SplatPart part = splat.parts[static_cast<std::size_t>(i)];
      add(next, part.texel, part.share / 2);
      for (const TexelIndex neighbor : surface.neighbors(part.texel)) add(next, neighbor == kNoTexel ? part.texel : neighbor, part.share / 8);
    }
    splat = next;
  }
  return splat;
}

}  // namespace patinate
