#include "patinate/transfer/age.h"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/mesh_repair.h"
#include "libcommon/history/footprint.h"
#include "patinate/atlas/dilate.h"
#include "patinate/core/error.h"
#include "patinate/transfer/time_map.h"
#include "patinate/transfer/transfer_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "transfer/files/flow_io.h"
#include "transfer/guidance/scale.h"
#include "transfer/lookup/packed_lookup.h"
#include "transfer/lookup/source_turn.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::transfer {

namespace {

constexpr int kGutter = 16;  // Texels that are filled around charts.

}  // namespace

void describe_surface(OptionVisitor& v, AgeOptions& o) {
  v.visit({"resolution", "Texels along each side of the atlas, or of each of its tiles", "", between(16, 16384)},
          o.resolution);
  v.visit_choice(
      {"atlas", "auto: use the mesh's UVs if each place has its own texel, else unwrap; uv, unwrap: always do so"},
      o.atlas, kAtlasMethodNames);
  v.visit({"mm_per_unit",
           "Length of the mesh's unit; not given: the mesh is scaled so that one texel equals one pixel of the history",
           "mm", above(0)},
          o.mm_per_unit);
  v.visit({"texel_size", "Surface length of one pixel of the history; not given: what the history says", "mm",
           between(kMinTexel_mm, kLargestTexel_mm)},
          o.texel_size_mm);
}

void describe(OptionVisitor& v, AgeOptions& o) {
  describe_surface(v, o);
  v.visit_choice(
      {"flow",
       "Orientation of the photographs on the surface: gravity (down stays down, by --up), curvature (along tubes and "
       "ridges), uv (as each chart lies), or a CSV of curves to follow (x,y,z in mm, an empty line ends a curve)"},
      o.flow, kDirectionKindNames);
  describe(v, o.transfer);
  describe(v, o.controls);
}

namespace {

/// Gutters filled, tile by tile, so that no tile bleeds into another.
void fill_tiles(ImageF& values, const ImageU8& coverage, const Sheet& sheet) {
  if (sheet.num_tiles() == 1) return dilate(values, coverage, kGutter);
  for (int i = 0; i < sheet.num_tiles(); ++i) {
    ImageF tile = cut_tile(values, sheet, i);
    dilate(tile, cut_tile(coverage, sheet, i), kGutter);
    paste_tile(values, sheet, i, tile);
  }
}

}  // namespace

const Sheet& AgedMesh::sheet() const { return folder ? folder->sheet() : surface.map->sheet(); }

ImageF AgedMesh::texture(double time, Between between, const RunControl& control) const {
  return gather_sheet(sample(*shown, time, between), control);
}

ImageF AgedMesh::gather_sheet(const ImageF& source, const RunControl& control) const {
  if (folder) return folder->gather_sheet(source, control);
  return gather_packed(source, filled_places(coordinates, source.width(), source.height(), sheet()), 0.0f, control);
}

ImageF AgedMesh::material_map(MaterialMap kind, double time, Between between, const RunControl& control) const {
  if (folder) return folder->sample_map(kind, time, between, control);
  const ImageF source = sample_material_map(*shown, kind, time, between);
  const PackedPlaces places = filled_places(coordinates, source.width(), source.height(), sheet());
  ImageF values = gather_packed(source, places, 0.0f, control);
  if (kind != MaterialMap::Normal) return values;
  make_unit_between(places.view(), values.values());
  if (frames) {
    Image<std::uint32_t> patches = packed_turns(*surface.map, *frames, turns);
    fill_sheet(patches, sheet());
    turn_normals(patches.values(), values.values());
  }
  return values;
}

ImageF AgedMesh::texture(const ImageF& times, Between between, const RunControl& control) const {
  ImageF out = gather_at_times(*shown, coordinates, times, between, control);
  fill_tiles(out, coverage, sheet());
  return out;
}

AgedMesh read_aged_mesh(const std::filesystem::path& path) {
  const auto folder = std::make_shared<const TransferReader>(path);
  const TransferManifest& m = folder->manifest();
  const std::shared_ptr<const History> history(folder, &folder->history());
  return {.mesh = folder->mesh(),
          .coordinates = folder->coordinates(),
          .coverage = folder->coverage(),
          .energy = m.energy,
          .history = history,
          .shown = history,
          .surface = {.atlas = {folder, &folder->atlas()},
                      .map = nullptr,
                      .texel_size_mm = m.texel_size_mm,
                      .mm_per_mesh_unit = m.mm_per_mesh_unit,
                      .name = m.made_from,
                      .unit = m.unit},
          .folder = folder};
}

AgingSurface make_aging_surface(Mesh mesh, const AgeOptions& options, const HistoryFacts* history,
                                const RunControl& run) {
  check_ranges(options);
  AtlasMesh atlas = make_atlas_mesh(with_normals(repair_mesh(std::move(mesh)).mesh), options.atlas, options.resolution,
                                    run.part(0.0, 0.5));
  const double texel = make_texel_map(atlas, options.resolution).median_texel_size_by_area_mm();
  const std::optional<double> pixel_mm =
      options.texel_size_mm || history == nullptr ? options.texel_size_mm : history->texel_size_mm;
  const TransferScale scale = choose_scale(options.mm_per_unit, pixel_mm, texel);
  scale_mesh(atlas.mesh, scale.mm_per_mesh_unit);
  auto map = std::make_shared<const TexelMap>(make_texel_map(atlas, options.resolution, run.part(0.5, 1.0)));
  AgingSurface surface{.atlas = std::make_shared<const AtlasMesh>(std::move(atlas)),
                       .map = std::move(map),
                       .texel_size_mm = scale.texel_size_mm,
                       .mm_per_mesh_unit = scale.mm_per_mesh_unit};
  for (std::size_t i = 0; options.mm_per_unit && i < kLengthUnitNames.size(); ++i) {
    if (kMmPerLengthUnit[i] == *options.mm_per_unit) surface.unit = kLengthUnitNames[i];
  }
  return surface;
}

TransferControl make_control_pair(const History& history, std::string_view control, const TexelMap& map,
                                  const ControlKindOptions& options, const RunControl& run) {
  const std::string text(control);
  // A control that is not there is said before work starts.
  const std::vector<ControlSpec> specs = with_sources(history, parse_controls(std::span(&text, 1)));
  return make_transfer_control(history, specs.front(),
                               make_control_expression(specs.front().destination, map, options, run), map.coverage());
}

AgedMesh age_surface(const std::shared_ptr<const History>& history, const AgingSurface& surface,
                     std::vector<TransferControl> controls, const AgeOptions& options, const RunControl& run) {
  const TexelMap& map = *surface.map;
  std::shared_ptr<const FlowFrames> frames;
  if (options.flow != DirectionKind::Uv) {
    const std::array<double, 3>& up = options.controls.up;
    frames = std::make_shared<const FlowFrames>(
        direction_frames(map, options.flow, Vec3(up[0], up[1], up[2]), run.part(0.0, 0.05)));
  }
  TransferInput input{.history = history,
                      .map = surface.map,
                      .texel_size_mm = surface.texel_size_mm,
                      .controls = std::move(controls),
                      .frames = frames,
                      .device = options.device};
  TransferResult result = transfer(input, options.transfer, run.part(0.05, 1.0));
  const double pixels = footprint_px(map, surface.texel_size_mm, options.transfer.footprint);
  return {.mesh = map.mesh(),
          .coordinates = coordinate_image(result, map.width(), map.height(), history->facts().width),
          .coverage = map.coverage(),
          .energy = result.energy,
          .history = history,
          .shown = pixels > 1.0 ? std::make_shared<const FootprintHistory>(history, pixels) : history,
          .surface = surface,
          .controls = std::move(input.controls),
          .used = result.used,
          .frames = std::move(frames),
          .turns = std::move(result.turns),
          .asked = options.transfer,
          .flow = options.flow,
          .explained_variance = result.explained_variance,
          .structure = result.structure,
          .refused_line_share = result.refused_line_share};
}

AgedMesh age_mesh(const std::shared_ptr<const History>& history, Mesh mesh, std::string_view control,
                  const AgeOptions& options, const RunControl& run) {
  (void)source_control(*history, parse_control_spec(control));
  const AgingSurface surface = make_aging_surface(std::move(mesh), options, &history->facts(), run.part(0.0, 0.2));
  TransferControl pair = make_control_pair(*history, control, *surface.map, options.controls, run.part(0.2, 0.4));
  return age_surface(history, surface, {std::move(pair)}, options, run.part(0.4, 1.0));
}

}  // namespace patinate::transfer
