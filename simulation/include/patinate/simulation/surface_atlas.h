/// \file
/// What is constant in a simulation's atlas: the order in which it keeps texels, tiles of 8 x 8; which triangle a texel
/// shows, how large it is, and which texels are its neighbors.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

namespace place_types {
struct Places;  // simulation/atlas/place_kernel.inl
}

using TexelIndex = std::uint32_t;  ///< tile * 64 + (y % 8) * 8 + x % 8.
using TileIndex = std::uint32_t;   ///< Row by row; a tile's texels are [tile * 64, tile * 64 + 64).

/// Texels of a grid by tiles: what is near on the surface is near in memory, and "what has changed" can be told in
/// small pieces (5,000 random hits touch a quarter of a 1k atlas's tiles, but nearly all of its 32 x 32 squares). Width
/// and height are rounded up to whole pages of 64 x 64 texels (8 x 8 tiles), in which memory is given out.
struct TileGrid {
  static constexpr int kTileSide = 8;
  static constexpr int kTileTexels = 64;
  static constexpr int kPageTiles = 64;
  static constexpr int kPageTexels = 4096;

  int width = 0;  ///< Texels that a user sees.
  int height = 0;

  [[nodiscard]] int pages_x() const { return (width + 63) / 64; }
  [[nodiscard]] int pages_y() const { return (height + 63) / 64; }
  [[nodiscard]] std::uint32_t num_pages() const {
    return static_cast<std::uint32_t>(pages_x()) * static_cast<std::uint32_t>(pages_y());
  }
  [[nodiscard]] TileIndex num_tiles() const { return num_pages() * kPageTiles; }
  [[nodiscard]] std::uint32_t num_texels() const { return num_pages() * kPageTexels; }

  /// Pages row by row, in a page tiles row by row, in a tile texels row by row. @param x,y  Inside the grid.
  [[nodiscard]] TexelIndex index(int x, int y) const {
    const auto ux = static_cast<std::uint32_t>(x);
    const auto uy = static_cast<std::uint32_t>(y);
    const std::uint32_t page = (uy >> 6) * static_cast<std::uint32_t>(pages_x()) + (ux >> 6);
    return page << 12 | (uy >> 3 & 7) << 9 | (ux >> 3 & 7) << 6 | (uy & 7) << 3 | (ux & 7);
  }
  [[nodiscard]] int x(TexelIndex t) const {
    return static_cast<int>((t >> 12) % static_cast<std::uint32_t>(pages_x()) << 6 | (t >> 6 & 7) << 3 | (t & 7));
  }
  [[nodiscard]] int y(TexelIndex t) const {
    return static_cast<int>((t >> 12) / static_cast<std::uint32_t>(pages_x()) << 6 | (t >> 9 & 7) << 3 | (t >> 3 & 7));
  }
  [[nodiscard]] static TileIndex tile_of(TexelIndex t) { return t >> 6; }
  [[nodiscard]] static std::uint32_t page_of(TexelIndex t) { return t >> 12; }
  /// Whether the texel lies in the part that a user sees.
  [[nodiscard]] bool is_inside(TexelIndex t) const { return x(t) < width && y(t) < height; }
};

inline constexpr TexelIndex kNoTexel = 0xFFFFFFFFu;

/// All objects of a scene as one mesh whose UVs share one atlas.
struct SceneMesh {
  Mesh mesh;                          ///< World, mm, with normals; UVs over the whole atlas.
  std::vector<std::uint16_t> object;  ///< Of each triangle.
  std::vector<std::array<double, 3>>
      uv_squares;  ///< Per object: its unit square lies at (u, v) with this side (u, v, side).
};

/// Puts the objects' unit squares into one, `gutter` texels apart, and the objects into the world. Squares have the
/// sides that their objects' texels_per_mm ask for; the others are as large as fits, in proportion to the square roots
/// of surfaces.
/// @throws InvalidInput naming the object without UVs, with UVs outside [0, 1], or with no area; or that they do not
/// fit.
[[nodiscard]] SceneMesh make_scene_mesh(const Scene& scene, int gutter = 4);
/// Moves objects to other positions in the same layout. @throws InvalidInput if the objects are not the same.
void place_objects(SceneMesh& scene_mesh, const Scene& scene);

/// Texels of a scene's surface in tile order. Everything is an integer or a plain array, so that another device can
/// share it. Memory: 6 bytes a texel, and some 50 for each on a chart's border.
class SurfaceAtlas {
 public:
  /// A texel of median size has this weight; others in proportion to their area, at least 1. Amount * weight = mass, so
  /// that conservation is of mass (libcommon/atlas has the areas).
  static constexpr std::uint32_t kMedianWeight = 256;
  static constexpr std::uint32_t kMaxWeight = 65535;

  /// @throws InvalidInput if more of the covered texels than kMaxOverlap (atlas_mesh.h) are wanted by two triangles
  /// ("UVs overlap"), or none is covered.
  SurfaceAtlas(const SceneMesh& scene_mesh, int resolution, const RunControl& control = {});

  /// Objects of other sizes: all weights as they are when each object is `factors` times as large as it was when the
  /// atlas was made. Weights are still in parts of the texel of median size of that time.
  /// @param factors  By object; in [1 / kMaxScaling, kMaxScaling], where weights keep two digits and a maximum.
  void set_scale_factors(std::span<const double> factors, const RunControl& control = {});
  static constexpr double kMaxScaling = 8.0;

  [[nodiscard]] const TileGrid& grid() const { return grid_; }
  [[nodiscard]] bool is_covered(TexelIndex t) const { return triangle_[t] >= 0; }
  /// -1 outside the charts.
  [[nodiscard]] int triangle(TexelIndex t) const { return triangle_[t]; }
  /// Barycentric weights of the corners of triangle(t), covered, at the texel's center, or at the place of the triangle
  /// that is near it.
  [[nodiscard]] std::array<double, 3> corner_weights(TexelIndex t) const;
  /// By texel, in tile order.
  [[nodiscard]] std::span<const std::int32_t> triangles() const { return triangle_; }
  /// Texels at seams and where the surface ends, rising. Their neighbors are not simply the texels beside them.
  [[nodiscard]] std::span<const TexelIndex> border() const { return border_; }
  [[nodiscard]] std::int64_t num_covered() const { return num_covered_; }
  /// Whether all texels of a tile are covered and joined to those beside them alone: no seam, no end of the surface.
  [[nodiscard]] bool is_plain(TileIndex tile) const { return is_plain_tile_[tile] != 0; }
  /// Area weight of a whole texel of a triangle, [1, kMaxWeight].
  [[nodiscard]] std::uint32_t weight_of_triangle(int triangle) const { return weight_[triangle]; }
  /// Area weight of the surface that texel_of() gives to a texel, [1, kMaxWeight]: at a chart's edge it is from half a
  /// texel to one and a half, and even rain makes even amounts only if that is known.
  [[nodiscard]] std::uint32_t weight(TexelIndex t) const { return texel_weight_[t]; }
  /// By texel, in tile order; of those that are not covered it says nothing.
  [[nodiscard]] std::span<const std::uint16_t> weights() const { return texel_weight_; }
  /// Ask memory for weight(), and for triangle() and is_plain() too.
  void prefetch_weight(TexelIndex t) const { __builtin_prefetch(&texel_weight_[t]); }
  void prefetch(TexelIndex t) const {
    prefetch_weight(t);
    __builtin_prefetch(&triangle_[t]);
    __builtin_prefetch(&is_plain_tile_[TileGrid::tile_of(t)]);
  }
  /// The same in mm2.
  [[nodiscard]] double area_mm2(TexelIndex t) const {
    return weight(t) * median_texel_size_mm_ * median_texel_size_mm_ / kMedianWeight;
  }
  /// Columns: surface vectors (mm) of one texel step right and down, of a triangle as it stood at the beginning: what
  /// is laid on a surface grows with it.
  [[nodiscard]] const Eigen::Matrix<float, 3, 2>& mm_per_texel(int triangle) const { return step_[triangle]; }
  [[nodiscard]] double median_texel_size_mm() const { return median_texel_size_mm_; }
  [[nodiscard]] int num_triangles() const { return static_cast<int>(weight_.size()); }
  /// Of a triangle.
  [[nodiscard]] int object(int triangle) const { return object_[triangle]; }

  /// Texel that shows a surface point: that of its UV, or the nearest covered one beside it that belongs to the same
  /// chart; kNoTexel when there is none (a triangle smaller than a texel's distance to the next center).
  [[nodiscard]] TexelIndex texel_of(int triangle, double b1, double b2) const;
  /// What texel_of() reads besides triangles(), for devices. By triangle: x, y of its corners in texels; its chart, -1
  /// where it shows in no texel; the texel of its middle. By tile: the chart that all of its texels show; -1 where
  /// there is none.
  [[nodiscard]] std::span<const std::array<float, 6>> corner_texels() const { return corner_texels_; }
  [[nodiscard]] std::span<const int> charts() const { return chart_; }
  [[nodiscard]] std::span<const TexelIndex> fallbacks() const { return fallback_; }
  [[nodiscard]] std::span<const int> tile_charts() const { return tile_chart_; }
  /// Covered texels right, left, below and above on the surface, across seams; kNoTexel where the surface ends.
  [[nodiscard]] std::array<TexelIndex, 4> neighbors(TexelIndex t) const;
  /// How a texel is joined to one beside it: `count` is how often the two name each other as neighbors, 2 inside a
  /// chart.
  struct Link {
    TexelIndex texel;
    std::uint32_t count;
  };
  /// Texels that name this one as their neighbor or are named by it, each once, for steps over the surface that are as
  /// likely there as back: over a seam, neighbors() alone are not mutual. @param plain  Room for the answer where there
  /// is no seam.
  [[nodiscard]] std::span<const Link> links(TexelIndex t, std::array<Link, 4>& plain) const;
  /// What links(), weight_of_triangle() and is_plain() read, for devices. In order: texels with other links than to
  /// those beside them; by tile, and the end: where these begin; by linked texel, and the end: where its links begin.
  [[nodiscard]] std::span<const TexelIndex> linked() const { return linked_; }
  [[nodiscard]] std::span<const std::uint32_t> first_linked() const { return first_linked_; }
  [[nodiscard]] std::span<const std::uint32_t> first_links() const { return first_link_; }
  [[nodiscard]] std::span<const Link> all_links() const { return links_; }
  [[nodiscard]] std::span<const std::uint16_t> triangle_weights() const { return weight_; }
  [[nodiscard]] std::span<const std::uint8_t> plain_tiles() const { return is_plain_tile_; }

 private:
  /// For each triangle's weight by texel.
  void weigh(std::span<const double> weight_per_texel, const RunControl& control);
  void weigh_texels(std::span<const double> weight_per_texel, const RunControl& control);
  void make_links();
  void find_plain_tiles();
  void find_tile_charts();
  [[nodiscard]] place_types::Places places() const;
  [[nodiscard]] bool shows_chart_of(TexelIndex texel, int triangle) const;
  /// Of a triangle's chart, to a place in texels that may be anywhere near it.
  [[nodiscard]] TexelIndex nearest_texel(int triangle, double px, double py) const;

  TileGrid grid_;
  std::vector<std::int32_t> triangle_;               ///< Per texel.
  std::vector<double> first_weight_;                 ///< Per triangle, by texel, of the beginning.
  std::vector<std::uint16_t> weight_;                ///< Per triangle.
  std::vector<std::uint16_t> texel_weight_;          ///< Per texel.
  std::vector<std::uint16_t> object_;                ///< Per triangle.
  std::vector<Eigen::Matrix<float, 3, 2>> step_;     ///< Per triangle.
  std::vector<std::array<float, 6>> corner_texels_;  ///< Per triangle: x, y of the three corners in texels.
  std::vector<int> chart_;                           ///< Per triangle; -1 when it shows in no texel.
  std::vector<TexelIndex> fallback_;                 ///< Per triangle: the texel of its middle.
  std::vector<TexelIndex> border_;  ///< Sorted: texels whose neighbors are not simply those beside them.
  std::vector<std::array<TexelIndex, 4>> border_neighbors_;
  std::vector<TexelIndex> linked_;           ///< Sorted: texels with other links than to those beside them.
  std::vector<std::uint32_t> first_linked_;  ///< Of linked_, by tile, and the end.
  std::vector<std::uint32_t> first_link_;    ///< Of each, and the end.
  std::vector<Link> links_;
  std::vector<std::uint8_t> is_plain_tile_;
  std::vector<int> tile_chart_;  ///< Per tile: the chart_ that all of its texels show; -1 where there is none.
  std::int64_t num_covered_ = 0;
  double median_texel_size_mm_ = 0.0;
};

}  // namespace patinate::simulation
