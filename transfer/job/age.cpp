#include "patinate/transfer/age.h"

#include <memory>
#include <utility>

#include "patinate/atlas/dilate.h"
#include "patinate/core/error.h"
#include "patinate/transfer/transfer_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "transfer/guidance/scale.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::transfer {

ImageF AgedMesh::texture(double time, const RunControl& control) const {
  constexpr int kGutter = 16;
  ImageF out = gather(history->sample(time), coordinates, 0.0f, control);
  dilate(out, coverage, kGutter);
  return out;
}

AgedMesh age_mesh(const std::shared_ptr<const History>& history, Mesh mesh, std::string_view control,
                  const AgeOptions& options, const RunControl& run) {
  const ControlSpec spec = parse_control_spec(control);
  (void)source_control(*history, spec);  // A control that is not there is said before work starts.
  AtlasMesh atlas =
      make_atlas_mesh(with_normals(std::move(mesh)), options.atlas, options.resolution, run.part(0.0, 0.1));
  const double texel = make_texel_map(atlas, options.resolution).median_texel_size_mm();
  const TransferScale scale = choose_scale(options.mm_per_unit, history->facts().texel_size_mm, texel);
  scale_mesh(atlas.mesh, scale.mm_per_mesh_unit);
  const auto map = std::make_shared<TexelMap>(make_texel_map(atlas, options.resolution, run.part(0.1, 0.2)));

  ControlMap made = make_control_expression(spec.destination, *map, options.controls, run.part(0.2, 0.4));
  TransferControl pair = make_transfer_control(*history, spec, std::move(made), map->coverage());
  const TransferResult result =
      transfer({.history = history, .map = map, .texel_size_mm = scale.texel_size_mm, .controls = {pair}},
               options.transfer, run.part(0.4, 1.0));
  return {map->mesh(), coordinate_image(result.coordinates, map->width(), map->height(), history->facts().width),
          map->coverage(), result.energy, history};
}

}  // namespace patinate::transfer
