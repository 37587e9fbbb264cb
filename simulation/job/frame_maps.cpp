#include "simulation/job/frame_maps.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"
#include "libcommon/history/frame_locator.h"
#include "patinate/atlas/dilate.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/image_io.h"
#include "patinate/simulation/layer_atlas.h"

namespace patinate::simulation {

namespace fs = std::filesystem;

namespace {

constexpr const char* kWater = "water";
constexpr float kMinRoughness = 0.05f;  ///< See docs/algorithms/composition.md, In a GLB.

int material_named(const Scene& scene, const char* name) {
  const auto found = std::find(scene.materials.begin(), scene.materials.end(), name);
  return found == scene.materials.end() ? -1 : static_cast<int>(found - scene.materials.begin());
}

bool has_relief(const Scene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(),
                     [](const SceneObject& object) { return !object.height_map.empty(); }) ||
         std::any_of(scene.appearance.begin(), scene.appearance.end(),
                     [](const MaterialAppearance& a) { return a.height_mm != 0.0; }) ||
         has_layers(scene);
}

/// Channels of a frame's amounts.
std::vector<std::string> amount_channels(const Simulation& simulation) {
  std::vector<std::string> channels = simulation.scene().materials;
  for (std::string& name : simulation.layer_map_names()) channels.push_back(std::move(name));
  return channels;
}

/// Strength and roughness.
ImageF gloss_of(const ImageU8& specular) {
  ImageF out(specular.width(), specular.height(), 2);
  for (std::int64_t i = 0; i < specular.num_pixels(); ++i) {
    out.data()[2 * i] = kUnknownSpecular;
    out.data()[2 * i + 1] = std::max(kMinRoughness, 1.0f - static_cast<float>(specular.data()[i]) / 255.0f);
  }
  return out;
}

ImageF unit_normals(const ImageU8& codes) {
  ImageF out(codes.width(), codes.height(), 3);
  for (std::int64_t i = 0; i < codes.num_pixels(); ++i) {
    Eigen::Vector3f n;
    // 128 is flat, so that 127.5 + 127.5 n has no code for 0.
    for (int c = 0; c < 3; ++c) {
      const std::uint8_t code = codes.data()[3 * i + c];
      n[c] = c < 2 && code == 128 ? 0.0f : (static_cast<float>(code) - 127.5f) / 127.5f;
    }
    n.normalize();
    std::copy_n(n.data(), 3, out.data() + 3 * i);
  }
  return out;
}

}  // namespace

std::vector<std::string> frame_map_names(const Scene& scene) {
  std::vector<std::string> names{"specular"};
  if (has_relief(scene)) names.insert(names.end(), {"normal", "height"});
  if (TexelMetal::is_in(scene)) names.emplace_back("metalness");
  return names;
}

int film_material(const Scene& scene) { return material_named(scene, kWater); }

int plant_material(const Scene& scene) {
  const int moss = material_named(scene, "moss");
  return moss >= 0 ? moss : material_named(scene, "organic");
}

std::vector<MaterialAppearance> looks_below_film(const Scene& scene, std::vector<MaterialAppearance> looks) {
  if (const int water = film_material(scene); water >= 0) {
    MaterialAppearance& look = looks[static_cast<std::size_t>(water)];
    look.strength = look.specular = look.height_mm = 0.0;
  }
  return looks;
}

bool TexelMetal::is_in(const Scene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(), [](const SceneObject& object) {
    return object.preset.metalness > 0.0 || std::any_of(object.layers.begin(), object.layers.end(),
                                                        [](const Layer& l) { return l.look.metalness > 0.0; });
  });
}

float TexelMetal::at(TexelIndex texel) const {
  const Scene& scene = simulation_.scene();
  const MaterialAtlas& atlas = simulation_.atlas();
  const int object = atlas.surface().object(atlas.surface().triangle(texel));
  const LayerAtlas* layers = simulation_.layers();
  const bool has_layers = layers != nullptr && layers->num_layers(object) > 0;
  const auto metal = static_cast<float>(has_layers ? layers->metalness(object, layers->tops()[texel])
                                                   : scene.objects[static_cast<std::size_t>(object)].preset.metalness);
  float cover = 0.0f;
  for (int m = 0; m < static_cast<int>(scene.materials.size()); ++m) {
    const std::string& material = scene.materials[m];
    if (material == kWater || material == "metal") continue;
    const auto now = static_cast<float>(static_cast<double>(atlas.amount(m, texel)) / kAmountOne),
               before = static_cast<float>(static_cast<double>(atlas.original(m, texel)) / kAmountOne);
    cover += static_cast<float>(scene.appearance[m].strength) * std::max(0.0f, now - before);
  }
  return metal * std::max(0.0f, 1.0f - cover);
}

ImageF metalness_of(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  if (!TexelMetal::is_in(scene)) return {};
  ImageF metal(scene.resolution, scene.resolution);
  const TexelMetal texels(simulation);
  const SurfaceAtlas& surface = simulation.atlas().surface();
  const std::vector<ObjectSquare> squares = simulation.object_squares();
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const ObjectSquare& square = squares[i];
    for (int y = square.y; y < square.y + square.side; ++y) {
      for (int x = square.x; x < square.x + square.side; ++x) {
        const TexelIndex t = surface.grid().index(x, y);
        metal.at(x, y) = surface.is_covered(t) ? texels.at(t) : static_cast<float>(scene.objects[i].preset.metalness);
      }
    }
  }
  return metal;
}

ImageF dilated_metalness(Simulation& simulation) {
  ImageF metal = metalness_of(simulation);
  if (metal.empty()) return metal;
  dilate(metal, simulation.coverage(), -1);
  return metal;
}

std::vector<fs::path> frame_map_files(const Scene& scene, int index) {
  std::vector<fs::path> files;
  for (const std::string& name : frame_map_names(scene)) files.push_back(HistoryWriter::frame_extra_file(index, name));
  files.push_back(HistoryWriter::frame_amounts_file(index));
  return files;
}

void write_frame_maps(const fs::path& history, int index, Simulation& simulation, const RunControl& control) {
  const Composer& look = simulation.compose(control);
  for (const std::string& name : frame_map_names(simulation.scene())) {
    HistoryWriter::write_frame_extra(history, index, name,
                                     name == "specular"    ? gloss_of(look.specular8())
                                     : name == "normal"    ? unit_normals(look.normal8())
                                     : name == "metalness" ? dilated_metalness(simulation)
                                                           : look.height_mm());
  }
  const std::vector<std::string> channels = amount_channels(simulation);
  const auto num_materials = static_cast<int>(simulation.scene().materials.size()),
             num_channels = static_cast<int>(channels.size());
  const int side = simulation.scene().resolution;
  ImageF amounts(side, side, num_channels);
  for (int c = 0; c < num_channels; ++c) {
    const ImageF one =
        c < num_materials ? simulation.amounts(c) : simulation.layer_map(static_cast<std::size_t>(c - num_materials));
    for (std::int64_t i = 0; i < one.num_pixels(); ++i) amounts.data()[i * num_channels + c] = one.data()[i];
  }
  HistoryWriter::write_frame_amounts(history, index, channels, amounts);
}

namespace {

ImageF amounts_of(const fs::path& file, const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  ImageF image = read_channels(file, amount_channels(simulation));
  if (image.width() != scene.resolution || image.height() != scene.resolution) {
    throw IoError(file.string(), "is " + size_text(image.width(), image.height()) + " texels; the scene's atlas has " +
                                     size_text(scene.resolution, scene.resolution));
  }
  return image;
}

void set_all_amounts(const ImageF& image, Simulation& simulation) {
  const int n = image.channels(), num_materials = static_cast<int>(simulation.scene().materials.size());
  for (int c = 0; c < n; ++c) {
    ImageF one(image.width(), image.height());
    for (std::int64_t i = 0; i < one.num_pixels(); ++i) one.data()[i] = image.data()[i * n + c];
    if (c < num_materials) {
      simulation.set_amounts(c, one);
    } else {
      simulation.set_layer_map(static_cast<std::size_t>(c - num_materials), one);
    }
  }
}

}  // namespace

void read_frame_amounts(const fs::path& file, Simulation& simulation) {
  set_all_amounts(amounts_of(file, simulation), simulation);
}

void read_frame_amounts(const fs::path& history, const HistoryManifest& frames, double time, Simulation& simulation) {
  std::vector<double> times;
  for (const HistoryFrame& frame : frames.frames) times.push_back(frame.time);
  const TimePosition at = FrameLocator(std::move(times), Between::Blend)(time);
  const auto amounts_at = [&](int index) { return amounts_of(history / *frames.frames[index].amounts, simulation); };
  ImageF amounts = amounts_at(at.index);
  if (at.fraction > 0.0) {
    const ImageF next = amounts_at(at.index + 1);
    const auto share = static_cast<float>(at.fraction);
    std::transform(amounts.values().begin(), amounts.values().end(), next.values().begin(), amounts.values().begin(),
                   [share](float a, float b) { return (1.0f - share) * a + share * b; });
  }
  set_all_amounts(amounts, simulation);
}

}  // namespace patinate::simulation
