/// \file
/// How far one can fly from a place in any direction without meeting a triangle.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "simulation/tracing/motion_facts.h"

namespace patinate::simulation {

/// A grid over a scene's box, at most 64 cells along its longest side; each cell knows how many cells around it are
/// empty.
class FreeSpace {
 public:
  explicit FreeSpace(const RayTracer& rays);

  /// Nothing lies nearer to `p` than this along any axis (in the maximum norm), mm; 0 where something may. Outside of
  /// the grid: 0.
  [[nodiscard]] double distance(const Vec3& p) const {
    return motion_types::free_distance(&facts_, empty_.data(), vector_of(p));
  }
  [[nodiscard]] double cell_mm() const { return facts_.cell; }
  [[nodiscard]] const SpaceFacts& facts() const { return facts_; }
  /// By cell: how many are empty on all sides of it, less than 256.
  [[nodiscard]] std::span<const std::uint8_t> empty() const { return empty_; }

 private:
  SpaceFacts facts_;
  std::vector<std::uint8_t> empty_;
};

}  // namespace patinate::simulation
