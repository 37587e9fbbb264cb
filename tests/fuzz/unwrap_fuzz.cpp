// Unwrapping any mesh that a reader could have made.
#include <cmath>

#include "patinate/atlas/unwrap.h"
#include "tests/fuzz/any_mesh.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(unwrap) {
  fuzz::ByteSource source(bytes);
  const Mesh mesh = fuzz::any_mesh(source);
  RunControl control;
  control.num_threads = 1;
  const UnwrapResult result = unwrap(mesh, {.resolution = 64}, control);
  fuzz::require(result.mesh.uv_triangles.size() == mesh.triangles.size(), "every triangle has UVs");
  for (const Vec2& uv : result.mesh.uvs) {
    fuzz::require(uv.allFinite() && uv.minCoeff() >= 0.0 && uv.maxCoeff() <= 1.0, "UVs lie in [0, 1]");
  }
  fuzz::require(std::isfinite(result.stretch.max) && std::isfinite(result.l2_stretch), "stretch is finite");
}
