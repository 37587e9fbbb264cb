#include "tools/patinate/destination.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/core/error.h"
#include "libcommon/core/text.h"

namespace patinate {

namespace {

/// The destination in mm and the surface length of one history pixel.
struct Scale {
  double mm_per_mesh_unit = 1.0;
  double texel_size_mm = 1.0;
  std::string note;  ///< What the command says when the sizes were chosen, not known.
};

/// @param texel_size_in_mesh_units  Median over the atlas.
Scale choose_scale(const std::optional<std::string>& unit, std::optional<double> pixel_mm, double texel_size_in_mesh_units) {
  if (unit) {
    const double mm = mm_per_unit(*unit);
    if (pixel_mm) return {mm, *pixel_mm, ""};
    return {mm, texel_size_in_mesh_units * mm,
            "the history has no texel size: one pixel of it covers one texel (" + number_text(texel_size_in_mesh_units * mm) +
                " mm); --texel-size sets it"};
  }
  const double size = pixel_mm.value_or(1.0);
  return {size / texel_size_in_mesh_units, size, "the mesh has no unit: it is scaled so that one texel equals one pixel of the history; --unit sets it"};
}

/// Texels along each side of a tile so that a texel equals a pixel.
int choose_resolution(int measured_with, double texel_mm, double pixel_mm, const AtlasMesh& atlas) {
  constexpr double kLeast = 256.0, kMost = 4096.0;
  const double most = std::max(kLeast, std::floor(kMost / std::sqrt(static_cast<double>(atlas.tiles.size()))));
  return static_cast<int>(std::clamp(std::round(measured_with * texel_mm / pixel_mm), kLeast, most));
}

/// Says when texels and the history's pixels differ so much that texture is left out or magnified.
void note_ratio(double pixels_per_texel, int resolution, CommandRun& run) {
  if (pixels_per_texel > 0.66 && pixels_per_texel < 1.5) return;
  run.note("one texel covers " + short_number_text(pixels_per_texel) + " pixels of the history; --resolution " +
           std::to_string(static_cast<int>(std::round(resolution * pixels_per_texel))) + " would make them equal");
}

}  // namespace

Destination make_destination(const MeshSource& source, const AtlasOptions& options, bool is_resolution_given,
                             std::optional<double> pixel_mm, CommandRun& run) {
  Destination out;
  out.unit = source.unit_or_none();
  const Mesh mesh = load_mesh(source, run);
  AtlasMesh atlas = make_atlas(source, mesh, options, run.control("atlas"));
  auto unscaled = std::make_unique<TexelMap>(make_texel_map(source, atlas, options.resolution, run.control("atlas")));
  if (unscaled->num_covered() == 0) {
    throw IoError(source.path.string(), "its UVs cover no texel; use a larger --resolution, or --atlas unwrap");
  }
  const Scale scale = choose_scale(out.unit, pixel_mm, unscaled->median_texel_size_mm());
  out.mm_per_mesh_unit = scale.mm_per_mesh_unit;
  out.texel_size_mm = scale.texel_size_mm;
  AtlasOptions chosen = options;
  if (!is_resolution_given && out.unit && pixel_mm) {
    chosen.resolution = choose_resolution(options.resolution, unscaled->median_texel_size_mm() * scale.mm_per_mesh_unit, *pixel_mm, atlas);
  }
  unscaled.reset();
  // An unwrapped atlas keeps its gutters for the number of texels it was made with.
  if (atlas.is_unwrapped && chosen.resolution != options.resolution) atlas = make_atlas(source, mesh, chosen, run.control("atlas"));
  note_atlas(source, atlas, run);
  if (!scale.note.empty()) run.note(scale.note);
  scale_mesh(atlas.mesh, scale.mm_per_mesh_unit);
  out.map = std::make_shared<TexelMap>(make_texel_map(source, atlas, chosen.resolution, run.control("atlas")));
  out.atlas = std::make_shared<AtlasMesh>(std::move(atlas));
  note_ratio(out.map->median_texel_size_mm() / out.texel_size_mm, chosen.resolution, run);
  return out;
}

}  // namespace patinate
