/// \file
/// What a simulation's history holds of every frame beside its color: gloss, relief, and the amounts themselves.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/history/history.h"
#include "patinate/simulation/engine.h"

namespace patinate::simulation {

/// Names of kFrameExtraNames that frames of the scene have: `specular` always, `normal` and `height` where anything has
/// a height, `metalness` where a preset has it.
[[nodiscard]] std::vector<std::string> frame_map_names(const Scene& scene);

/// Files of frame `index`, relative to the history, in the order of frame_map_names(); the amounts last.
[[nodiscard]] std::vector<std::filesystem::path> frame_map_files(const Scene& scene, int index);

/// The material that a picture shows as a film, water. @returns -1 where the scene has none.
[[nodiscard]] int film_material(const Scene& scene);
/// The material of which small plants grow in a picture: moss, else organic material. @returns -1 where the scene has
/// none.
[[nodiscard]] int plant_material(const Scene& scene);
/// Appearance of the surface below a film of water: water adds no color, gloss or height, which would count it twice.
/// @param looks  By material of the scene.
[[nodiscard]] std::vector<MaterialAppearance> looks_below_film(const Scene& scene,
                                                               std::vector<MaterialAppearance> looks);

/// Bare metal texel by texel, less what has come to lie on it. Water does not cover.
class TexelMetal {
 public:
  /// @param simulation  Outlives this, and does not change meanwhile.
  explicit TexelMetal(const Simulation& simulation) : simulation_(simulation) {}
  /// Whether any object of a scene is made of metal.
  [[nodiscard]] static bool is_in(const Scene& scene);
  /// [0, 1]. @param texel  Inside the charts.
  [[nodiscard]] float at(TexelIndex texel) const;

 private:
  const Simulation& simulation_;
};

/// Bare metal, less what has come to lie on it: H x W x 1, not dilated. Empty where no preset has metalness. Water does
/// not cover.
[[nodiscard]] ImageF metalness_of(const Simulation& simulation);
/// The same with the nearest texel inside beyond the charts, as in exported textures.
[[nodiscard]] ImageF dilated_metalness(Simulation& simulation);

/// Writes them. `specular`: strength 0.04, which dielectrics have, and roughness max(0.05, 1 - specular value), as
/// model.glb has it. `normal`: of the composed relief, in tangent space. `height`: mm. `metalness`: metalness_of(),
/// dilated. Amounts: a channel a material, 1 = a full layer. @param history  Folder. @throws CannotComplete
void write_frame_maps(const std::filesystem::path& history, int index, Simulation& simulation,
                      const RunControl& control = {});

/// Takes the amounts of a frame over. @param file  What write_frame_maps() wrote. @throws IoError if it is of another
/// size or other materials.
void read_frame_amounts(const std::filesystem::path& file, Simulation& simulation);

/// Reads amounts at any time: between two frames their amounts are blended. @param history  Folder with `frames`, all
/// of which have amounts. @throws IoError
void read_frame_amounts(const std::filesystem::path& history, const HistoryManifest& frames, double time,
                        Simulation& simulation);

}  // namespace patinate::simulation
