#include "transfer/guidance/painted_control.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"

namespace patinate::transfer {

std::string unreached_text(const BrushStroke& stroke) {
  return "a stroke reaches no texel: none lies within " + number_text(stroke.radius_mm) +
         " mm of its points, which are in mm on the transfer's mesh.obj";
}

SurfaceBrush::SurfaceBrush(const TexelMap& map, const RunControl& control) : map_(map) {
  const int columns = (map.width() + kSquare - 1) / kSquare, rows = (map.height() + kSquare - 1) / kSquare;
  std::vector<Square> all(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  std::vector<std::uint8_t> has_texels(all.size(), 0);
  parallel_for(static_cast<std::int64_t>(all.size()), 16, control.silent(), [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const int x = static_cast<int>(i % columns) * kSquare, y = static_cast<int>(i / columns) * kSquare;
      Square& square = all[i];
      square.texels = {x, y, std::min(x + kSquare, map.width()), std::min(y + kSquare, map.height())};
      for (int v = square.texels.y0; v < square.texels.y1; ++v) {
        for (int u = square.texels.x0; u < square.texels.x1; ++u) {
          const TexelId t = TexelId{v} * map.width() + u;
          if (!map.is_covered(t)) continue;
          const Vec3 p = map.position_mm(t);
          square.low = has_texels[i] == 0 ? p : Vec3(square.low.cwiseMin(p));
          square.high = has_texels[i] == 0 ? p : Vec3(square.high.cwiseMax(p));
          has_texels[i] = 1;
        }
      }
    }
  });
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (has_texels[i] != 0) squares_.push_back(all[i]);
  }
}

std::vector<SurfaceBrush::Reached> SurfaceBrush::around(const Vec3& point, double radius_mm) const {
  std::vector<Reached> reached;
  const double most = radius_mm * radius_mm;
  for (const Square& square : squares_) {
    const Vec3 outside = (square.low - point).cwiseMax(point - square.high).cwiseMax(0.0);
    if (!(outside.squaredNorm() < most)) continue;
    for (int y = square.texels.y0; y < square.texels.y1; ++y) {
      for (int x = square.texels.x0; x < square.texels.x1; ++x) {
        const TexelId t = TexelId{y} * map_.width() + x;
        if (!map_.is_covered(t)) continue;
        const double squared = (map_.position_mm(t) - point).squaredNorm();
        if (squared < most) reached.push_back({t, squared});
      }
    }
  }
  return reached;
}

TexelId SurfaceBrush::side_of(const Vec3& point, const std::vector<Reached>& reached) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Reached& r : reached) nearest = std::min(nearest, r.squared_mm);
  TexelId texel = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const Reached& r : reached) {
    if (r.squared_mm > 4.0 * nearest) continue;  // Up to twice as far.
    const double beside = std::abs((point - map_.position_mm(r.texel)).dot(map_.normal(r.texel)));
    if (beside < least || (beside == least && r.texel < texel)) least = beside, texel = r.texel;
  }
  return texel;
}

std::vector<BrushedTexel> SurfaceBrush::find(const BrushStroke& stroke, const RunControl& control) const {
  std::map<TexelId, double> kept;
  for (const std::array<double, 3>& p : stroke.points_mm) {
    control.throw_if_stopped();
    const Vec3 point(p[0], p[1], p[2]);
    const std::vector<Reached> reached = around(point, stroke.radius_mm);
    if (reached.empty()) continue;
    const Vec3 normal = map_.normal(side_of(point, reached));
    for (const Reached& r : reached) {
      if (!(map_.normal(r.texel).dot(normal) > 0.0)) continue;
      const double falloff = 1.0 - r.squared_mm / (stroke.radius_mm * stroke.radius_mm);
      kept.try_emplace(r.texel, 1.0).first->second *= 1.0 - stroke.flow * falloff * falloff;
    }
  }
  std::vector<BrushedTexel> texels;
  for (const auto& [texel, share] : kept) {
    if (share < 1.0) texels.push_back({texel, share});
  }
  return texels;
}

}  // namespace patinate::transfer
