/// \file
/// A mesh with its ages as one binary glTF 2.0 file: one material per time, chosen by KHR_materials_variants.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate {

/// Index of refraction of a dielectric with this reflectance at normal incidence in air. @param reflectance  [0, 1).
[[nodiscard]] double index_of_refraction(double reflectance);

/// A texture that is made while it is written, so that it need not be in memory.
struct GlbTexture {
  int width = 0, height = 0;
  int channels = 3;
  /// Gives its codes to `write`, whole rows, from top to bottom.
  std::function<void(const std::function<void(std::span<const std::uint8_t> rows)>& write)> make;
};

/// One appearance of the mesh. Its textures are made one after the other, while the file is written.
struct GlbAppearance {
  std::string name;                        ///< As GlbVariant::name.
  std::vector<GlbTexture> base_colors;     ///< One a tile; sRGB codes of 3 channels.
  std::vector<GlbTexture> normals = {};    ///< As GlbVariant::normals.
  std::vector<GlbTexture> speculars = {};  ///< As GlbVariant::speculars, one channel.
  /// None, or one a tile: the same and metalness (255 = metal), two channels. A GLB, which keeps both in one texture,
  /// takes it in place of `speculars`; formats with files of their own take `metalness`.
  std::vector<GlbTexture> gloss_and_metal = {};
  std::vector<GlbTexture> metalness = {};  ///< None, or one a tile, one channel.
  /// Largest reflectance of nonmetals at normal incidence; written as KHR_materials_ior if it is not 0.04. [0, 0.99].
  double reflectance = 0.04;
  /// None, or one a tile: what of `reflectance` is reflected; sRGB codes of 3 channels (KHR_materials_specular).
  std::vector<GlbTexture> reflectance_colors = {};
  /// None, or one a tile: along the normal, in the mesh's unit. Not in a GLB; formats with files of their own have
  /// them.
  std::vector<std::function<ImageF()>> heights = {};

  /// It is not what viewers assume.
  [[nodiscard]] bool has_reflectance() const { return reflectance != 0.04 || !reflectance_colors.empty(); }
};

/// One look of the mesh. The first one is what viewers without the extension show.
struct GlbVariant {
  std::string name;                 ///< Shown in viewers, UTF-8, e.g. "12.5 d"; unique.
  std::vector<ImageF> base_colors;  ///< One a tile; linear RGB, any size; stored as 8-bit sRGB PNG.
  std::vector<ImageU8> normals =
      {};  ///< None, or one a tile: tangent-space normals, 127.5 + 127.5 n; x along +u, y along +v (up).
  std::vector<ImageU8> speculars =
      {};  ///< None, or one a tile: specular value, 255 = 1; roughness = max(0.05, 1 - specular).
};

/// Assignment of triangles to the textures of a variant: glTF gets one primitive for each tile, and one material for
/// each tile and variant.
struct GlbTiles {
  std::vector<std::string> names = {""};  ///< One a tile, part of the material's name; UTF-8.
  std::vector<int> triangle_tile = {};    ///< As long as the mesh's triangles; empty when there is one tile.
  /// By tile: the only appearance in which its triangles are seen, and has textures for it; -1 = all. Empty: -1 of all.
  std::vector<int> only_in = {};

  [[nodiscard]] bool is_seen(std::size_t tile, std::size_t appearance) const {
    return only_in.empty() || only_in[tile] < 0 || only_in[tile] == static_cast<int>(appearance);
  }
};

/// Assignment of triangles to objects: each gets its own glTF node, mesh and materials, so that programs can hide, move
/// and change it alone. Textures are shared.
struct GlbObjects {
  std::vector<std::string> names = {};    ///< UTF-8, unique; empty: all is one object, of GlbOptions::name.
  std::vector<int> triangle_object = {};  ///< As long as the mesh's triangles; empty with at most one name.
};

struct GlbOptions {
  std::string name = "object";     ///< Of node and mesh.
  double meters_per_unit = 0.001;  ///< glTF is in meters; > 0. 0.001 for a mesh in mm.
  double roughness = 0.8;          ///< [0, 1]. metallicFactor is 0.
  std::string key = "";            ///< Content key, kept in asset.extras.patinate_key.
  GlbObjects objects = {};
  std::vector<std::string> credits = {};  ///< Whom the textures owe: asset.copyright.
};

/// Writes atomically; equal input gives equal bytes. Axes are kept as they are, v is flipped as glTF asks.
/// Materials are seen from both sides, as files from laboratories mix them. Where a variant has normals, vertices carry
/// tangents.
/// @param mesh  With UVs in [0, 1] of every tile.
/// @throws InvalidInput if the mesh has no UVs, there is no variant, a name occurs twice, a variant has not one texture
/// a tile, a reflectance is out of range, normals have not 3 channels, or a value is not finite; CannotComplete if it
/// cannot be written. Memory: the mesh, and what one texture takes while it is made; the file's bytes wait on the disk,
/// beside its place.
void write_glb(const std::filesystem::path& path, const Mesh& mesh, const GlbTiles& tiles,
               const std::vector<GlbAppearance>& appearance, const GlbOptions& options = {},
               const RunControl& control = {});
/// Writes a GLB from complete images in memory.
void write_glb(const std::filesystem::path& path, const Mesh& mesh, const GlbTiles& tiles,
               const std::vector<GlbVariant>& variants, const GlbOptions& options = {}, const RunControl& control = {});
/// Writes a GLB with a single tile.
void write_glb(const std::filesystem::path& path, const Mesh& mesh, const std::vector<GlbVariant>& variants,
               const GlbOptions& options = {}, const RunControl& control = {});

/// The content key in a GLB that write_glb() made; "" if it carries none or is no GLB. @throws IoError if it cannot be
/// read.
[[nodiscard]] std::string read_glb_key(const std::filesystem::path& path);

}  // namespace patinate
