#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "libcommon/atlas/raster.h"
#include "libcommon/core/text.h"
#include "patinate/atlas/atlas_mesh.h"

namespace patinate {

namespace {

constexpr int kGrid = 512;       ///< Texels along a square when overlap is measured.
constexpr double kSlack = 0.01;  ///< Charts may lean over the edge of a single square by this: they lose that strip.
constexpr double kTileTolerance = 1e-4;  ///< Rounding by which a UV may leave its UDIM tile.
constexpr int kUdimColumns = 10, kUdimRows = 100;

const Vec2& uv_of(const Mesh& mesh, std::size_t t, std::size_t k) { return mesh.uvs[mesh.uv_triangles[t][k]]; }

struct UvBox {
  Vec2 low = Vec2::Constant(1e300);
  Vec2 high = Vec2::Constant(-1e300);
  void add(const Vec2& uv) {
    low = low.cwiseMin(uv);
    high = high.cwiseMax(uv);
  }
};

/// How the UVs of a group of triangles come into the unit square; false when they are spread too far.
bool fit_square(const UvBox& box, double slack, AtlasTile& tile) {
  const Vec2 whole = (0.5 * (box.low + box.high)).array().floor();
  const auto leans_by = [&](const Vec2& shift) {
    return std::max((shift - box.low).maxCoeff(), (box.high - shift - Vec2::Ones()).maxCoeff());
  };
  const Vec2 shift = leans_by(Vec2::Zero()) <= kMaxLean ? Vec2(Vec2::Zero()) : whole;
  const double lean = leans_by(shift);
  if (!(lean <= kMaxLean)) return false;
  tile.shift = shift;
  if (lean > slack) {
    const Vec2 low = box.low.cwiseMin(shift), high = box.high.cwiseMax(Vec2(shift + Vec2::Ones()));
    tile.shift = low;
    tile.scale = 1.0 / (high - low).maxCoeff();
  }
  return true;
}

/// Texels that at least one and that at least two triangles of a group claim, over all groups.
double overlap_share(const Mesh& mesh, const std::vector<int>& group, const std::vector<AtlasTile>& tiles) {
  std::vector<std::size_t> order(group.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return group[a] < group[b]; });
  std::vector<std::uint8_t> claims(std::size_t{kGrid} * kGrid, 0);
  std::vector<std::size_t> touched;
  std::int64_t covered = 0, repeated = 0;
  const auto finish_group = [&] {
    for (std::size_t texel : touched) claims[texel] = 0;
    touched.clear();
  };
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t t = order[i];
    if (i > 0 && group[t] != group[order[i - 1]]) finish_group();
    const AtlasTile& tile = tiles[group[t]];
    std::array<Vec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = texel_from_uv((uv_of(mesh, t, k) - tile.shift) * tile.scale, kGrid, kGrid);
    for_each_texel(
        p, {0, 0, kGrid, kGrid},
        [&](int x, int y, double, double, double inside) {
          if (!(inside > kOverlapTolerance)) return;
          std::uint8_t& n = claims[static_cast<std::size_t>(y) * kGrid + static_cast<std::size_t>(x)];
          if (n == 0) touched.push_back(static_cast<std::size_t>(y) * kGrid + static_cast<std::size_t>(x));
          covered += n == 0;
          repeated += n == 1;
          n = static_cast<std::uint8_t>(std::min(n + 1, 2));
        },
        [] {});
  }
  return covered > 0 ? static_cast<double>(repeated) / static_cast<double>(covered) : 0.0;
}

/// Share of the area whose triangles have no area in UV.
double flat_share(const Mesh& mesh) {
  double flat = 0.0, total = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double area = area_vector(mesh, static_cast<int>(t)).norm();
    const double uv_area = cross2(uv_of(mesh, t, 1) - uv_of(mesh, t, 0), uv_of(mesh, t, 2) - uv_of(mesh, t, 0));
    total += area;
    if (!(std::abs(uv_area) > 1e-14)) flat += area;
  }
  return total > 0.0 ? flat / total : 0.0;
}

/// Every triangle in one UDIM tile, or nothing.
bool fit_udim(const Mesh& mesh, UvLayout& layout) {
  std::vector<int> number(mesh.triangles.size());
  std::map<int, int> index_of;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec2 center = (uv_of(mesh, t, 0) + uv_of(mesh, t, 1) + uv_of(mesh, t, 2)) / 3.0;
    Vec2 tile = center.array().floor();
    if (!(tile.minCoeff() >= 0.0 && tile.x() < kUdimColumns && tile.y() < kUdimRows)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 inside = uv_of(mesh, t, k) - tile;
      if (inside.minCoeff() < -kTileTolerance || inside.maxCoeff() > 1.0 + kTileTolerance) return false;
    }
    number[t] = 1001 + static_cast<int>(tile.x()) + 10 * static_cast<int>(tile.y());
    index_of.emplace(number[t], 0);
  }
  if (index_of.size() > kMaxTiles) return false;
  layout.rule = UvLayoutRule::Udim;
  for (auto& [name, index] : index_of) {
    index = static_cast<int>(layout.tiles.size());
    const int column = (name - 1001) % 10, line = (name - 1001) / 10;
    const Vec2 origin(column, line);
    layout.tiles.push_back({std::to_string(name), origin, origin, 1.0});
  }
  for (std::size_t t = 0; t < number.size(); ++t) layout.triangle_tile[t] = index_of[number[t]];
  return true;
}

/// A name that can stand in a file's name.
std::string file_name_of(const std::string& name, std::set<std::string>& taken) {
  const auto is_plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_'; };
  const auto is_blank = [](char c) { return static_cast<unsigned char>(c) <= ' '; };
  std::string safe = name;
  while (!safe.empty() && is_blank(safe.back())) safe.pop_back();
  while (!safe.empty() && is_blank(safe.front())) safe.erase(safe.begin());
  safe.resize(std::min<std::size_t>(safe.size(), 64));
  std::replace_if(
      safe.begin(), safe.end(), [&](char c) { return !is_plain(c); }, '_');
  if (safe.empty()) safe = "unnamed";
  std::string unique = safe;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = safe + "_" + std::to_string(i);
  return unique;
}

std::string group_name(const Mesh::Surface& s, UvLayoutRule rule) {
  if (rule == UvLayoutRule::Material) return s.material;
  return rule == UvLayoutRule::Node ? s.node : s.node + '\n' + s.material;
}

/// A tile per material, node or surface; nothing when there is only one, or too many.
bool split_by_name(const Mesh& mesh, UvLayoutRule rule, UvLayout& layout) {
  if (mesh.triangle_surface.size() != mesh.triangles.size()) return false;
  std::map<std::string, int> index_of;
  std::vector<int> tile_of_surface;
  std::set<std::string> taken;
  for (const Mesh::Surface& s : mesh.surfaces) {
    const std::string name = group_name(s, rule);
    const auto [found, is_new] = index_of.try_emplace(name, static_cast<int>(index_of.size()));
    if (is_new) layout.tiles.push_back({file_name_of(name, taken), Vec2::Zero(), Vec2::Zero(), 1.0});
    if (layout.tiles.size() > kMaxTiles) return false;
    tile_of_surface.push_back(found->second);
  }
  layout.rule = rule;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    layout.triangle_tile[t] = tile_of_surface[mesh.triangle_surface[t]];
  }
  return layout.tiles.size() > 1;
}

/// The first way to split by names after which every tile fits a square and overlaps no more than it may.
bool fit_any_groups(const Mesh& mesh, UvLayout& layout) {
  for (const UvLayoutRule rule : {UvLayoutRule::Material, UvLayoutRule::Node, UvLayoutRule::Surface}) {
    UvLayout out = layout;
    out.tiles.clear();
    if (!split_by_name(mesh, rule, out)) continue;
    std::vector<UvBox> boxes(out.tiles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) boxes[out.triangle_tile[t]].add(uv_of(mesh, t, k));
    }
    bool fits = true;
    for (std::size_t i = 0; i < boxes.size() && fits; ++i) fits = fit_square(boxes[i], 0.0, out.tiles[i]);
    if (!fits) continue;
    out.overlap_share = overlap_share(mesh, out.triangle_tile, out.tiles);
    if (out.overlap_share > kMaxOverlap) continue;
    layout = std::move(out);
    return true;
  }
  return false;
}

void remark_on_fit(UvLayout& layout) {
  for (const AtlasTile& tile : layout.tiles) {
    if (tile.scale != 1.0) layout.remark = "UVs that lean out of [0, 1] are scaled into it";
    if (tile.scale == 1.0 && tile.shift != tile.origin && layout.remark.empty())
      layout.remark = "UVs are moved by whole squares into [0, 1]";
  }
}

}  // namespace

UvLayout find_uv_layout(const Mesh& mesh) {
  UvLayout layout;
  const int num_with_uvs = mesh.num_triangles_with_uvs();
  if (num_with_uvs == 0 || num_with_uvs < mesh.num_triangles()) {
    layout.problem = num_with_uvs == 0
                         ? "it has no UVs"
                         : std::to_string(mesh.num_triangles() - num_with_uvs) + " of its " +
                               std::to_string(mesh.num_triangles()) + " triangles have corners without UVs";
    return layout;
  }
  layout.triangle_tile.assign(mesh.triangles.size(), 0);
  layout.flat_share = flat_share(mesh);
  UvBox box;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) box.add(uv_of(mesh, t, k));
  }
  AtlasTile square;
  const bool is_inside = box.low.minCoeff() >= -kSlack && box.high.maxCoeff() <= 1.0 + kSlack;
  if (is_inside || (!fit_udim(mesh, layout) && fit_square(box, kSlack, square))) {
    layout.tiles.assign(1, square);
  } else if (layout.tiles.empty() && !fit_any_groups(mesh, layout)) {
    layout.problem = "its UVs leave [0, 1] (u from " + short_number_text(box.low.x()) + " to " +
                     short_number_text(box.high.x()) + ", v from " + short_number_text(box.low.y()) + " to " +
                     short_number_text(box.high.y()) + ") and are no UDIM tiles";
    layout.triangle_tile.clear();
    return layout;
  }
  layout.overlap_share = overlap_share(mesh, layout.triangle_tile, layout.tiles);
  const double shared = layout.overlap_share;
  if (shared > kMaxOverlap && layout.rule == UvLayoutRule::Square && fit_any_groups(mesh, layout)) {
    layout.remark = "together they overlap in " + percent_text(shared, 2) + " of the texels";
  }
  remark_on_fit(layout);
  if (layout.flat_share > kMaxFlat) {
    layout.problem = percent_text(layout.flat_share, 2) + " of its surface has no area in UV";
  } else if (layout.overlap_share > kMaxOverlap) {
    layout.problem = percent_text(layout.overlap_share, 2) + " of its texels belong to more than one place";
  }
  return layout;
}

UvLayout uv_layout_by_rule(const Mesh& mesh, UvLayoutRule rule) {
  UvLayout layout;
  layout.triangle_tile.assign(mesh.triangles.size(), 0);
  if (rule == UvLayoutRule::Square) {
    layout.tiles.assign(1, {});
  } else if (rule == UvLayoutRule::Udim ? !fit_udim(mesh, layout) : !split_by_name(mesh, rule, layout)) {
    layout.tiles.clear();
  }
  return layout;
}

}  // namespace patinate
