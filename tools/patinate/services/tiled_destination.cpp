#include "tools/patinate/services/tiled_destination.h"

#include <algorithm>
#include <utility>

#include "libcommon/controls/part_controls.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/usage_error.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::cli {

Destination make_tiled_destination(const MeshSource& source, const AtlasOptions& options, bool is_resolution_given,
                                   std::optional<double> pixel_mm, CommandRun& run) {
  Destination out;
  out.unit = source.unit_or_none();
  std::string missing;
  const auto need = [&](bool is_there, const char* what) {
    if (!is_there) missing += (missing.empty() ? "" : ", ") + std::string(what);
  };
  need(out.unit.has_value(), "--unit");
  need(is_resolution_given, "--resolution");
  need(pixel_mm.has_value(), "--texel-size");
  if (!missing.empty())
    throw UsageError("--by-tile: no texel is counted before the first item runs, so that sizes have to be given: " +
                     missing);
  const Mesh mesh = load_mesh(source, run);
  AtlasMesh atlas = make_atlas(source, mesh, options, run.control("atlas"));
  if (atlas.is_unwrapped || atlas.tiles.size() < 2)
    throw IoError(source.path.string(), "--by-tile expects UVs of several tiles (UDIM, or a square a material)");
  out.mm_per_mesh_unit = mm_per_unit(*out.unit);
  out.texel_size_mm = *pixel_mm;
  run.line.decided("resolution", std::to_string(options.resolution));
  scale_mesh(atlas.mesh, out.mm_per_mesh_unit);
  const Sheet sheet = make_sheet(atlas.tile_names(), options.resolution, Sheet::kMaxPartTexels);
  out.map =
      std::make_shared<TexelMap>(sheet_mesh(atlas, sheet), sheet, run.control("atlas"), TexelFinding::WhereLooked);
  out.atlas = std::make_shared<AtlasMesh>(std::move(atlas));
  return out;
}

std::vector<transfer::TransferControl> make_tiled_controls(std::span<const transfer::ControlSpec> specs,
                                                           const HistoryReader& history, const TexelMap& map,
                                                           const ControlKindOptions& kinds) {
  const TexelRect first{0, 0, 1, 1};
  std::vector<transfer::TransferControl> controls = transfer::make_transfer_controls(
      history, specs, ImageU8(1, 1), [&](std::size_t, const transfer::ControlSpec& spec) {
        return make_part_control(spec.destination, map, first, kinds);
      });
  for (transfer::TransferControl& control : controls) control.values = {};
  return controls;
}

}  // namespace patinate::cli
