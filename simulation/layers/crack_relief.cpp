#include "simulation/layers/crack_relief.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "libcommon/core/portable_math.h"

namespace patinate::simulation {

namespace {

constexpr std::size_t kRays = 16;
constexpr double kReach = 4.0;    ///< Lengths: beyond, a crack takes less than 2 %.
constexpr float kBehind = -0.1F;  ///< Cosine of the way and a ray that looks back.
constexpr float kMiddleOfStep = 0.5F;

using Rays = std::array<SurfaceVector, kRays>;

Rays ray_directions() {
  Rays rays;
  for (std::size_t i = 0; i < kRays; ++i) {
    const SineCosine at = portable_sine_cosine(static_cast<double>(i) / kRays);
    rays[i] = {static_cast<float>(at.cosine), static_cast<float>(at.sine)};
  }
  return rays;
}

float dot(const SurfaceVector& a, const SurfaceVector& b) { return a[0] * b[0] + a[1] * b[1]; }

/// Distance along a ray to where the layer ends; negative: it does not within reach.
float distance_to_end(const LayerAtlas& layers, int layer, ChartWalk walk, float reach_mm) {
  constexpr float kNone = -1.0F;
  float mm = 0.0F;
  while (mm < reach_mm) {
    const float step = walk.step_mm();
    const float middle = mm + kMiddleOfStep * step;
    if (!walk.advance() || layers.is_open(layer, walk.texel())) return middle;
    const std::array<TexelIndex, 2>& beside = walk.beside();
    if (beside[0] != kNoTexel && layers.is_open(layer, beside[0]) && layers.is_open(layer, beside[1])) return middle;
    mm += step;
  }
  return kNone;
}

/// An end of the layer, as seen from the place: its normal, and what it takes along that.
struct End {
  SurfaceVector at, normal;
  float share;
};

/// Seen along one ray, with the normal to the line through what a ray beside it has met at the most similar distance.
End end_of(std::size_t ray, const Rays& rays, const std::array<float, kRays>& distances, double length_mm) {
  const auto at = [&](std::size_t i) { return SurfaceVector{distances[i] * rays[i][0], distances[i] * rays[i][1]}; };
  End end{.at = at(ray), .normal = rays[ray], .share = 0.0F};
  std::optional<std::size_t> other;
  for (const std::size_t i : {(ray + 1) % kRays, (ray + kRays - 1) % kRays}) {
    if (distances[i] < 0.0F) continue;
    if (!other || std::abs(distances[i] - distances[ray]) < std::abs(distances[*other] - distances[ray])) other = i;
  }
  if (other) {
    const SurfaceVector to = at(*other), along{to[0] - end.at[0], to[1] - end.at[1]};
    const float length = std::sqrt(dot(along, along));
    constexpr float kLeast = 1e-6F;
    if (length > kLeast) end.normal = {along[1] / length, -along[0] / length};
    if (dot(end.normal, end.at) < 0.0F) end.normal = {-end.normal[0], -end.normal[1]};
  }
  end.share = static_cast<float>(portable_exp(-static_cast<double>(dot(end.at, end.normal)) / length_mm));
  return end;
}

float share_along(const SurfaceVector& axis, std::span<const End> ends) {
  float before = 0.0F, behind = 0.0F;
  for (const End& end : ends) {
    const float cosine = dot(axis, end.normal);
    float& side = dot(axis, end.at) > 0.0F ? before : behind;
    side = std::max(side, end.share * cosine * cosine);
  }
  return (before + behind) / (1.0F + before * behind);
}

}  // namespace

namespace {

/// Of a layer that cracks.
const LayerCracks& cracks_of(const LayerAtlas& layers, int layer, TexelIndex texel) {
  return *layers.cracks(layers.surface().object(layers.surface().triangle(texel)), layer);
}

double thickness_mm(const LayerAtlas& layers, int layer, TexelIndex texel) {
  constexpr double kMmPerQuantum = 1e-3 / LayerAtlas::kQuantaPerUm;
  return layers.thickness().amount(layer, texel) * kMmPerQuantum;
}

double strain_at(const LayerAtlas& layers, int layer, TexelIndex texel) {
  return cracks_of(layers, layer, texel).shrinkage * layers.stress().amount(layer, texel) / kAmountOne;
}

bool holds(const LayerAtlas& layers, int layer, TexelIndex texel) {
  return !layers.is_open(layer, texel) && (layers.loose()[texel] >> layer & 1) == 0;
}

struct Offset {
  int x, y;
  double length;
};

/// Within kLiftTexels, the nearest first.
const std::vector<Offset>& offsets_by_length() {
  static const std::vector<Offset> offsets = [] {
    std::vector<Offset> all;
    for (int y = -kLiftTexels; y <= kLiftTexels; ++y) {
      for (int x = -kLiftTexels; x <= kLiftTexels; ++x) {
        const double length = std::sqrt(static_cast<double>(x * x + y * y));
        if (length <= kLiftTexels) all.push_back({x, y, length});
      }
    }
    std::stable_sort(all.begin(), all.end(), [](const Offset& a, const Offset& b) { return a.length < b.length; });
    return all;
  }();
  return offsets;
}

/// Texels to where the layer holds; kLiftTexels where that is farther.
double texels_to_hold(const LayerAtlas& layers, int layer, TexelIndex texel) {
  const SurfaceAtlas& surface = layers.surface();
  const TileGrid& grid = surface.grid();
  const int x = grid.x(texel), y = grid.y(texel), chart = surface.charts()[surface.triangle(texel)];
  for (const Offset& o : offsets_by_length()) {
    if (x + o.x < 0 || y + o.y < 0 || x + o.x >= grid.width || y + o.y >= grid.height) continue;
    const TexelIndex t = grid.index(x + o.x, y + o.y);
    if (surface.is_covered(t) && surface.charts()[surface.triangle(t)] == chart && holds(layers, layer, t))
      return o.length;
  }
  return kLiftTexels;
}

}  // namespace

double lift_mm(const LayerAtlas& layers, int layer, TexelIndex texel) {
  const double x = texels_to_hold(layers, layer, texel) * layers.surface().median_texel_size_mm();
  return 0.5 * x * std::min(1.0, x * strain_at(layers, layer, texel) / thickness_mm(layers, layer, texel));
}

double relief_length_mm(const LayerAtlas& layers, int layer, TexelIndex texel) {
  return std::max(kLeastTexels * layers.surface().median_texel_size_mm(),
                  cracks_of(layers, layer, texel).relief * thickness_mm(layers, layer, texel));
}

double crack_width_mm(const LayerAtlas& layers, int layer, TexelIndex texel) {
  return 2.0 * strain_at(layers, layer, texel) * cracks_of(layers, layer, texel).relief *
         thickness_mm(layers, layer, texel);
}

namespace {

/// What is left of a stress that is another one along an axis, by its tensor T = I + (ratio - 1) axis axis^T, in place
/// of I. With D = what is left of I it is sqrt(D) T sqrt(D): where the axis is one of D's, the product along each.
Relief with_tension(const Relief& relief, const SurfaceVector& axis, float ratio) {
  const SurfaceVector& one = relief.across;
  const SurfaceVector other{-one[1], one[0]};
  const float left_one = std::max(0.0F, 1.0F - relief.most), left_other = std::max(0.0F, 1.0F - relief.least);
  const float along_one = dot(axis, one), along_other = dot(axis, other), more = ratio - 1.0F;
  const float m11 = left_one * (1.0F + more * along_one * along_one);
  const float m22 = left_other * (1.0F + more * along_other * along_other);
  const float m12 = std::sqrt(left_one * left_other) * more * along_one * along_other;
  const float mean = 0.5F * (m11 + m22), half = 0.5F * (m11 - m22), radius = std::sqrt(half * half + m12 * m12);
  Relief out{.across = one, .most = 1.0F - (mean - radius), .least = 1.0F - (mean + radius), .nearest = relief.nearest};
  // The axis of the least: of two rows that say the same the one that is not nearly 0.
  const SurfaceVector least = half < 0.0F ? SurfaceVector{radius - half, -m12} : SurfaceVector{-m12, radius + half};
  const float length = std::sqrt(dot(least, least));
  constexpr float kLeast = 1e-6F;
  if (length > kLeast)
    out.across = {(least[0] * one[0] + least[1] * other[0]) / length,
                  (least[0] * one[1] + least[1] * other[1]) / length};
  return out;
}

/// As cracks and edges leave it of a stress that is alike in all directions.
Relief even_relief(std::span<const End> ends) {
  if (ends.empty()) return {};
  const End& first =
      *std::max_element(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.share < b.share; });
  const SurfaceVector other{-first.normal[1], first.normal[0]};
  Relief relief{.across = first.normal,
                .most = share_along(first.normal, ends),
                .least = share_along(other, ends),
                .nearest = first.share};
  if (relief.least > relief.most) {
    relief.across = other;
    std::swap(relief.most, relief.least);
  }
  return relief;
}

}  // namespace

Relief relief_at(const LayerAtlas& layers, int layer, TexelIndex texel, std::array<float, 2> place, double length_mm,
                 const SurfaceVector* ahead) {
  static const Rays rays = ray_directions();
  const auto reach_mm = static_cast<float>(kReach * length_mm);
  std::array<float, kRays> distances;
  for (std::size_t i = 0; i < kRays; ++i) {
    const bool is_behind = ahead != nullptr && dot(rays[i], *ahead) < kBehind;
    distances[i] = is_behind
                       ? -1.0F
                       : distance_to_end(layers, layer, ChartWalk(layers.surface(), texel, place, rays[i]), reach_mm);
  }
  std::array<End, kRays> ends;
  std::size_t num_ends = 0;
  for (std::size_t i = 0; i < kRays; ++i) {
    if (distances[i] >= 0.0F) ends[num_ends++] = end_of(i, rays, distances, length_mm);
  }
  const Relief relief = even_relief(std::span<const End>(ends).first(num_ends));
  const std::optional<CrackTension>& tension = cracks_of(layers, layer, texel).tension;
  if (!tension) return relief;
  return with_tension(relief, layers.tension_axes(layer)[layers.surface().triangle(texel)],
                      static_cast<float>(tension->ratio));
}

}  // namespace patinate::simulation
