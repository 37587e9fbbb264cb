/// \file
/// What every mesh reader does with the polygons it finds: weld, triangulate, drop the degenerate, fill in normals.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Corners 0 .. n-1 of a simple polygon as n - 2 triangles with the polygon's winding: ear clipping in the plane of its
/// area vector. Fans a polygon that is convex, and what is left of one that intersects itself.
[[nodiscard]] std::vector<Triangle> triangulate_polygon(std::span<const Vec3> corners);

/// Collects polygons of one file into a Mesh. Equal positions within a node become one entry; so do equal UVs at one
/// position, and equal normals.
class MeshBuilder {
 public:
  struct Corner {
    Vec3 position;
    std::optional<Vec2> uv;
    std::optional<Vec3> normal;  ///< Any length; of length 0 counts as not given.
  };

  /// @param file  Stands at the front of errors.
  explicit MeshBuilder(std::string file) : file_(std::move(file)) {}

  /// Polygons added from now on belong to this node and material.
  void set_surface(const std::string& node, const std::string& material);
  /// Fewer than three corners: ignored. @throws IoError on values that are not finite, or too many triangles.
  void add_polygon(std::span<const Corner> corners);
  /// The mesh. Corners without a normal get the angle-weighted one, if any corner has one; uv_triangles stay
  /// empty if no corner has a UV.
  /// @throws IoError if nothing was added.
  [[nodiscard]] Mesh finish();

 private:
  /// An index and the bits of up to three numbers.
  using Key = std::array<std::uint64_t, 4>;
  struct KeyHash {
    std::size_t operator()(const Key& key) const;
  };
  using Table = std::unordered_map<Key, int, KeyHash>;

  [[nodiscard]] int position_index(const Vec3& position);
  [[nodiscard]] int uv_index(int position, const Vec2& uv);
  [[nodiscard]] int normal_index(const Vec3& normal);
  void check_finite(const Corner& corner) const;
  void fill_missing_normals();

  std::string file_;
  Mesh mesh_;
  int node_ = -1;
  int surface_ = -1;
  bool has_uv_ = false;
  std::unordered_map<std::string, int> nodes_;
  std::unordered_map<std::string, int> surfaces_;
  Table positions_, uvs_, normals_;
};

}  // namespace patinate
