#include "app/output/aging_glb.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "app/output/aging_mesh.h"
#include "app/output/flake_model.h"
#include "app/output/simulated_maps.h"
#include "app/output/texture_codes.h"
#include "app/request/path_kind.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/atlas/sheet.h"
#include "patinate/core/error.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/color.h"
#include "simulation/job/simulation_job.h"
#include "transfer/lookup/texture_files.h"

namespace patinate::app {

namespace {

/// Reflectance of dielectrics at a time, where it is not glTF's default of 0.04.
struct Reflectance {
  double most = 0.04;
  ImageF colors;  ///< Shares of `most`; empty: all of it everywhere.
};

Reflectance reflectance_at(const History& history, double time) {
  constexpr double kLargest = 0.99, kUsual = 0.04, kRounding = 1e-4;  // Files may hold half floats.
  ImageF f0 = sample_reflectance(history, time, Between::Blend);
  if (f0.empty()) return {};
  const auto [least, most] = std::minmax_element(f0.values().begin(), f0.values().end());
  const double low = static_cast<double>(*least), high = static_cast<double>(*most);
  if (std::abs(low - kUsual) < kRounding && std::abs(high - kUsual) < kRounding) return {};
  Reflectance out{.most = std::min(high, kLargest), .colors = {}};
  if (high - low < kRounding || high == 0.0) return out;
  for (float& v : f0.values()) v = static_cast<float>(static_cast<double>(v) / high);
  out.colors = std::move(f0);
  return out;
}

/// Textures of one transfer, for all of its times.
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
                     [make, tile](const WriteRows& write) { make(tile, write); }});
    }
    return out;
  }
};

std::vector<GlbAppearance> appearances_of_transfer(const std::shared_ptr<const transfer::TransferFolder>& transfer,
                                                   const std::vector<double>& times,
                                                   const std::vector<std::string>& labels, const RunControl& control) {
  const std::vector<MaterialMap> maps = material_maps(transfer->history().facts());
  const auto has = [&](MaterialMap map) { return std::find(maps.begin(), maps.end(), map) != maps.end(); };
  const RunControl silent = control.silent();
  transfer::TextureWriter writer(*transfer, {.with_turns = has(MaterialMap::Normal)}, control);
  const auto textures = std::make_shared<const TransferTextures>(TransferTextures{transfer, std::move(writer), silent});
  const auto map_at = [textures](MaterialMap map, double t) {
    return sample_material_map(textures->transfer->history(), map, t, Between::Blend);
  };
  std::vector<GlbAppearance> appearance;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double t = times[i];
    GlbAppearance& look = appearance.emplace_back();
    look.name = labels[i];
    look.base_colors = textures->tiles(3, [textures, t](std::size_t tile, const WriteRows& write) {
      textures->writer.gather_rows(tile, sample_base_color(textures->transfer->history(), t, Between::Blend),
                                   transfer::color_codes, write, textures->silent);
    });
    if (has(MaterialMap::Normal)) {
      look.normals = textures->tiles(3, [textures, map_at, t](std::size_t tile, const WriteRows& write) {
        textures->writer.normal_rows(tile, map_at(MaterialMap::Normal, t), write, textures->silent);
      });
    }
    if (has(MaterialMap::Roughness)) {
      look.speculars = textures->tiles(1, [textures, map_at, t](std::size_t tile, const WriteRows& write) {
        textures->writer.gather_rows(tile, map_at(MaterialMap::Roughness, t), gloss_codes, write, textures->silent);
      });
    }
    if (has(MaterialMap::Metalness)) {
      look.metalness = textures->tiles(1, [textures, map_at, t](std::size_t tile, const WriteRows& write) {
        textures->writer.gather_rows(tile, map_at(MaterialMap::Metalness, t), unit_codes, write, textures->silent);
      });
    }
    if (has(MaterialMap::Metalness)) {
      const bool has_roughness = has(MaterialMap::Roughness);
      look.gloss_and_metal =
          textures->tiles(2, [textures, map_at, has_roughness, t](std::size_t tile, const WriteRows& write) {
            const ImageF roughness = has_roughness ? map_at(MaterialMap::Roughness, t) : ImageF();
            textures->writer.gather_rows(tile, roughness_and_metalness(roughness, map_at(MaterialMap::Metalness, t)),
                                         gloss_and_metal_codes, write, textures->silent);
          });
    }
    const Reflectance reflectance = reflectance_at(transfer->history(), t);
    look.reflectance = reflectance.most;
    if (!reflectance.colors.empty()) {
      look.reflectance_colors = textures->tiles(3, [textures, t](std::size_t tile, const WriteRows& write) {
        textures->writer.gather_rows(tile, reflectance_at(textures->transfer->history(), t).colors,
                                     transfer::color_codes, write, textures->silent);
      });
    }
  }
  return appearance;
}

/// All maps of a mesh at a time, cut into tiles; the last one is kept, so that tiles and kinds share it. Not
/// thread-safe.
class TiledMaps {
 public:
  TiledMaps(std::function<AgingMesh()> open, Sheet sheet) : open_(std::move(open)), sheet_(std::move(sheet)) {}

  [[nodiscard]] const SurfaceMaps& at(double time, const RunControl& control) {
    if (!mesh_) mesh_.emplace(open_());
    if (mesh_->is_reduced)
      throw InvalidInput("the transfer has more texels than are held at once; its relief cannot be exported");
    if (time_ != time) maps_ = mesh_->maps(time, control);
    time_ = time;
    return maps_;
  }
  [[nodiscard]] const Sheet& sheet() const { return sheet_; }

 private:
  std::function<AgingMesh()> open_;
  Sheet sheet_;
  std::optional<AgingMesh> mesh_;
  std::optional<double> time_;
  SurfaceMaps maps_;
};

void add_relief_of(const std::shared_ptr<TiledMaps>& maps, std::vector<GlbAppearance>& appearance,
                   const std::vector<double>& times, const RunControl& control) {
  const RunControl silent = control.silent();
  const Sheet& sheet = maps->sheet();
  const SurfaceMaps& first = maps->at(times.front(), silent);
  const bool has_height = !first.height.empty();
  const bool has_metalness = !first.metalness.empty() && appearance.front().metalness.empty();
  for (std::size_t i = 0; i < times.size(); ++i) {
    for (int tile = 0; tile < sheet.num_tiles(); ++tile) {
      if (has_height) {
        appearance[i].heights.push_back(
            [maps, silent, t = times[i], tile] { return cut_tile(maps->at(t, silent).height, maps->sheet(), tile); });
      }
      if (!has_metalness) continue;
      appearance[i].metalness.push_back(
          {sheet.tile_width, sheet.tile_height, 1, [maps, silent, t = times[i], tile](const WriteRows& write) {
             write(unit_codes(cut_tile(maps->at(t, silent).metalness, maps->sheet(), tile)).values());
           }});
    }
  }
}

/// Of a model whose size nobody has said. @param mesh  In mm.
std::string assumed_unit_text(double mm_per_unit, const Mesh& mesh) {
  return "the mesh file states no length unit, so 1 unit is taken as " + short_number_text(rounded(mm_per_unit, 2)) +
         " mm, as in the transfer: the model is " + short_number_text(rounded(bounding_box(mesh).diagonal(), 2)) +
         " mm from corner to corner; state the unit when you make the transfer";
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
  out.own_per_mm = 1.0 / m.mm_per_mesh_unit;
  if (!m.unit) out.notes.push_back(assumed_unit_text(m.mm_per_mesh_unit, out.mesh));
  out.appearance = [transfer](const auto& times, const auto& labels, const RunControl& control) {
    return appearances_of_transfer(transfer, times, labels, control);
  };
  const std::vector<MaterialMap> maps = material_maps(transfer->history().facts());
  if (std::find(maps.begin(), maps.end(), MaterialMap::Height) != maps.end()) {
    out.add_relief = [tiled = std::make_shared<TiledMaps>([path] { return open_aging_mesh(path); }, transfer->sheet())](
                         auto& appearance, const auto& times, const RunControl& control) {
      add_relief_of(tiled, appearance, times, control);
    };
  }
  return out;
}

/// A simulation's frames lie over the atlas already: one is in memory at a time.
AgingGlb glb_of_simulation(const std::filesystem::path& path, const OutputDevices& devices, bool has_flakes) {
  const auto mesh = std::make_shared<const AgingMesh>(open_aging_mesh(path, devices));
  const auto history = std::make_shared<const HistoryReader>(manifest_folder(path, "simulation.json") / "history");
  const std::vector<MaterialMap> maps = material_maps(history->facts());
  const auto has = [maps](MaterialMap map) { return std::find(maps.begin(), maps.end(), map) != maps.end(); };
  AgingGlb out{mesh->key, mesh->history, {mesh->tile_names, mesh->triangle_tile}, mesh->unit_mesh, {}, {}};
  if (out.mesh.surfaces.size() > 1) {
    for (const Mesh::Surface& surface : out.mesh.surfaces) out.objects.names.push_back(surface.node);
    out.objects.triangle_object = out.mesh.triangle_surface;
  }
  out.appearance = [mesh, history, has](const std::vector<double>& times, const std::vector<std::string>& labels,
                                        const RunControl& control) {
    const RunControl silent = control.silent();
    std::vector<GlbAppearance> appearance;
    for (std::size_t i = 0; i < times.size(); ++i) {
      const double t = times[i];
      const auto texture = [&](int channels, std::function<ImageU8()> make) {
        return GlbTexture{mesh->history.width, mesh->history.height, channels,
                          [make](const WriteRows& write) { write(make().values()); }};
      };
      const auto map_at = [history, t](MaterialMap map) {
        return sample_material_map(*history, map, t, Between::Blend);
      };
      GlbAppearance& look = appearance.emplace_back();
      look.name = labels[i];
      look.base_colors = {texture(3, [mesh, silent, t] { return srgb8_from_linear(mesh->sample(t, silent)); })};
      if (has(MaterialMap::Normal))
        look.normals = {texture(3, [map_at] { return normal_codes(map_at(MaterialMap::Normal)); })};
      if (has(MaterialMap::Roughness))
        look.speculars = {texture(1, [map_at] { return gloss_codes(map_at(MaterialMap::Roughness)); })};
      if (has(MaterialMap::Metalness))
        look.metalness = {texture(1, [map_at] { return unit_codes(map_at(MaterialMap::Metalness)); })};
      if (has(MaterialMap::Metalness)) {  // A simulation's frames have gloss always.
        look.gloss_and_metal = {texture(2, [map_at] {
          return gloss_and_metal_codes(
              roughness_and_metalness(map_at(MaterialMap::Roughness), map_at(MaterialMap::Metalness)));
        })};
      }
    }
    return appearance;
  };
  if (mesh->maps) {
    Sheet sheet;
    sheet.tile_width = mesh->history.width;
    sheet.tile_height = mesh->history.height;
    out.add_relief = [tiled = std::make_shared<TiledMaps>([mesh] { return *mesh; }, sheet), from = mesh->maps_from](
                         auto& appearance, const auto& times, const RunControl& control) {
      if (times.front() >= from) add_relief_of(tiled, appearance, times, control);
    };
  }
  const std::filesystem::path folder = manifest_folder(path, "simulation.json");
  if (has_flakes && may_have_flakes(folder / "history", mesh->history)) {
    out.add_flakes = [folder, mesh, devices](ModelParts& parts, const auto& times, const auto& labels, bool are_objects,
                                             const RunControl& control) {
      const FlakeGround ground{.mesh = std::shared_ptr<const Mesh>(mesh, &mesh->mesh), .relief = 0.0};
      const auto surface =
          std::make_shared<SimulatedSurface>(folder, std::nullopt, devices.compose(), ground, control.part(0.0, 0.3));
      add_flakes_to(parts, surface, times, labels, are_objects, control.part(0.3, 1.0));
    };
  }
  return out;
}

}  // namespace

AgingGlb open_aging_glb(const std::filesystem::path& path, const OutputDevices& devices, bool has_flakes) {
  return kind_of(path) == PathKind::Simulation ? glb_of_simulation(path, devices, has_flakes) : glb_of_transfer(path);
}

}  // namespace patinate::app
