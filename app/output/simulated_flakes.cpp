#include "app/output/simulated_flakes.h"

#include <algorithm>
#include <string>
#include <utility>

#include "patinate/atlas/dilate.h"
#include "patinate/simulation/layer_atlas.h"
#include "simulation/flakes/flake_shells.h"
#include "simulation/flakes/lifted_flakes.h"

namespace patinate::app {

namespace {

/// Texels beside a flake that show its own colors: filters and squares of kMostFlakeStep texels reach no farther.
constexpr int kRim = simulation::kMostFlakeStep + 2;

/// Changes what lies at texels of a simulation, map by map.
class StateEditor {
 public:
  explicit StateEditor(simulation::Simulation& simulation)
      : simulation_(simulation), names_(simulation.layer_map_names()) {}

  /// f(value, texel number) for all texels of a map that a layer has. @param kind  "thickness_um" or "interface.rust".
  template <class F>
  void edit(int layer, const std::string& kind, const F& f) {
    const auto found = std::find(names_.begin(), names_.end(), "layer" + std::to_string(layer) + "." + kind);
    if (found == names_.end()) return;
    const auto index = static_cast<std::size_t>(found - names_.begin());
    ImageF map = simulation_.layer_map(index);
    for (std::size_t i = 0; i < map.values().size(); ++i) f(map.values()[i], i);
    simulation_.set_layer_map(index, map);
  }
  [[nodiscard]] ImageF interface_map(int layer, const std::string& material) const {
    const auto found =
        std::find(names_.begin(), names_.end(), "layer" + std::to_string(layer) + ".interface." + material);
    return found == names_.end() ? ImageF() : simulation_.layer_map(static_cast<std::size_t>(found - names_.begin()));
  }

 private:
  simulation::Simulation& simulation_;
  std::vector<std::string> names_;
};

/// The layer that leaves a texel with its flake, or with a crack beside one; 0 = none.
std::vector<std::uint8_t> leaving_layers(const simulation::LiftedFlakes& lifted) {
  std::vector<std::uint8_t> layers(lifted.flake.size(), 0);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const std::int32_t flake = lifted.flake[i];
    if (flake >= 0) {
      layers[i] = static_cast<std::uint8_t>(lifted.flakes[static_cast<std::size_t>(flake)].layer);
    } else if (lifted.bare[i] != 0) {
      layers[i] = lifted.cracked[i];
    }
  }
  return layers;
}

/// Flat at the rims: slopes there are of the edge, which the geometry has.
void flatten_rims(const simulation::LiftedFlakes& lifted, ImageF& normals) {
  for (int y = 0; y < lifted.height; ++y) {
    for (int x = 0; x < lifted.width; ++x) {
      const std::int32_t flake = lifted.flake[lifted.index(x, y)];
      if (flake < 0) continue;
      const int layer = lifted.flakes[static_cast<std::size_t>(flake)].layer;
      bool is_rim = false;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (!lifted.is_inside(x + dx, y + dy)) continue;
          const std::size_t i = lifted.index(x + dx, y + dy);
          is_rim = is_rim || (lifted.flake[i] != flake && (lifted.holds[i] >> layer & 1U) == 0);
        }
      }
      if (!is_rim) continue;
      const std::span<float> normal = normals.pixel(x, y);
      normal[0] = normal[1] = 0.0F;
      normal[2] = 1.0F;
    }
  }
}

/// Shows flakes and their rims alone; all else has one value, so that a file of it is small.
void keep_flakes(SurfaceMaps& maps, const ImageU8& is_flake) {
  ImageU8 is_near = is_flake;
  dilate(is_near, is_flake, kRim);
  const auto first = std::find(is_flake.values().begin(), is_flake.values().end(), 255) - is_flake.values().begin();
  for (ImageF* map : {&maps.color, &maps.normals, &maps.roughness, &maps.metalness, &maps.specular, &maps.height,
                      &maps.wetness, &maps.plants}) {
    if (map->empty()) continue;
    dilate(*map, is_flake, kRim);
    const int channels = map->channels();
    for (std::int64_t i = 0; i < map->num_pixels(); ++i) {
      if (is_near.data()[i] == 0) std::copy_n(map->data() + first * channels, channels, map->data() + i * channels);
    }
  }
}

}  // namespace

void describe(OptionVisitor& v, FlakeOptions& o) {
  v.visit({"flakes", "Simulations: lifted flakes of layers are thin curled shells, not only heights"}, o.flakes);
}

SurfaceMaps maps_and_flakes(simulation::Simulation& simulation, const ComposedMaps& compose,
                            const std::function<const TexelMap&()>& map, double relief, const RunControl& control) {
  const simulation::LayerAtlas* layers = simulation.layers();
  if (layers == nullptr || !layers->has_cracks()) return compose(control);
  const simulation::LiftedFlakes lifted = simulation::find_lifted_flakes(*layers);
  if (std::all_of(lifted.lifted.begin(), lifted.lifted.end(), [](std::uint8_t l) { return l == 0; }))
    return compose(control);
  const std::vector<std::uint8_t> leaving = leaving_layers(lifted);
  ImageU8 is_flake(lifted.width, lifted.height);
  for (std::size_t i = 0; i < leaving.size(); ++i) is_flake.values()[i] = lifted.flake[i] >= 0 ? 255 : 0;
  const int num_layers = layers->num_layers();
  StateEditor editor(simulation);

  for (int l = 1; l < num_layers; ++l) {  // What is held down has no lift.
    editor.edit(l, "adhesion",
                [&](float& adhesion, std::size_t i) { adhesion = lifted.lifted[i] == l ? 1.0F : adhesion; });
  }
  if (lifted.flakes.empty()) return compose(control);
  SurfaceMaps tops = compose(control.part(0.0, 0.3));
  const ImageF whole_normals = tops.normals;
  if (!tops.normals.empty()) flatten_rims(lifted, tops.normals);
  keep_flakes(tops, is_flake);
  for (float& height : tops.height.values()) height *= static_cast<float>(relief);
  simulation::FlakeShells shells = simulation::flake_shells(lifted, map(), relief > 0.0 ? tops.height : ImageF(),
                                                            simulation::kMostFlakeTriangles, control.part(0.3, 0.4));

  // What lies at interfaces is seen below flakes, and on what they leave bare.
  const std::vector<std::string>& materials = simulation.scene().materials;
  std::vector<ImageF> before;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    ImageF amounts = before.emplace_back(simulation.amounts(static_cast<int>(m)));
    for (std::size_t i = 0; i < leaving.size(); ++i) amounts.values()[i] = leaving[i] != 0 ? 0.0F : amounts.values()[i];
    for (int l = 1; l < num_layers; ++l) {
      const ImageF below = editor.interface_map(l, materials[m]);
      for (std::size_t i = 0; !below.empty() && i < leaving.size(); ++i) {
        if (leaving[i] == l) amounts.values()[i] = below.values()[i];
      }
    }
    simulation.set_amounts(static_cast<int>(m), amounts);
  }
  SurfaceMaps undersides = compose(control.part(0.4, 0.7));
  undersides.normals = ImageF();
  keep_flakes(undersides, is_flake);

  const auto is_bare = [&](int l, std::size_t i) { return lifted.bare[i] != 0 && leaving[i] == l; };
  for (std::size_t m = 0; m < materials.size(); ++m) {
    ImageF amounts = simulation.amounts(static_cast<int>(m));
    for (std::size_t i = 0; i < leaving.size(); ++i) {
      if (lifted.bare[i] == 0) amounts.values()[i] = before[m].values()[i];
    }
    simulation.set_amounts(static_cast<int>(m), amounts);
  }
  for (int l = 1; l < num_layers; ++l) {
    const auto empty = [&](float& value, std::size_t i) { value = is_bare(l, i) ? 0.0F : value; };
    for (const std::string& material : materials) editor.edit(l, "interface." + material, empty);
    editor.edit(l, "thickness_um", empty);
  }
  SurfaceMaps maps = compose(control.part(0.7, 1.0));
  // Where the layer goes on below a flake it is as it was: the step down to what is bare is hidden.
  for (std::size_t i = 0; !maps.normals.empty() && i < leaving.size(); ++i) {
    if (lifted.flake[i] >= 0 && lifted.bare[i] == 0)
      std::copy_n(&whole_normals.values()[3 * i], 3, &maps.normals.values()[3 * i]);
  }
  SurfacePieces pieces{.mesh = std::move(shells.mesh), .materials = {}, .maps = {}};
  for (const simulation::FlakeSide side : shells.sides) pieces.materials.push_back(static_cast<std::uint8_t>(side));
  pieces.maps.push_back(std::move(tops));
  pieces.maps.push_back(std::move(undersides));
  maps.pieces = std::make_shared<const SurfacePieces>(std::move(pieces));
  return maps;
}

}  // namespace patinate::app
