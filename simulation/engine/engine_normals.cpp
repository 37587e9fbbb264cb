// Bounces about the normals of the composed heights, for scenes that ask for it.
#include <Eigen/LU>

#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

namespace {

/// Texel steps of a triangle where it stands now. @returns zero for one without an area in the atlas.
Eigen::Matrix<double, 3, 2> mm_per_texel(const Mesh& mesh, int triangle, int resolution) {
  const auto t = static_cast<std::size_t>(triangle);
  const auto position = [&](std::size_t k) -> const Vec3& { return mesh.positions[mesh.triangles[t][k]]; };
  const auto texel = [&](std::size_t k) {
    const Vec2& uv = mesh.uvs[mesh.uv_triangles[t][k]];
    return Vec2(uv.x() * resolution, (1.0 - uv.y()) * resolution);
  };
  Eigen::Matrix<double, 3, 2> edges;
  edges << position(1) - position(0), position(2) - position(0);
  Eigen::Matrix2d texels;
  texels << texel(1) - texel(0), texel(2) - texel(0);
  if (!(std::abs(texels.determinant()) > 1e-12)) return Eigen::Matrix<double, 3, 2>::Zero();
  return edges * texels.inverse();
}

class ComposedNormals final : public SurfaceNormals {
 public:
  ComposedNormals(const Composer& composer, const SurfaceAtlas& surface, const Mesh& mesh)
      : composer_(composer), surface_(surface), mesh_(mesh) {}

  [[nodiscard]] Vec3 normal(int triangle, double b1, double b2, const Vec3& shading_normal) const override {
    const TexelIndex t = surface_.texel_of(triangle, b1, b2);
    if (t == kNoTexel) return shading_normal;
    const Eigen::Matrix<double, 3, 2> steps = mm_per_texel(mesh_, triangle, surface_.grid().width);
    if (steps.isZero()) return shading_normal;
    return composer_.perturbed_normal(t, shading_normal, steps);
  }

 private:
  const Composer& composer_;
  const SurfaceAtlas& surface_;
  const Mesh& mesh_;
};

}  // namespace

std::unique_ptr<SurfaceNormals> Simulation::State::bounce_normals(const RunControl& control) {
  if (scene.tracing.bounce_normal == BounceNormal::Mesh) return nullptr;
  compose_now(control);
  return std::make_unique<ComposedNormals>(composer, surface, scene_mesh.mesh);
}

}  // namespace patinate::simulation
