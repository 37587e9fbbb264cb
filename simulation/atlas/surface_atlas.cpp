#include "patinate/simulation/surface_atlas.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "libcommon/core/parallel.h"
#include "patinate/atlas/atlas_mesh.h"
#include "simulation/atlas/places.h"

namespace patinate::simulation {

namespace {

SurfacePoint middle_of(int triangle) { return {.triangle = triangle, .b1 = 1.0 / 3.0, .b2 = 1.0 / 3.0}; }

void check_overlap(const SceneMesh& scene_mesh, const TexelMap& map) {
  if (map.num_covered() == 0) throw InvalidInput("no texel of the atlas is covered; raise its resolution");
  const auto overlaps = [](const TexelMap& of) {
    return static_cast<double>(of.num_overlapping()) > kMaxOverlap * static_cast<double>(of.num_covered());
  };
  if (!overlaps(map)) return;
  // Name of the object: each alone on a grid of its own.
  std::string names;
  for (std::size_t i = 0; i < scene_mesh.mesh.surfaces.size(); ++i) {
    const std::string& name = scene_mesh.mesh.surfaces[i].node;
    const TexelMap alone(select_surfaces(scene_mesh.mesh, name, ""), std::min(map.width(), 1024),
                         std::min(map.height(), 1024));
    if (overlaps(alone)) names += (names.empty() ? "'" : ", '") + name + "'";
  }
  throw InvalidInput(
      "the UVs of object " + (names.empty() ? std::string("(several together)") : names) +
      " overlap: places would share their texels; let the scene unwrap it (\"atlas\": {\"uvs\": \"unwrap\"})");
}

}  // namespace

SurfaceAtlas::SurfaceAtlas(const SceneMesh& scene_mesh, int resolution, const RunControl& control)
    : grid_{.width = resolution, .height = resolution}, object_(scene_mesh.object) {
  const TexelMap map(scene_mesh.mesh, resolution, resolution, control.part(0.0, 0.5));
  check_overlap(scene_mesh, map);
  num_covered_ = map.num_covered();
  median_texel_size_mm_ = map.median_texel_size_mm();
  const auto num_triangles = static_cast<std::size_t>(scene_mesh.mesh.num_triangles());
  step_.resize(num_triangles);
  corner_texels_.resize(num_triangles);
  chart_.assign(num_triangles, -1);
  fallback_.assign(num_triangles, kNoTexel);
  first_weight_.resize(num_triangles);
  const double median_area = median_texel_size_mm_ * median_texel_size_mm_;
  const auto index_of = [&](TexelId t) {
    return t < 0 ? kNoTexel : grid_.index(static_cast<int>(t % map.width()), static_cast<int>(t / map.width()));
  };
  parallel_for(static_cast<std::int64_t>(num_triangles), 4096, control.part(0.5, 0.6),
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   const auto t = static_cast<std::size_t>(i);
                   const Eigen::Matrix<double, 3, 2> step = map.mm_per_texel(static_cast<int>(i));
                   step_[t] = step.cast<float>();
                   first_weight_[t] = kMedianWeight * step.col(0).cross(step.col(1)).norm() / median_area;
                   for (std::size_t k = 0; k < 3; ++k) {
                     const Vec2& uv = map.mesh().uvs[map.mesh().uv_triangles[t][k]];
                     corner_texels_[t][2 * k] = static_cast<float>(uv.x() * map.width() - 0.5);
                     corner_texels_[t][2 * k + 1] = static_cast<float>((1.0 - uv.y()) * map.height() - 0.5);
                   }
                   const TexelId texel = map.texel_of(middle_of(static_cast<int>(i)));
                   fallback_[t] = index_of(texel);
                   if (texel >= 0) chart_[t] = map.chart(texel);
                 }
               });
  triangle_.assign(grid_.num_texels(), -1);
  std::vector<std::vector<std::pair<TexelIndex, std::array<TexelIndex, 4>>>> rows(
      static_cast<std::size_t>(map.height()));
  parallel_for(map.height(), 16, control.part(0.6, 0.9), [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < map.width(); ++x) {
        const TexelId id = std::int64_t{y} * map.width() + x;
        if (!map.is_covered(id)) continue;
        const SurfacePoint point = map.point(id);
        const TexelIndex here = grid_.index(x, y);
        triangle_[here] = point.triangle;
        constexpr int kStepX[4] = {1, -1, 0, 0};
        constexpr int kStepY[4] = {0, 0, 1, -1};
        std::array<TexelIndex, 4> around{};
        bool is_plain = true;
        for (std::size_t k = 0; k < 4; ++k) {
          const int nx = x + kStepX[k], ny = y + kStepY[k];
          const bool is_on_grid = nx >= 0 && ny >= 0 && nx < map.width() && ny < map.height();
          const TexelId beside = is_on_grid ? std::int64_t{ny} * map.width() + nx : -1;
          if (beside >= 0 && map.is_covered(beside) && map.chart(beside) == map.chart(id)) {
            around[k] = index_of(beside);
            continue;
          }
          is_plain = false;
          const Vec3 step = map.mm_per_texel(point.triangle) * Vec2(kStepX[k], kStepY[k]);
          const SurfacePoint there = map.walk(point, step);
          around[k] = there.triangle < 0 ? kNoTexel : index_of(map.texel_of(there));
          if (around[k] == here) around[k] = kNoTexel;
        }
        if (!is_plain) rows[y].emplace_back(here, around);
      }
    }
  });
  std::vector<std::pair<TexelIndex, std::array<TexelIndex, 4>>> all;
  for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [texel, around] : all) {
    border_.push_back(texel);
    border_neighbors_.push_back(around);
  }
  make_links();
  find_plain_tiles();
  find_tile_charts();
  weigh(first_weight_, control.part(0.9, 1.0));
}

void SurfaceAtlas::weigh(std::span<const double> weight_per_texel, const RunControl& control) {
  weight_.resize(weight_per_texel.size());
  for (std::size_t t = 0; t < weight_.size(); ++t) {
    const double weight = std::round(weight_per_texel[t]);
    weight_[t] = static_cast<std::uint16_t>(weight >= 1.0 ? std::min<double>(weight, kMaxWeight) : 1.0);
  }
  weigh_texels(weight_per_texel, control);
}

void SurfaceAtlas::set_scale_factors(std::span<const double> factors, const RunControl& control) {
  std::vector<double> weights = first_weight_;
  for (std::size_t t = 0; t < weights.size(); ++t) weights[t] *= factors[object_[t]] * factors[object_[t]];
  weigh(weights, control);
}

void SurfaceAtlas::make_links() {
  // Over a seam, border texels name some that do not name them, and some that are on no border.
  const auto contains = [](const std::vector<TexelIndex>& sorted, TexelIndex t) {
    return std::binary_search(sorted.begin(), sorted.end(), t);
  };
  linked_ = border_;
  for (std::size_t i = 0; i < border_.size(); ++i) {
    for (const TexelIndex n : border_neighbors_[i]) {
      if (n == kNoTexel || contains(border_, n)) continue;
      const std::array<TexelIndex, 4> back = neighbors(n);
      if (std::find(back.begin(), back.end(), border_[i]) == back.end()) linked_.push_back(n);
    }
  }
  std::sort(linked_.begin(), linked_.end());
  linked_.erase(std::unique(linked_.begin(), linked_.end()), linked_.end());
  first_linked_.assign(grid_.num_tiles() + std::size_t{1}, 0);
  for (const TexelIndex t : linked_) ++first_linked_[TileGrid::tile_of(t) + std::size_t{1}];
  std::partial_sum(first_linked_.begin(), first_linked_.end(), first_linked_.begin());
  std::vector<std::pair<TexelIndex, TexelIndex>> named;
  for (const TexelIndex t : linked_) {
    for (const TexelIndex n : neighbors(t)) {
      if (n == kNoTexel) continue;
      named.emplace_back(t, n);
      if (contains(linked_, n))
        named.emplace_back(n, t);
      else
        named.emplace_back(t, n);  // it names t too
    }
  }
  std::sort(named.begin(), named.end());
  auto next = named.begin();
  for (const TexelIndex t : linked_) {
    first_link_.push_back(static_cast<std::uint32_t>(links_.size()));
    while (next != named.end() && next->first < t) ++next;
    for (; next != named.end() && next->first == t; ++next) {
      if (links_.size() > first_link_.back() && links_.back().texel == next->second)
        ++links_.back().count;
      else
        links_.push_back({next->second, 1});
    }
  }
  first_link_.push_back(static_cast<std::uint32_t>(links_.size()));
}

void SurfaceAtlas::find_plain_tiles() {
  is_plain_tile_.assign(grid_.num_tiles(), 1);
  for (TexelIndex t = 0; t < grid_.num_texels(); ++t) {
    if (!is_covered(t)) is_plain_tile_[TileGrid::tile_of(t)] = 0;
  }
  for (const std::vector<TexelIndex>* texels : {&border_, &linked_}) {
    for (const TexelIndex t : *texels) is_plain_tile_[TileGrid::tile_of(t)] = 0;
  }
}

void SurfaceAtlas::find_tile_charts() {
  tile_chart_.assign(grid_.num_tiles(), -1);
  const auto chart_of = [&](TexelIndex t) { return is_covered(t) ? chart_[triangle_[t]] : -1; };
  for (TileIndex tile = 0; tile < grid_.num_tiles(); ++tile) {
    const TexelIndex first = tile * TileGrid::kTileTexels;
    const int chart = chart_of(first);
    bool is_one = true;
    for (TexelIndex t = first + 1; is_one && t < first + TileGrid::kTileTexels; ++t) is_one = chart_of(t) == chart;
    if (is_one) tile_chart_[tile] = chart;
  }
}

std::array<double, 3> SurfaceAtlas::corner_weights(TexelIndex t) const {
  const std::array<float, 6>& c = corner_texels_[triangle(t)];
  const auto at = [&](std::size_t i) { return static_cast<double>(c[i]); };
  const double ux = at(2) - at(0), uy = at(3) - at(1), vx = at(4) - at(0), vy = at(5) - at(1);
  const double px = grid_.x(t) - at(0), py = grid_.y(t) - at(1);
  const double area = ux * vy - uy * vx;
  if (area == 0.0) return {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
  const double b1 = (px * vy - py * vx) / area, b2 = (ux * py - uy * px) / area;
  std::array<double, 3> weights{std::max(0.0, 1.0 - b1 - b2), std::max(0.0, b1), std::max(0.0, b2)};
  const double sum = weights[0] + weights[1] + weights[2];
  for (double& w : weights) w /= sum;
  return weights;
}

place_types::Places SurfaceAtlas::places() const {
  return {.facts = {.width = grid_.width, .height = grid_.height},
          .corners = corner_texels_.empty() ? nullptr : corner_texels_.data()->data(),
          .charts = chart_.data(),
          .fallbacks = fallback_.data(),
          .tile_charts = tile_chart_.data(),
          .triangles = triangle_.data()};
}

bool SurfaceAtlas::shows_chart_of(TexelIndex texel, int triangle) const {
  const place_types::Places p = places();
  return place_types::shows_chart_of(&p, texel, triangle);
}

TexelIndex SurfaceAtlas::texel_of(int triangle, double b1, double b2) const {
  const place_types::Places p = places();
  return place_types::texel_at(&p, triangle, b1, b2);
}

TexelIndex SurfaceAtlas::nearest_texel(int triangle, double px, double py) const {
  const place_types::Places p = places();
  return place_types::texel_near(&p, triangle, px, py);
}

std::array<TexelIndex, 4> SurfaceAtlas::neighbors(TexelIndex t) const {
  const auto found = std::lower_bound(border_.begin(), border_.end(), t);
  if (found != border_.end() && *found == t) return border_neighbors_[found - border_.begin()];
  const int x = grid_.x(t), y = grid_.y(t);
  return {grid_.index(x + 1, y), grid_.index(x - 1, y), grid_.index(x, y + 1), grid_.index(x, y - 1)};
}

std::span<const SurfaceAtlas::Link> SurfaceAtlas::links(TexelIndex t, std::array<Link, 4>& plain) const {
  const TileIndex tile = TileGrid::tile_of(t);
  const auto begin = linked_.begin() + first_linked_[tile], end = linked_.begin() + first_linked_[tile + 1];
  const auto found = std::lower_bound(begin, end, t);
  if (found != end && *found == t) {
    const auto i = static_cast<std::size_t>(found - linked_.begin());
    return std::span(links_).subspan(first_link_[i], first_link_[i + 1] - first_link_[i]);
  }
  const int x = grid_.x(t), y = grid_.y(t);
  plain = {Link{grid_.index(x + 1, y), 2}, Link{grid_.index(x - 1, y), 2}, Link{grid_.index(x, y + 1), 2},
           Link{grid_.index(x, y - 1), 2}};
  return plain;
}

}  // namespace patinate::simulation
