/// \file
/// Scenes for composing: a mesh, an atlas, amounts that a test sets texel by texel.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/simulation/compose.h"
#include "patinate/simulation/material_atlas.h"

namespace patinate::testing_support {

/// A scene of one object, its atlas and its amounts, all original at first.
struct ComposeScene {
  /// @param appearance  One a material.
  ComposeScene(Mesh mesh, int resolution, std::vector<simulation::MaterialAppearance> appearance,
               const std::function<void(simulation::Scene&)>& change = {});

  /// value(x, y, position in mm) is the new amount of a material; 1 = simulation::kAmountOne; rounded and kept in
  /// range.
  void set(int material, const std::function<double(int, int, const Vec3&)>& value);
  [[nodiscard]] simulation::Composer composer(simulation::ColorForm form = simulation::ColorForm::Normalized) const {
    return {scene, scene_mesh, *surface, form};
  }
  /// Linear color of the whole atlas.
  [[nodiscard]] ImageF composed() const;

  simulation::Scene scene;
  simulation::SceneMesh scene_mesh;
  std::unique_ptr<simulation::SurfaceAtlas> surface;
  std::unique_ptr<TexelMap> map;
  std::unique_ptr<simulation::MaterialAtlas> atlas;
};

/// Looks of eight materials with every kind of number in them, different for each seed.
[[nodiscard]] std::vector<simulation::MaterialAppearance> any_appearance(int num_materials, std::uint64_t seed);
/// How far a picture is from the means of squares of one that is so many times finer, away from its border of 4 pixels.
struct CoarseAgainstFine {
  double mean_square = 0.0;  ///< of the differences of red
  double variance = 0.0;     ///< of the coarse one's red
};
[[nodiscard]] CoarseAgainstFine compare_coarse_with_fine(const ImageF& coarse, const ImageF& fine);

/// Amounts of all materials that vary by texel, some left as they are; pages of the last material stay untouched.
void set_any_amounts(ComposeScene& scene, std::uint64_t seed);

}  // namespace patinate::testing_support
