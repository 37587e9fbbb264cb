#include "simulation/job/layer_rows.h"

#include "patinate/simulation/layer_atlas.h"

namespace patinate::simulation {

void describe(DocumentVisitor& v, LayerRow& row) {
  v.member({"object"}, row.object);
  v.member({"layer"}, row.layer);
  v.member({.name = "start", .help = "mm3.", .range = at_least(0)}, row.start);
  v.member({.name = "worn", .help = "Taken by rules.", .range = at_least(0)}, row.worn);
  v.member({.name = "flaked", .help = "Fallen off.", .range = at_least(0)}, row.flaked);
  v.member({.name = "remains", .help = "start - worn - flaked, exactly.", .range = at_least(0)}, row.remains);
}

std::vector<LayerRow> layer_rows(const Simulation& simulation, const RunControl& control) {
  const LayerAtlas* layers = simulation.layers();
  if (!layers) return {};
  constexpr double kMmPerUm = 1e-3;
  const double texel_mm = simulation.texel_size_mm();
  const double one = kMmPerUm / LayerAtlas::kQuantaPerUm * texel_mm * texel_mm / SurfaceAtlas::kMedianWeight;
  const std::vector<std::int64_t> remaining = layers->remaining(control);
  std::vector<LayerRow> rows;
  for (int object = 0; object < layers->num_objects(); ++object) {
    for (int l = 1; l < layers->num_layers(object); ++l) {
      const LayerAccount& account = layers->account(object, l);
      rows.push_back({.object = simulation.scene().objects[object].name,
                      .layer = layers->name(object, l),
                      .start = account.start.value() * one,
                      .worn = account.worn.value() * one,
                      .flaked = account.flaked.value() * one,
                      .remains = static_cast<double>(remaining[LayerAtlas::account_index(object, l)]) * one});
    }
  }
  return rows;
}

}  // namespace patinate::simulation
