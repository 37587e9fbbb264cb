/// \file
/// Scenes to begin with: one mesh, and what ages it.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace patinate::studio {

/// A way of aging that fits any mesh.
struct BeginPreset {
  std::string_view name;   ///< "rust"
  std::string_view title;  ///< For people.
  std::string_view about;  ///< One sentence.
  std::string_view text;   ///< The scene file with `<WORD>`s in place of what depends on the mesh.
};
[[nodiscard]] const std::array<BeginPreset, 5>& begin_presets();

struct BeginOptions {
  std::string preset;       ///< Name of a preset.
  std::string unit = "mm";  ///< Of the mesh file; glTF is in m.
  bool is_z_up = false;     ///< Up is +z, otherwise +y.
  int resolution = 512;     ///< Of the atlas, texels along each side.
};

/// Text of a scene file with one object.
/// @param mesh  As the file names it. @param size  Diagonal of the mesh, in the unit; > 0. Lengths of noise and the
/// speed of rain follow it.
/// @throws InvalidInput for an unknown preset or unit.
[[nodiscard]] std::string begin_scene_text(const std::string& object, const std::string& mesh, double size,
                                           const BeginOptions& options);

}  // namespace patinate::studio
