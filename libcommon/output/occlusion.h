/// \file
/// How much of the light from all around arrives: at the vertices of a mesh, and on the ground below it. Without noise,
/// since it is interpolated.
#pragma once

#include <vector>

#include "libcommon/geometry/ray_scene.h"
#include "patinate/output/render.h"

namespace patinate {

/// The mesh with normals, and with edges short enough for occlusion at its vertices.
[[nodiscard]] Mesh refined_for_occlusion(const Mesh& mesh, const RenderOptions& options);

/// Ambient visibility of every position of the mesh, [0, 1]; 1 without occlusion samples.
/// @param scene  Of the same mesh. @param diagonal  Of its bounding box.
[[nodiscard]] std::vector<float> occlusion_at_vertices(const Mesh& mesh, const RayScene& scene, double diagonal,
                                                       const RenderOptions& options, const RunControl& control);

/// The plane on which a mesh stands.
class Ground {
 public:
  /// Without visibility: open everywhere. @param box  Of the mesh.
  Ground(const Mesh& mesh, const Box& box, UpAxis up);
  /// Finds the ambient visibility around the mesh.
  void find_visibility(const RayScene& scene, const RenderOptions& options, const RunControl& control);

  [[nodiscard]] const Vec3& up() const { return up_; }
  [[nodiscard]] double height() const { return height_; }  ///< Along up().
  /// Ambient visibility at a point of the ground, [0, 1].
  [[nodiscard]] double visibility(const Vec3& p) const;

 private:
  Box box_;
  double diagonal_ = 0.0;
  Vec3 up_, x_, y_;
  double height_ = 0.0;
  std::vector<float> visibility_;  ///< A grid around the mesh; empty = open.
};

}  // namespace patinate
