/// \file
/// Textures of a model as files beside it, for formats that name files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/output/glb.h"

namespace patinate {

/// Files of a model's textures, relative to it: [time][tile]. Kinds that are not known are empty.
struct TextureFiles {
  using Series = std::vector<std::vector<std::string>>;
  Series base_colors;  ///< sRGB PNG.
  Series normals;      ///< PNG, tangent space, 127.5 + 127.5 n.
  Series roughness;    ///< PNG, 255 = 1.
  Series metalness;    ///< PNG, 255 = metal.
  Series heights;      ///< Float EXR, channel Y, in the mesh's unit.
  Series reflectance;  ///< sRGB PNG: share of `reflectances` at the time; at each as many as it has, perhaps none.
  std::vector<double> reflectances;  ///< GlbAppearance::reflectance, one a time.

  [[nodiscard]] std::vector<const Series*> all() const {
    return {&base_colors, &normals, &roughness, &metalness, &heights, &reflectance};
  }
};

/// Writes the textures of one time into `folder` and names them. @param prefix  Of the names: "bust.textures/".
/// @param time  Its number, part of the names. @param key  Content key that each file carries; "" = none.
/// A texture without pixels, or a height that nothing makes, has the name "": fill_gaps().
/// @throws CannotComplete
void write_textures(const std::filesystem::path& folder, const std::string& prefix, std::size_t time,
                    const GlbAppearance& look, const std::string& key, TextureFiles& files);

/// Names for textures that were not written, since their tile is seen at another time alone: that time's.
void fill_gaps(TextureFiles& files);

/// @throws CannotComplete where a folder holds anything but textures of ours.
void require_own_textures(const std::filesystem::path& folder);
/// A material's name for a tile: "material", "material_1001".
[[nodiscard]] std::string tile_material(const std::string& tile);

/// A folder beside the output that goes when it is not kept.
class WorkFolder {
 public:
  /// Makes it anew. @throws CannotComplete
  explicit WorkFolder(std::filesystem::path path);
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Takes the place of `to`. @throws CannotComplete also where `to` holds anything but textures of ours.
  void keep_as(const std::filesystem::path& to);

 private:
  std::filesystem::path path_;
};

}  // namespace patinate
