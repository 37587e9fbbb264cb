/// \file
/// Indexed triangle mesh with plain arrays: the data type that everything passes. Topology work views it as OpenMesh.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <string>
#include <vector>

namespace patinate {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Triangle = std::array<int, 3>;  ///< Indices of three corners, counter-clockwise seen from outside.

/// Positions, UVs and normals are indexed separately, as in OBJ: a UV seam or a hard edge does not split a position.
struct Mesh {
  std::vector<Vec3>
      positions;              ///< In the file's unit until scaled to mm; equal positions of one surface are one entry.
  std::vector<Vec2> uvs;      ///< v up (OBJ). Empty when the mesh has none.
  std::vector<Vec3> normals;  ///< Unit. Empty when the file has none.
  std::vector<Triangle> triangles;  ///< Into positions.
  /// Into uvs; as long as triangles, or empty. -1 = a corner without UV, in a file that has some for others.
  std::vector<Triangle> uv_triangles;
  std::vector<Triangle> normal_triangles;  ///< Into normals; as long as triangles, or empty.
  std::vector<int> triangle_surface;       ///< Into surfaces; as long as triangles.
  /// What a user can choose by name: one per (node, material) of the file.
  struct Surface {
    std::string node;
    std::string material;
  };
  std::vector<Surface> surfaces;

  [[nodiscard]] int num_triangles() const { return static_cast<int>(triangles.size()); }
  /// Whether every corner of every triangle has a UV.
  [[nodiscard]] bool has_uvs() const { return !triangles.empty() && num_triangles_with_uvs() == num_triangles(); }
  [[nodiscard]] int num_triangles_with_uvs() const;
};

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
  [[nodiscard]] Vec3 center() const { return 0.5 * (low + high); }
  [[nodiscard]] double diagonal() const { return (high - low).norm(); }
};

/// Bounding box of the positions that triangles use.
[[nodiscard]] Box bounding_box(const Mesh& mesh);
/// Unnormalized cross product (b - a) x (c - a): twice the area, along the normal.
[[nodiscard]] Vec3 area_vector(const Mesh& mesh, int triangle);
/// Angle-weighted unit normals, one per position [Thuermer and Wuthrich 1998]; (0,0,1) where undefined.
[[nodiscard]] std::vector<Vec3> vertex_normals(const Mesh& mesh);
/// Shading normals per corner: the file's where it has them, else vertex_normals(). Makes `normals` and
/// `normal_triangles`.
[[nodiscard]] Mesh with_normals(Mesh mesh);
/// Multiplies positions.
void scale_mesh(Mesh& mesh, double factor);
/// Only the triangles whose node / material equals the given names ("" = any), with unused entries removed.
/// @throws InvalidInput listing the names there are if nothing remains.
[[nodiscard]] Mesh select_surfaces(const Mesh& mesh, const std::string& node, const std::string& material);
/// Where refine_edges() puts new positions.
enum class RefineShape {
  Flat,    ///< On the edge: the surface stays the same.
  Curved,  ///< On the curve defined by the normals at the edge's ends [Vlachos et al. 2001, PN triangles]; on the edge
           ///< if its two sides have different normals (creases). A missing normal, or one more than 45 degrees off its
           ///< triangle, is replaced by one from the adjacent triangles within 45 degrees.
};
/// Splits edges at midpoints (consistently, UVs and normals interpolated) until none is longer than `max_edge`, or
/// `max_triangles` is reached. Edges keep conforming: no cracks. Curved gives every corner a normal of its own.
/// @throws InvalidInput unless max_edge > 0.
[[nodiscard]] Mesh refine_edges(Mesh mesh, double max_edge, int max_triangles = 2'000'000,
                                RefineShape shape = RefineShape::Flat);
/// neighbors[t][k] = triangle across the edge (corner k, corner k+1) of t, by positions; -1 at a boundary. Where more
/// than two triangles share an edge, those that bend least are joined in pairs of opposite direction, and the others
/// end there (all of them, where more than 64 meet).
[[nodiscard]] std::vector<std::array<int, 3>> triangle_neighbors(const Mesh& mesh);

}  // namespace patinate
