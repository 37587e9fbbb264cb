/// \file
/// How large texture lies on a mesh: the mesh's unit, the history's pixel, and texels.
#pragma once

#include <optional>

namespace patinate::transfer {

/// Sizes that were known.
enum class ScaleSource {
  Known,         ///< Unit and pixel: texture keeps its true size.
  PixelAssumed,  ///< Unit only: one pixel of the history is taken to cover one texel.
  MeshScaled,    ///< No unit: the mesh is scaled so that one texel equals one pixel.
};

struct TransferScale {
  double mm_per_mesh_unit = 1.0;
  double texel_size_mm = 1.0;  ///< Surface length of one pixel of the history.
  ScaleSource source = ScaleSource::Known;
};

/// @param mm_per_unit  Of the mesh's file, when it is known; > 0.
/// @param pixel_mm  Surface length of one pixel of the history, when it is known; > 0.
/// @param texel_in_mesh_units  Median over the atlas; > 0.
/// @throws InvalidInput
[[nodiscard]] TransferScale choose_scale(std::optional<double> mm_per_unit, std::optional<double> pixel_mm,
                                         double texel_in_mesh_units);

/// Texels along each side of a tile so that a texel equals a pixel of the history: at least 256, and all tiles together
/// no more than 4096 x 4096.
/// @param measured_with  Texels along a side when a texel measured `texel_mm`. @throws InvalidInput unless all are > 0.
[[nodiscard]] int choose_resolution(int measured_with, double texel_mm, double pixel_mm, int num_tiles);

}  // namespace patinate::transfer
