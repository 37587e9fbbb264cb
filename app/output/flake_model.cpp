#include "app/output/flake_model.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "app/output/texture_codes.h"
#include "libcommon/geometry/mesh_append.h"
#include "patinate/image/color.h"

namespace patinate::app {

namespace {

/// Maps with flakes at a time; the last ones are kept, so that tiles and kinds share them. Not thread-safe.
class FlakeMaps {
 public:
  explicit FlakeMaps(std::shared_ptr<SimulatedSurface> surface) : surface_(std::move(surface)) {}

  const SurfaceMaps& at(double time, const RunControl& control) {
    if (time_ != time) maps_ = surface_->at(time, control);
    time_ = time;
    return maps_;
  }

 private:
  std::shared_ptr<SimulatedSurface> surface_;
  std::optional<double> time_;
  SurfaceMaps maps_;
};

/// The maps of the surface, of upper sides or of undersides.
enum class FlakePart { Below, Tops, Undersides };

const SurfaceMaps& maps_of(const SurfaceMaps& all, FlakePart part) {
  if (part == FlakePart::Below) return all;
  return all.pieces->maps[part == FlakePart::Tops ? 0 : 1];
}

/// The textures of one part at one time, of the kinds that an appearance has.
class PartTextures {
 public:
  /// @param silent  Of what is made while files are written.
  PartTextures(std::shared_ptr<FlakeMaps> maps, double time, FlakePart part, const RunControl& silent)
      : maps_(std::move(maps)), time_(time), part_(part), silent_(silent) {
    const SurfaceMaps& at = maps_->at(time, silent);
    width_ = at.color.width();
    height_ = at.color.height();
  }

  /// Puts them into the place of a tile.
  void put(GlbAppearance& look, std::size_t tile) const {
    look.base_colors[tile] = texture(3, [](const SurfaceMaps& m) { return srgb8_from_linear(m.color); });
    if (!look.normals.empty()) look.normals[tile] = texture(3, normals);
    if (!look.speculars.empty())
      look.speculars[tile] = texture(1, [](const SurfaceMaps& m) { return gloss_codes(m.roughness); });
    if (!look.metalness.empty())
      look.metalness[tile] = texture(1, [](const SurfaceMaps& m) { return unit_codes(metalness(m)); });
    if (!look.gloss_and_metal.empty()) {
      look.gloss_and_metal[tile] = texture(2, [](const SurfaceMaps& m) {
        return gloss_and_metal_codes(roughness_and_metalness(m.roughness, metalness(m)));
      });
    }
    if (look.heights.empty()) return;
    look.heights[tile] = [maps = maps_, time = time_, part = part_, silent = silent_, width = width_,
                          height = height_] {
      return part == FlakePart::Below ? maps->at(time, silent).height : ImageF(width, height);
    };
  }

 private:
  [[nodiscard]] GlbTexture texture(int channels, std::function<ImageU8(const SurfaceMaps& maps)> codes) const {
    return {width_, height_, channels,
            [maps = maps_, time = time_, part = part_, silent = silent_, codes = std::move(codes)](
                const WriteRows& write) { write(codes(maps_of(maps->at(time, silent), part)).values()); }};
  }
  static ImageF metalness(const SurfaceMaps& m) {
    return m.metalness.empty() ? ImageF(m.color.width(), m.color.height()) : m.metalness;
  }
  static ImageU8 normals(const SurfaceMaps& m) {
    if (!m.normals.empty()) return normal_codes(m.normals);
    ImageF flat(m.color.width(), m.color.height(), 3);
    for (std::int64_t i = 0; i < flat.num_pixels(); ++i) flat.data()[3 * i + 2] = 1.0F;
    return normal_codes(flat);
  }

  std::shared_ptr<FlakeMaps> maps_;
  double time_;
  FlakePart part_;
  RunControl silent_;
  int width_, height_;
};

/// Room for another tile in all textures that an appearance has.
void add_tile(GlbAppearance& look) {
  look.base_colors.emplace_back();
  for (std::vector<GlbTexture>* kind :
       {&look.normals, &look.speculars, &look.gloss_and_metal, &look.metalness, &look.reflectance_colors}) {
    if (!kind->empty()) kind->emplace_back();
  }
  if (!look.heights.empty()) look.heights.emplace_back();
}

/// The tiles of one time. @returns the first one's number.
int add_tiles(ModelParts& parts, std::size_t time, const std::string& label) {
  GlbTiles& tiles = parts.tiles;
  if (tiles.only_in.empty()) {
    tiles.names = {"surface"};
    tiles.only_in = {-1};
    tiles.triangle_tile.assign(parts.mesh.triangles.size(), 0);
  }
  for (const char* side : {"flakes", "undersides"}) {
    tiles.names.push_back(side + label);
    tiles.only_in.push_back(static_cast<int>(time));
    for (GlbAppearance& look : parts.appearance) add_tile(look);
  }
  return static_cast<int>(tiles.names.size()) - 2;
}

void add_triangles(ModelParts& parts, const SurfacePieces& pieces, int first_tile, const std::string& label,
                   bool are_objects) {
  GlbObjects& objects = parts.objects;
  if (are_objects) {
    if (objects.names.empty()) objects.names = {"mesh"};
    objects.triangle_object.resize(parts.mesh.triangles.size(), 0);
    objects.names.push_back("flakes" + label);
    objects.triangle_object.resize(parts.mesh.triangles.size() + pieces.mesh.triangles.size(),
                                   static_cast<int>(objects.names.size()) - 1);
  } else if (objects.names.size() > 1) {
    objects.triangle_object.insert(objects.triangle_object.end(), pieces.mesh.triangle_surface.begin(),
                                   pieces.mesh.triangle_surface.end());
  }
  append_mesh(parts.mesh, pieces.mesh);
  for (const std::uint8_t side : pieces.materials) parts.tiles.triangle_tile.push_back(first_tile + side);
}

}  // namespace

void add_flakes_to(ModelParts& parts, const std::shared_ptr<SimulatedSurface>& surface,
                   const std::vector<double>& times, const std::vector<std::string>& labels, bool are_objects,
                   const RunControl& control) {
  const auto maps = std::make_shared<FlakeMaps>(surface);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double share = 1.0 / static_cast<double>(times.size()), done = share * static_cast<double>(i);
    const SurfaceMaps& at = maps->at(times[i], control.part(done, done + share));
    if (!at.pieces || at.pieces->mesh.triangles.empty()) continue;
    const std::string label = times.size() > 1 ? " " + labels[i] : "";
    const int first = add_tiles(parts, i, label);
    const auto put = [&](FlakePart part, int tile) {
      PartTextures(maps, times[i], part, control.silent()).put(parts.appearance[i], static_cast<std::size_t>(tile));
    };
    put(FlakePart::Below, 0);
    put(FlakePart::Tops, first);
    put(FlakePart::Undersides, first + 1);
    add_triangles(parts, *at.pieces, first, label, are_objects);
  }
}

}  // namespace patinate::app
