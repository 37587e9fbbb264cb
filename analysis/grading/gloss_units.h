/// \file
/// Gloss units of a gloss meter, from a lobe.
#pragma once

namespace patinate::analysis {

/// Reading of a gloss meter on a surface with this mirror [ISO 2813:2014, ASTM D523]: the flux that reaches its
/// receptor over that of polished black glass of index 1.567, which is 100. The lobe is that of render, GGX
/// with Smith's shadowing; the Fresnel term is exact, of the index that f0 belongs to: Schlick's is a fifth too low at
/// 60 degrees.
/// @param angle_deg  20, 60 or 85: source and receptor, from the normal.
/// @param f0  Reflectance at normal incidence, [0, 1]. @param roughness  [0.05, 1].
/// @throws InvalidInput on another angle.
[[nodiscard]] double gloss_units(double angle_deg, double f0, double roughness);

}  // namespace patinate::analysis
