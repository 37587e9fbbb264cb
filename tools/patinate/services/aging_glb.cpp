#include "tools/patinate/services/aging_glb.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "patinate/history/history_sampling.h"
#include "patinate/image/color.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/services/aging_mesh.h"
#include "transfer/lookup/texture_files.h"

namespace patinate::cli {

namespace {

/// 1 - roughness, in codes.
ImageU8 gloss_codes(const ImageF& roughness) {
  ImageU8 gloss(roughness.width(), roughness.height());
  for (std::size_t i = 0; i < gloss.values().size(); ++i)
    gloss.data()[i] = static_cast<std::uint8_t>(std::clamp(255.5f - 255.0f * roughness.data()[i], 0.0f, 255.0f));
  return gloss;
}

using Write = std::function<void(std::span<const std::uint8_t> rows)>;

/// Of one transfer, for all of its textures.
struct TransferTextures {
  std::shared_ptr<const transfer::TransferFolder> transfer;
  transfer::TextureWriter writer;
  RunControl silent;

  /// @param make  make(tile, write)
  template <class Make>
  [[nodiscard]] std::vector<GlbTexture> tiles(int channels, const Make& make) const {
    std::vector<GlbTexture> out;
    for (std::size_t tile = 0; tile < transfer->sheet().names.size(); ++tile) {
      out.push_back({transfer->manifest().width, transfer->manifest().height, channels,
                     [make, tile](const Write& write) { make(tile, write); }});
    }
    return out;
  }
};

std::vector<GlbAppearance> appearances_of_transfer(const std::shared_ptr<const transfer::TransferFolder>& transfer,
                                                   const std::vector<double>& times,
                                                   const std::vector<std::string>& labels, const RunControl& control) {
  const std::vector<MaterialMap> maps = material_maps(transfer->history().facts());
  const auto has = [&](MaterialMap map) { return std::find(maps.begin(), maps.end(), map) != maps.end(); };
  RunControl silent = control;
  silent.on_progress = {};
  const auto textures = std::make_shared<const TransferTextures>(TransferTextures{
      transfer, transfer::TextureWriter(*transfer, {.with_turns = has(MaterialMap::Normal)}, control), silent});
  const auto map_at = [textures](MaterialMap map, double t) {
    return sample_material_map(textures->transfer->history(), map, t, Between::Blend);
  };
  std::vector<GlbAppearance> appearance;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double t = times[i];
    GlbAppearance& look = appearance.emplace_back();
    look.name = labels[i];
    // Codes of the history's pixels are those of the texels that show them.
    look.base_colors = textures->tiles(3, [textures, t](std::size_t tile, const Write& write) {
      textures->writer.gather_rows(tile, srgb8_from_linear(textures->transfer->history().sample(t)), write,
                                   textures->silent);
    });
    if (has(MaterialMap::Normal)) {
      look.normals = textures->tiles(3, [textures, map_at, t](std::size_t tile, const Write& write) {
        textures->writer.normal_rows(tile, map_at(MaterialMap::Normal, t), write, textures->silent);
      });
    }
    if (has(MaterialMap::Roughness)) {
      look.speculars = textures->tiles(1, [textures, map_at, t](std::size_t tile, const Write& write) {
        textures->writer.gather_rows(tile, gloss_codes(map_at(MaterialMap::Roughness, t)), write, textures->silent);
      });
    }
  }
  return appearance;
}

AgingGlb glb_of_transfer(const std::filesystem::path& path) {
  const auto transfer = std::make_shared<const transfer::TransferFolder>(path);
  const AtlasMesh atlas = transfer->read_atlas();
  const transfer::TransferManifest& m = transfer->manifest();
  AgingGlb out;
  out.key = m.key;
  out.history = transfer->history().manifest();
  out.tiles = {transfer->sheet().names, atlas.triangle_tile};
  out.mesh = unit_square_mesh(atlas);
  out.meters_per_unit = transfer::meters_per_unit(m);
  out.appearance = [transfer](const auto& times, const auto& labels, const RunControl& control) {
    return appearances_of_transfer(transfer, times, labels, control);
  };
  return out;
}

/// A simulation's frames lie over the atlas already: one is in memory at a time.
AgingGlb glb_of_simulation(const std::filesystem::path& path) {
  const auto mesh = std::make_shared<const AgingMesh>(open_aging_mesh(path));
  AgingGlb out{mesh->key,       mesh->history,         {mesh->tile_names, mesh->triangle_tile},
               mesh->unit_mesh, mesh->meters_per_unit, {}};
  out.appearance = [mesh](const std::vector<double>& times, const std::vector<std::string>& labels,
                          const RunControl& control) {
    RunControl silent = control;
    silent.on_progress = {};
    std::vector<GlbAppearance> appearance;
    for (std::size_t i = 0; i < times.size(); ++i) {
      const double t = times[i];
      const auto make = [mesh, silent, t](const Write& write) {
        write(srgb8_from_linear(mesh->sample(t, silent)).values());
      };
      appearance.push_back({labels[i], {GlbTexture{mesh->history.width, mesh->history.height, 3, make}}});
    }
    return appearance;
  };
  return out;
}

}  // namespace

AgingGlb open_aging_glb(const std::filesystem::path& path) {
  return kind_of(path) == PathKind::Simulation ? glb_of_simulation(path) : glb_of_transfer(path);
}

}  // namespace patinate::cli
