#include "simulation/transport/splat.h"

#include <algorithm>

namespace patinate::simulation {

namespace {

constexpr int kMaxSteps = 4;  // 8^4 = kWhole: shares stay whole

/// round(radius / (texel's side / median side)), without a root: the largest h with (h - 1/2) side <= radius.
int num_steps(int radius, std::uint32_t weight) {
  const auto reach = static_cast<std::uint64_t>(4 * radius * radius) * SurfaceAtlas::kMedianWeight;
  int steps = 0;
  while (steps < kMaxSteps && static_cast<std::uint64_t>((2 * steps + 1) * (2 * steps + 1)) * weight <= reach) ++steps;
  return steps;
}

/// @returns where the share lies now.
std::uint32_t& add(Splat& splat, TexelIndex texel, std::uint32_t share) {
  int i = 0;
  while (i < splat.num_parts && splat.parts[static_cast<std::size_t>(i)].texel != texel) ++i;
  if (i == Splat::kMaxParts) i = 0;
  SplatPart& part = splat.parts[static_cast<std::size_t>(i)];
  if (i == splat.num_parts) {
    part = {texel, 0};
    ++splat.num_parts;
  }
  return part.share += share;
}

/// What one step of the walk takes over a link, of `share`. A link lets through what one between whole texels does,
/// whatever the chart's edge leaves of them: as much mass each way where texels hold mass in proportion to their areas,
/// so that even rain stays even.
std::uint32_t step_over(const SurfaceAtlas& surface, const SplatPart& from, const SurfaceAtlas::Link& link) {
  const std::uint32_t weight = surface.weight(from.texel), other = surface.weight(link.texel);
  const std::uint32_t whole = surface.weight_of_triangle(surface.triangle(from.texel)) +
                              surface.weight_of_triangle(surface.triangle(link.texel));
  const std::uint32_t twice = std::min(whole, 4 * std::min(weight, other));  // no more than a small one has
  return static_cast<std::uint32_t>(std::uint64_t{from.share} * link.count * twice / (std::uint64_t{32} * weight));
}

}  // namespace

Splat splat_of(const SurfaceAtlas& surface, TexelIndex texel, int width) {
  Splat splat;
  add(splat, texel, Splat::kWhole);
  const int steps = num_steps(width / 2, surface.weight_of_triangle(surface.triangle(texel)));
  std::array<SurfaceAtlas::Link, 4> plain;
  for (int s = 0; s < steps; ++s) {
    Splat next;
    for (int i = 0; i < splat.num_parts; ++i) {
      const SplatPart part = splat.parts[static_cast<std::size_t>(i)];
      std::uint32_t& stays = add(next, part.texel, part.share);
      for (const SurfaceAtlas::Link& link : surface.links(part.texel, plain)) {
        const std::uint32_t goes = std::min(stays, step_over(surface, part, link));
        if (goes == 0) continue;
        stays -= goes;
        add(next, link.texel, goes);
      }
    }
    splat = next;
  }
  return splat;
}

}  // namespace patinate::simulation
