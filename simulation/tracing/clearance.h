/// \file
/// Where a floating gammaton needs no rays: above which triangles there is nothing.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "patinate/core/run_control.h"
#include "simulation/tracing/ray_tracer.h"
#include "simulation/tracing/triangle_frames.h"

namespace patinate::simulation {

/// Whether the prism that stands on one side of a triangle, `height` high, is cut by no other triangle. Found when
/// first asked for; whoever asks, and when, the answer is the same. Thread-safe.
class Clearance {
 public:
  /// @param rays, frames  Outlive it.
  Clearance(const RayTracer& rays, const TriangleFrames& frames, int num_triangles, double height_mm);

  [[nodiscard]] bool is_clear(int triangle, bool is_front) {
    std::atomic<std::uint8_t>& known = known_[static_cast<std::size_t>(triangle) * 2 + (is_front ? 0 : 1)];
    const std::uint8_t value = known.load(std::memory_order_relaxed);
    if (value != kUnknown) return value == kClear;
    const bool found = find(triangle, is_front);
    known.store(found ? kClear : kCut, std::memory_order_relaxed);
    return found;
  }
  /// Of all triangles, both sides: 1 where is_clear(), else 0; by triangle, its front first.
  [[nodiscard]] std::vector<std::uint8_t> all(const RunControl& control);
  [[nodiscard]] double height_mm() const { return height_; }

 private:
  static constexpr std::uint8_t kUnknown = 0, kClear = 1, kCut = 2;
  [[nodiscard]] bool find(int triangle, bool is_front) const;

  const RayTracer* rays_;
  const TriangleFrames* frames_;
  int num_triangles_;
  double height_;
  std::unique_ptr<std::atomic<std::uint8_t>[]> known_;
};

}  // namespace patinate::simulation
