/// \file
/// The neighbours of all texels at one fixed list of offsets on the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "libcommon/atlas/texel_map.h"
#include "libcommon/core/run_control.h"

namespace patinate {

/// Neighbours of every texel at one fixed list of offsets: texels whose whole neighbourhood lies inside their chart are
/// computed by integer arithmetic, and only the bands along seams are stored.
class TexelNeighborhood {
 public:
  TexelNeighborhood(const TexelMap& map, std::vector<Vec2> offsets_mm, const RunControl& control = {});

  [[nodiscard]] std::size_t size() const { return offsets_mm_.size(); }
  /// Equal to map.gather(t, offsets, out) for every covered texel.
  void gather(TexelId t, std::span<TexelId> out) const;
  [[nodiscard]] std::int64_t num_stored() const { return num_stored_; }

 private:
  const TexelMap& map_;
  std::vector<Vec2> offsets_mm_;
  std::vector<std::int32_t> band_row_;  ///< Per texel: row of `stored_`, or -1 for the interior.
  std::vector<TexelId> stored_;
  std::int64_t num_stored_ = 0;
};

}  // namespace patinate
