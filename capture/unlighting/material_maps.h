/// \file
/// Materials found in a step, and laid over every texel of it. Inside of unlighting only.
#pragma once

#include <vector>

#include "capture/unlighting/material_fit.h"

namespace patinate::capture {

/// Evidence of at most some thousand texels on a square grid, for each of kLobeRoughness.
/// @param color  Albedo of a matt fit.
[[nodiscard]] std::vector<TexelEvidence> gather_evidence(const UnlightWork& work, const UnlightResult& fitted,
                                                         const ImageF& color, const RunControl& control);

/// Highlights, their tint and the share of metal of every texel, from the materials' shares in it: given to work.
void lay_materials(UnlightWork& work, const UnlightResult& fitted, const ImageF& color,
                   const std::vector<SurfaceMaterial>& materials, const RunControl& control);

/// F0 and metalness of the result, from its highlights and work's.
void put_reflectance(const UnlightWork& work, UnlightResult& result, const RunControl& control);

/// Makes strengths, roughness and kinds of materials such that the lamps of their texels, each left out in turn, are
/// foretold best: what sums of many linearized texels suggest is where this begins. `evidence` becomes by how much
/// metal is foretold better than what has an albedo, or the other way round, in standard deviations.
/// Takes the simplest of the kinds that lamps do not tell apart: matt, then dielectric, then mixed; metal where it
/// foretells better, or not worse and the albedo beside the lobe is as good as none.
/// @param texels  Of gather_evidence(). @param is_last  Not looked at again: more texels are asked.
void polish_materials(const UnlightWork& work, const std::vector<TexelEvidence>& texels,
                      std::vector<SurfaceMaterial>& materials, bool is_last, const RunControl& control);

/// How freely texels' highlights differ from their materials', as a share: work.highlight_freedom, wider than it is
/// where left-out lamps of texels all over the surface are foretold better so, by two standard deviations. Materials
/// hold texels that tarnish or patina has reached more or less; a narrow one draws them all to their mean.
/// @param work  With the highlights that materials give.
[[nodiscard]] double choose_freedom(const UnlightWork& work, const RunControl& control);

/// F0 of which single and further scattering make a lobe of this strength. @param roughness  Of the lobe, (0, 1].
/// @param facing  Cosine between normal and camera, [0, 1].
[[nodiscard]] double f0_of_strength(double strength, double roughness, double facing);

/// Share of metal in what reflects `f0` over an albedo, as glTF's converter of specular colors has it: one base color b
/// is the metal's and the diffuse light's, albedo = (1 - m) b and f0 = m b + 0.04 (1 - m). 0 where f0 is 0.04 or less.
/// @param albedo, f0  >= 0.
[[nodiscard]] double metal_share(double albedo, double f0);

}  // namespace patinate::capture
