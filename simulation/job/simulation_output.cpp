#include "simulation/job/simulation_output.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/image/image_rows.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "patinate/output/glb.h"
#include "simulation/job/frame_maps.h"

namespace patinate::simulation {

namespace fs = std::filesystem;

namespace {

constexpr double kHighShare = 0.995;  ///< Rank of the value that 1 stands for (docs/simulation.md).
constexpr const char* kStateFile = "state.bin";

std::vector<std::string> atlas_channels(const Simulation& simulation) {
  std::vector<std::string> channels;
  for (const std::string& name : simulation.scene().materials) channels.push_back("amount." + name);
  for (const std::string& name : simulation.scene().materials) channels.push_back("original." + name);
  return channels;
}

/// Specular value and metalness of every texel, as codes.
GlbTexture gloss_and_metal(const ImageU8& specular, const ImageF& metal) {
  std::vector<std::uint8_t> codes;
  codes.reserve(specular.values().size() * 2);
  for (std::size_t i = 0; i < specular.values().size(); ++i) {
    codes.push_back(specular.values()[i]);
    codes.push_back(static_cast<std::uint8_t>(255.0f * std::clamp(metal.values()[i], 0.0f, 1.0f) + 0.5f));
  }
  return {specular.width(), specular.height(), 2, [codes = std::move(codes)](const auto& write) { write(codes); }};
}

GlbTexture glb_texture(ImageU8 codes) {
  const int width = codes.width(), height = codes.height(), channels = codes.channels();
  return {width, height, channels, [codes = std::move(codes)](const auto& write) { write(codes.values()); }};
}

/// The value below which a share of the covered texels that are not 0 lie.
double high_value(const ImageF& values, const ImageU8& coverage) {
  std::vector<float> covered;
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) {
    if (coverage.data()[i] != 0 && values.data()[i] > 0.0f) covered.push_back(values.data()[i]);
  }
  if (covered.empty()) return 1.0;
  return static_cast<double>(
      value_at_rank(covered, static_cast<std::size_t>(kHighShare * static_cast<double>(covered.size() - 1))));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> scene_file_keys(const fs::path& folder, const SceneCopy& copy) {
  std::vector<std::pair<std::string, std::string>> keys{
      {copy.name.generic_string(), hash_file(folder / kSceneFolder / copy.name)}};
  for (const SceneCopy::File& file : copy.files) keys.emplace_back(file.to.generic_string(), file.key);
  return keys;
}

void write_composed_files(const fs::path& folder, const std::string& name, Simulation& simulation,
                          const std::string& key, const RunControl& control) {
  const Composer& look = simulation.compose(control.part(0.0, 0.4));
  write_codes(folder / "color.png", look.color_srgb8());
  write_codes(folder / "specular.png", look.specular8());
  write_codes(folder / "normal.png", look.normal8());
  const ImageF height = look.height_mm();
  ImageRowWriter heights(folder / "height.exr", height.width(), height.height(),
                         {.channels = {"Y"}, .depth = ExrDepth::Float, .unit = "mm"});
  heights.write(height.values());
  heights.finish();
  control.report(0.7);
  GlbVariant variant{.name = "aged", .base_colors = {look.color_linear()}};
  variant.normals = {look.normal8()};
  variant.speculars = {look.specular8()};
  GlbOptions options{.name = name, .meters_per_unit = 0.001, .roughness = 0.8, .key = key};
  const std::vector<SceneObject>& objects = simulation.scene().objects;
  if (objects.size() > 1) {
    for (const SceneObject& object : objects) options.objects.names.push_back(object.name);
    const SurfaceAtlas& surface = simulation.atlas().surface();
    for (int t = 0; t < surface.num_triangles(); ++t) options.objects.triangle_object.push_back(surface.object(t));
  }
  const ImageF metal = dilated_metalness(simulation);
  if (metal.empty())
    return write_glb(folder / "model.glb", simulation.mesh(), {variant}, options, control.part(0.7, 1.0));
  GlbAppearance appearance{.name = variant.name, .base_colors = {glb_texture(look.color_srgb8())}};
  appearance.normals = {glb_texture(look.normal8())};
  appearance.gloss_and_metal = {gloss_and_metal(look.specular8(), metal)};
  write_glb(folder / "model.glb", simulation.mesh(), GlbTiles{}, std::vector{std::move(appearance)}, options,
            control.part(0.7, 1.0));
}

void write_atlas_file(const fs::path& folder, const Simulation& simulation) {
  const int n = static_cast<int>(simulation.scene().materials.size());
  const int side = simulation.scene().resolution;
  const std::vector<std::string> layer_channels = simulation.layer_map_names();
  const int num_channels = 2 * n + 1 + static_cast<int>(layer_channels.size());
  ImageF image(side, side, num_channels);
  for (int m = 0; m < n; ++m) {
    const ImageF amount = simulation.amounts(m);
    const ImageF original = simulation.original_amounts(m);
    for (std::int64_t i = 0; i < amount.num_pixels(); ++i) {
      image.data()[i * num_channels + m] = amount.data()[i];
      image.data()[i * num_channels + n + m] = original.data()[i];
    }
  }
  const SurfaceAtlas& surface = simulation.atlas().surface();
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const TexelIndex t = surface.grid().index(x, y);
      image.at(x, y, 2 * n) = surface.is_covered(t) ? static_cast<float>(surface.weight(t)) : 0.0f;
    }
  }
  for (std::size_t k = 0; k < layer_channels.size(); ++k) {
    const ImageF values = simulation.layer_map(k);
    const int channel = 2 * n + 1 + static_cast<int>(k);
    for (std::int64_t i = 0; i < values.num_pixels(); ++i) image.data()[i * num_channels + channel] = values.data()[i];
  }
  std::vector<std::string> channels = atlas_channels(simulation);
  channels.emplace_back("weight");
  channels.insert(channels.end(), layer_channels.begin(), layer_channels.end());
  write_exr(folder / "atlas.exr", image, channels, ExrDepth::Float);
}

ImageF first_color(const fs::path& folder) {
  ImageF color = read_color(folder / "history" / HistoryWriter::frame_file(0));
  for (float& v : color.values()) v = linear_from_srgb(static_cast<float>(srgb8_from_linear(v)) / 255.0f);
  return color;
}

void read_atlas_file(const fs::path& folder, Simulation& simulation) {
  const fs::path file = folder / "atlas.exr";
  std::vector<std::string> channels = atlas_channels(simulation);
  const std::size_t num_amounts = channels.size();
  for (std::string& name : simulation.layer_map_names()) channels.push_back(std::move(name));
  const ImageF image = read_channels(file, channels);
  const int side = simulation.scene().resolution;
  if (image.width() != side || image.height() != side) {
    throw IoError(file.string(), "is " + size_text(image.width(), image.height()) + " texels; the scene's atlas has " +
                                     size_text(side, side));
  }
  const int n = static_cast<int>(simulation.scene().materials.size());
  const auto channel_at = [&](std::size_t channel) {
    ImageF one(side, side, 1);
    const auto step = static_cast<std::int64_t>(channels.size());
    for (std::int64_t i = 0; i < one.num_pixels(); ++i)
      one.data()[i] = image.data()[i * step + static_cast<std::int64_t>(channel)];
    return one;
  };
  for (int m = 0; m < n; ++m) simulation.set_amounts(m, channel_at(static_cast<std::size_t>(m)));
  for (std::size_t k = num_amounts; k < channels.size(); ++k) simulation.set_layer_map(k - num_amounts, channel_at(k));
}

void write_state_file(const fs::path& folder, const Simulation& simulation) {
  const std::vector<std::byte> bytes = simulation.snapshot();
  write_atomically(folder / kStateFile, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

bool read_state_file(const fs::path& folder, Simulation& simulation) {
  const fs::path file = folder / kStateFile;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return false;
  const std::string bytes = read_file(file, std::uint64_t{1} << 36);
  try {
    simulation.restore(std::as_bytes(std::span(bytes)));
  } catch (const InvalidInput& e) {
    throw IoError(file.string(), e.what());
  }
  return true;
}

ParameterControl parameter_control(const Simulation& simulation, const std::string& name, TimeUnit time_unit) {
  ParameterMap map = simulation.parameter_map(name);
  ParameterControl control{.name = name, .values = std::move(map.values), .low = 0.0, .high = 1.0, .unit = map.unit};
  if (map.unit == "time") control.unit = time_unit_text(time_unit);
  control.high = high_value(control.values, simulation.coverage());
  for (float& v : control.values.values())
    v = std::clamp(static_cast<float>(static_cast<double>(v) / control.high), 0.0f, 1.0f);
  return control;
}

std::vector<std::pair<std::string, fs::path>> write_object_controls(const fs::path& folder,
                                                                    const Simulation& simulation,
                                                                    const ParameterControl& control) {
  const std::vector<ObjectSquare> squares = simulation.object_squares();
  std::vector<std::pair<std::string, fs::path>> files;
  for (std::size_t i = 0; squares.size() > 1 && i < squares.size(); ++i) {
    const ObjectSquare& square = squares[i];
    if (!simulation.scene().objects[i].has_file_uvs) continue;
    const std::string name = is_file_name(square.name) ? square.name : "object-" + std::to_string(i);
    files.emplace_back(square.name, fs::path("controls") / name / (control.name + ".exr"));
    fs::create_directories((folder / files.back().second).parent_path());
    write_scaled_exr(folder / files.back().second, crop(control.values, square.x, square.y, square.side, square.side),
                     {control.low, control.high, control.unit});
  }
  return files;
}

}  // namespace patinate::simulation
