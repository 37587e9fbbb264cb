/// \file
/// Lobes that many texels share, whatever step they are of: materials. Inside of unlighting only.
#pragma once

#include <vector>

#include "capture/unlighting/texel_lobes.h"

namespace patinate::capture {

/// Shares of materials at each texel; they sum to 1.
using MaterialShares = std::vector<std::vector<double>>;

/// Finds the materials of the texels of one or several steps. Classes begin as clusters of colors; then, in turn, every
/// class has the lobe that explains most of its texels' samples, and every texel belongs to classes by how well their
/// lobes explain its samples, by its color, and by what its neighbors (in the same step, and the same place in the
/// steps beside) belong to, as far as they are of its color. A class is matt, dielectric (a white lobe), mixed (a
/// tinted lobe and diffuse light) or metal (a tinted lobe alone), whichever is likeliest [Schwarz 1978].
/// @param texels  Evidence for each of kLobeRoughness.
[[nodiscard]] std::vector<SurfaceMaterial> find_materials(const std::vector<TexelEvidence>& texels,
                                                          const RunControl& control);

/// The shares of given materials. @param at  For each material the index of its lobe in the texels' evidence.
[[nodiscard]] MaterialShares shares_of_materials(const std::vector<TexelEvidence>& texels,
                                                 const std::vector<SurfaceMaterial>& materials,
                                                 const std::vector<std::size_t>& at, const RunControl& control);

/// Shares of one texel on its own. @param belief  Of its neighbors, a number for each material, added to logarithms.
[[nodiscard]] std::vector<double> shares_of_texel(const TexelEvidence& texel,
                                                  const std::vector<SurfaceMaterial>& materials,
                                                  const std::vector<std::size_t>& at, std::vector<double> belief);
/// Index of the nearest of kLobeRoughness.
[[nodiscard]] std::size_t nearest_lobe_roughness(double roughness);
/// Weight of a neighbor of this color, [0, 1]. @param one, other  Square roots of albedo.
[[nodiscard]] double likeness(const Vec3& one, const Vec3& other);

}  // namespace patinate::capture
