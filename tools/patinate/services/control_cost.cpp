#include "tools/patinate/services/control_cost.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "libcommon/controls/control_expression.h"

namespace patinate::cli {

namespace {

/// Measured in November 2026 on an urn of 85,000 triangles, atlases of 256 and 1024 texels, default options
/// (docs/scaling.md): beside reading the mesh.
struct KindCost {
  std::string_view kind;
  double seconds, texel_seconds, megabytes, texel_bytes;
};
constexpr std::array<KindCost, 8> kKinds{{{"accessibility", 0.4, 2e-7, 25.0, 7.0},
                                          {"ray_share", 1.7, 1.8e-5, 0.0, 14.0},
                                          {"tangent_sphere", 1.9, 5.5e-5, 60.0, 7.0},
                                          {"exposure", 0.9, 9.8e-6, 0.0, 12.0},
                                          {"sun", 0.2, 2e-6, 0.0, 14.0},
                                          {"distance", 0.1, 3.4e-7, 0.0, 11.0},
                                          {"spray", 0.0, 3.6e-7, 0.0, 1.0},
                                          {"image", 0.0, 3e-7, 0.0, 10.0}}};
constexpr KindCost kOther{"", 0.0, 1.5e-7, 0.0, 4.0};
constexpr double kStart = 0.03, kTriangle_seconds = 4e-6, kStart_mb = 25.0, kTriangle_bytes = 420.0;
constexpr double kRays = 256.0;  ///< Of the measured ones.

double rays_of(std::string_view kind, const ControlKindOptions& o) {
  if (kind == "ray_share") return o.ray_share.num_rays / kRays;
  if (kind == "exposure") return o.exposure.num_rays / kRays;
  return 1.0;
}

}  // namespace

JobCost control_cost(const std::string& text, const Mesh& mesh, double texels, const ControlKindOptions& options) {
  const auto triangles = static_cast<double>(mesh.triangles.size());
  JobCost cost{.core_seconds = kStart + kTriangle_seconds * triangles,
               .megabytes = kStart_mb + 1e-6 * kTriangle_bytes * triangles};
  double megabytes = 0.0;
  const ControlExpression expression(text, control_kind_names());
  for (const ControlName& name : expression.names()) {
    const auto* const found = std::find_if(kKinds.begin(), kKinds.end(),
                                           [&](const KindCost& k) { return !name.is_file && k.kind == name.text; });
    const KindCost& kind = found == kKinds.end() ? kOther : *found;
    cost.core_seconds += rays_of(kind.kind, options) * (kind.seconds + kind.texel_seconds * texels);
    megabytes = std::max(megabytes, kind.megabytes + 1e-6 * kind.texel_bytes * texels);
  }
  cost.megabytes += megabytes;
  return cost;
}

}  // namespace patinate::cli
