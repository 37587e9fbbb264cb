#include "libcommon/controls/smooth_surface.h"

#include <algorithm>
#include <utility>

#include "patinate/atlas/dilate.h"

namespace patinate {

SmoothSurface::SmoothSurface(const TexelMap& map, double max_edge_mm, int max_triangles, const RunControl& control)
    : map_(map) {
  Mesh fine =
      refine_edges(map.mesh(), max_edge_mm, std::max(max_triangles, map.mesh().num_triangles()), RefineShape::Curved);
  control.throw_if_stopped();
  control.report(0.5);
  fine_ = std::make_unique<const TexelMap>(std::move(fine), map.width(), map.height(), control.part(0.5, 1.0));
}

std::optional<SurfacePoint> SmoothSurface::point(TexelId t) const {
  if (!fine_->is_covered(t)) return std::nullopt;
  return fine_->point(t);
}

Vec3 SmoothSurface::position_mm(TexelId t) const {
  return fine_->is_covered(t) ? fine_->position_mm(t) : map_.position_mm(t);
}

Vec3 SmoothSurface::normal(TexelId t) const { return fine_->is_covered(t) ? fine_->normal(t) : map_.normal(t); }

ImageF SmoothSurface::to_texels(const std::vector<double>& values) const {
  ImageF image(map_.width(), map_.height());
  for (TexelId t = 0; t < fine_->num_texels(); ++t) {
    if (!fine_->is_covered(t)) continue;
    const SurfacePoint p = fine_->point(t);
    const Triangle& corners = mesh().triangles[p.triangle];
    const auto at = [&](std::size_t k) { return values[corners[k]]; };
    image.values()[t] = static_cast<float>((1.0 - p.b1 - p.b2) * at(0) + p.b1 * at(1) + p.b2 * at(2));
  }
  fill_gaps(image);
  return image;
}

void SmoothSurface::fill_gaps(ImageF& image) const { dilate(image, fine_->coverage(), -1); }

}  // namespace patinate
