#include "app/transfer/destination.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/request/unit_argument.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/geometry/mesh.h"

namespace patinate::app {

namespace {

constexpr double kCoarse = 1.5;  // Pixels a texel: from here on all of the texture is coarser than the history.

/// Says when texels and the history's pixels differ so much that texture is excluded or magnified.
void note_ratio(double pixels_per_texel, double equal_resolution, const Words& say) {
  if (pixels_per_texel > 0.66 && pixels_per_texel < kCoarse) return;
  const Range range = resolution_range();
  const double resolution = std::round(equal_resolution);
  say.note("one texel covers " + short_number_text(pixels_per_texel) + " pixels of the history" +
           (range.contains(resolution)
                ? "; --resolution " + std::to_string(static_cast<int>(resolution)) + " would make them equal"
                : ""));
}

/// Names uneven UVs: lines become dots where texels skip pixels, whatever the resolution of the rest.
void note_large_texels(const TexelMap& map, double pixel_mm, bool is_unwrapped, const Words& say) {
  constexpr double kLarge = 1.3;       // In a pixel's side; a line 1.5 px wide is then missed by some texels.
  constexpr double kMuch = 1.0 / 3.0;  // Share of the surface.
  const double share = map.share_of_larger_texels(kLarge * pixel_mm);
  if (share <= kMuch) return;
  say.warning(percent_text(share, 2) +
              " of the surface has texels more than 1.3 pixels of the history large, so that thin lines "
              "become dots there; use a higher --resolution" +
              (is_unwrapped ? "" : ", or --atlas unwrap for texels of one size"));
}

}  // namespace

void note_scale(const transfer::TransferScale& scale, const Mesh& mesh, const std::string& unit_option,
                const Words& say) {
  if (scale.source == transfer::ScaleSource::PixelAssumed) {
    say.note("the history does not state its texel size, so one pixel of it covers one texel (" +
             short_number_text(scale.texel_size_mm) + " mm); set it with --texel-size");
  } else if (scale.source == transfer::ScaleSource::MeshScaled) {
    const double size = bounding_box(mesh).diagonal();
    say.note(
        "the mesh file states no length unit, so the mesh is scaled until one texel shows one pixel of the history: it "
        "is " +
        short_number_text(rounded(size, 2)) + " mm from corner to corner; set the unit with " + unit_option);
  }
}

void note_texels(const TexelMap& map, double pixel_mm, bool is_unwrapped, const Words& say) {
  const double ratio = map.median_texel_size_mm() / pixel_mm;
  note_ratio(ratio, ratio * map.sheet().tile_width, say);
  if (ratio < kCoarse) note_large_texels(map, pixel_mm, is_unwrapped, say);
}

namespace {

/// A surface on which texture makes no sense: of a few pixels of the history, around which every neighborhood would go
/// many times, or of more than any history can be spread over.
void require_plausible(const MeshSource& source, const transfer::TransferScale& scale, double equal_resolution) {
  constexpr double kLeast = 4.0, kMost = 1e8;  // In the history's pixels, along a side of the atlas.
  if (equal_resolution >= kLeast && equal_resolution <= kMost) return;
  throw IoError(source.path.string(), "with " + number_text(scale.mm_per_mesh_unit) + " mm to its unit and " +
                                          number_text(scale.texel_size_mm) +
                                          " mm to a pixel of the history, its whole surface is " +
                                          short_number_text(rounded(equal_resolution, 2)) +
                                          " pixels wide; expected 4 to 1e8: are --unit and --texel-size right?");
}

/// Nobody who reads "default 1024" expects 4096 x 4096 texels, and what they take.
void note_chosen(int resolution, std::size_t num_tiles, const Words& say) {
  const std::string size = size_text(resolution, resolution) + (num_tiles > 1 ? " texels a tile" : " texels");
  say.note("chose a resolution of " + size +
           " to show every pixel of the history (between 256 and 4096 along a side); change it with --resolution");
}

}  // namespace

Destination make_destination(const MeshSource& source, const AtlasOptions& options, bool is_resolution_given,
                             std::optional<double> pixel_mm, const Words& say) {
  Destination out;
  out.unit = source.unit_or_none();
  const Mesh mesh = load_mesh(source, say);
  AtlasMesh atlas = make_atlas(source, mesh, options, say.phase("atlas"));
  auto unscaled = std::make_unique<TexelMap>(make_texel_map(source, atlas, options.resolution, say.phase("atlas")));
  if (unscaled->num_covered() == 0) {
    throw IoError(source.path.string(), "its UVs cover no texel; use a larger --resolution, or --atlas unwrap");
  }
  const double texel = unscaled->median_texel_size_by_area_mm();
  const auto mm = out.unit ? std::optional(mm_per_unit(*out.unit)) : std::nullopt;
  const transfer::TransferScale scale = transfer::choose_scale(mm, pixel_mm, texel);
  out.mm_per_mesh_unit = scale.mm_per_mesh_unit;
  out.texel_size_mm = scale.texel_size_mm;
  AtlasOptions chosen = options;
  require_plausible(source, scale, options.resolution * texel * scale.mm_per_mesh_unit / scale.texel_size_mm);
  if (!is_resolution_given && out.unit && pixel_mm) {
    chosen.resolution = transfer::choose_resolution(options.resolution, texel * scale.mm_per_mesh_unit, *pixel_mm,
                                                    static_cast<int>(atlas.tiles.size()));
    note_chosen(chosen.resolution, atlas.tiles.size(), say);
  }
  say.decided("resolution", std::to_string(chosen.resolution));
  unscaled.reset();
  // An unwrapped atlas keeps its gutters for the number of texels it was made with.
  if (atlas.is_unwrapped && chosen.resolution != options.resolution)
    atlas = make_atlas(source, mesh, chosen, say.phase("atlas"));
  note_atlas(source, atlas, say);
  scale_mesh(atlas.mesh, scale.mm_per_mesh_unit);
  note_scale(scale, atlas.mesh, "--unit", say);
  out.map = std::make_shared<TexelMap>(make_texel_map(source, atlas, chosen.resolution, say.phase("atlas")));
  out.atlas = std::make_shared<AtlasMesh>(std::move(atlas));
  note_texels(*out.map, out.texel_size_mm, out.atlas->is_unwrapped, say);
  return out;
}

}  // namespace patinate::app
