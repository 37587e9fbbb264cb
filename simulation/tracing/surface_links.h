/// \file
/// Which triangle lies beyond an edge: for gammatons that run over a surface.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// Triangles of one object that share an edge, by their corners' places: UV seams, hard edges and materials do not cut.
/// Where more than two meet, those that bend least are joined (triangle_neighbors()). 12 bytes a triangle.
class SurfaceLinks {
 public:
  struct Link {
    std::int32_t triangle = -1;  ///< -1: the surface ends here.
    std::size_t edge = 0;        ///< Of that triangle: from its corner `edge` to the next.
    bool is_turned = false;      ///< Its normal points to the other side: its edge runs the same way.
  };

  explicit SurfaceLinks(const SceneMesh& scene_mesh);

  /// Across the edge from corner k to the next.
  [[nodiscard]] Link across(int triangle, std::size_t k) const {
    const std::uint32_t code = codes_[static_cast<std::size_t>(triangle)][k];
    if (code == kNone) return {};
    return {.triangle = static_cast<std::int32_t>(code >> 3), .edge = code >> 1 & 3, .is_turned = (code & 1) != 0};
  }
  void prefetch([[maybe_unused]] int triangle) const {
#if defined(__GNUC__)
    if (triangle >= 0) __builtin_prefetch(&codes_[static_cast<std::size_t>(triangle)]);
#endif
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  std::vector<std::array<std::uint32_t, 3>> codes_;  ///< triangle << 3 | edge << 1 | is_turned.
};

}  // namespace patinate::simulation
