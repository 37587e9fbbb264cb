/// \file
/// Pictures of a surface with all that its texels say: color, gloss, metal, relief, water and small plants; under the
/// lamp of render() or a picture of the surroundings. On the CPU, without a display.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "patinate/output/render.h"

namespace patinate {

struct SurfacePieces;

/// The material of a surface, texel by texel. Maps may have different sizes; they are sampled as the texture of
/// RenderView::shade() is, so texels beside the charts should be filled. A map that is empty says nothing.
struct SurfaceMaps {
  ImageF color = {};    ///< Linear, 1 or >= 3 channels: albedo; of a metal the reflectance at normal incidence. Needed.
  ImageF normals = {};  ///< Tangent space: x along growing u, y along growing v (up), z outward; 3 channels.
  ImageF roughness = {};  ///< GGX, clamped to [0.05, 1]; 1 channel; empty: RenderOptions::roughness.
  ImageF metalness = {};  ///< [0, 1]; 1 channel; empty: 0.
  ImageF specular = {};   ///< Reflectance at normal incidence where there is no metal, [0, 1]; 1 or >= 3 channels;
                          ///< empty: RenderOptions::specular.
  ImageF height = {};     ///< Along the normal, in the mesh's unit; 1 channel.
  ImageF wetness = {};    ///< 0 = dry, 1 = under a film of water; 1 channel.
  ImageF plants = {};     ///< Amount of what grows on it, >= 0: small plants from 0.18 on, all that there are from 0.75
                          ///< on; 1 channel.
  std::shared_ptr<const SurfacePieces> pieces = {};  ///< What stands off the surface; null: nothing.
};

/// Thin pieces that stand off a surface, such as lifted flakes of paint. No height moves them.
struct SurfacePieces {
  Mesh mesh;                            ///< In the surface's unit, with UVs and normals.
  std::vector<std::uint8_t> materials;  ///< By triangle, into maps.
  std::vector<SurfaceMaps> maps;        ///< Heights, plants and pieces of their own count as none.
};

/// Settings of SurfaceView beside those of render().
struct SurfaceOptions {
  double relief = 1.0;          ///< Factor of heights and of slopes that normals tell; 0 = smooth; [0, 100].
  double plants = 1.0;          ///< Factor of their number; 0 = none; [0, 100].
  double plant_size = 0.0;      ///< Mean height of a plant in the mesh's unit; 0 = 1/220 of the mesh's diagonal; >= 0.
  double plant_cushion = 12.0;  ///< Diameter of the largest cushions, in heights of a plant; 0 = all alike; [0, 1000].
  double environment_azimuth_deg = 0.0;  ///< Turns the surroundings; 0: their middle is what the camera looks toward.
  double environment_light = 0.6;        ///< Mean radiance to which the surroundings are scaled; 0 = as they are; >= 0.
};
/// Visits every field.
void describe(OptionVisitor& v, SurfaceOptions& o);

/// A surface as a camera may see it from anywhere: displaced, its occlusion found. Pictures are thread-safe, and the
/// same pictures for any number of threads. Memory: about 400 bytes a triangle, of which relief makes at most 1.2
/// million.
///
/// Diffuse light as in render(). Highlights are GGX lobes with Schlick's Fresnel term whose lost energy is made good
/// [Turquin 2019]; what they reflect is traced against the scene for one bounce, by one ray per sample of a pixel, and
/// up to four where the mirror is nearly all that is seen. A film
/// of water darkens what is below it by internal reflection [Lekner and Dorf 1988] and shines. Where heights are given,
/// the mesh is refined to texels and displaced: positions are shared across seams of the UVs, so nothing opens there.
class SurfaceView {
 public:
  /// @param mesh         With UVs; any length unit. Equal positions move together.
  /// @param environment  Radiance all around, linear, 3 channels: the width is 360 degrees, the first row is up.
  ///                     Empty: the lamp and the even light of `options`.
  /// @throws InvalidInput if the mesh or its pieces have no UVs, the mesh has no extent, a map has other channels, a
  /// color
  ///                      is missing, or an option is out of range.
  SurfaceView(const Mesh& mesh, SurfaceMaps maps, const RenderOptions& options, const SurfaceOptions& surface = {},
              ImageF environment = {}, const RunControl& control = {});
  ~SurfaceView();
  SurfaceView(SurfaceView&&) noexcept;
  SurfaceView& operator=(SurfaceView&&) noexcept;

  /// The picture from the camera that `options` describes: height x width x 3, linear, >= 0.
  [[nodiscard]] ImageF picture(const RunControl& control = {}) const;
  /// From another direction; the lamp and the surroundings turn with the camera.
  [[nodiscard]] ImageF picture(double azimuth_deg, double elevation_deg, const RunControl& control = {}) const;

  /// Shows other maps on the same surface, such as those of another time. Occlusion and refinement are kept. Not while
  /// pictures are made. @throws InvalidInput as the constructor.
  void show(SurfaceMaps maps, const RunControl& control = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace patinate
