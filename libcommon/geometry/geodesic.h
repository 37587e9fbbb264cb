/// \file
/// Distance along a surface.
#pragma once

#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

/// A point of a surface from which distance is measured.
struct GeodesicSource {
  int triangle = -1;
  Vec3 position = Vec3::Zero();  ///< In that triangle.
};

/// Length of the shortest way over a mesh from the nearest of some points.
///
/// Fronts move over the mesh in the order of their distance [Kimmel and Sethian 1998, fast marching], but every vertex
/// keeps where its way came from, as a point unfolded into its triangle's plane [after Novotni and Klein 2002]: from
/// that, the distance over a plane, a cylinder or a cone is exact for points and for straight lines of points;
/// elsewhere the error falls with the edge length. Behind a corner of the surface's end, which ways bend round, it is
/// up to 8 % short. Ways go over edges that two triangles share; where more meet, they end.
class GeodesicDistance {
 public:
  /// @param mesh  Must outlive this. Edges short against the curvature: see refine_edges().
  /// @throws InvalidInput if there is no source.
  GeodesicDistance(const Mesh& mesh, const std::vector<GeodesicSource>& sources, const RunControl& control = {});

  /// At a point of a triangle; infinite where no way leads.
  [[nodiscard]] double at(int triangle, const Vec3& position) const;

 private:
  /// Where the shortest way to a vertex came from.
  struct Arrival {
    double distance;
    double before = 0.0;            ///< Length of the way up to `source`, which then is a corner that it bends round.
    Vec3 to_source = Vec3::Zero();  ///< From the vertex, in the plane of `normal`.
    Vec3 normal = Vec3::UnitZ();
  };
  void march(const RunControl& control);
  [[nodiscard]] Vec3 source_in(int vertex, const Vec3& normal) const;
  [[nodiscard]] Arrival arrive(int triangle, int target, int from, int other, bool is_other_known) const;

  const Mesh& mesh_;
  std::vector<Vec3> normals_;  // Normals of triangles.
  std::vector<Arrival> arrivals_;
};

}  // namespace patinate
