#include "patinate/output/glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "libcommon/core/files.h"
#include "libcommon/core/json_text.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/regular_file.h"
#include "libcommon/output/glb_binary.h"
#include "libcommon/output/glb_document.h"
#include "libcommon/output/glb_tangents.h"
#include "libcommon/output/model_origin.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/color.h"

namespace patinate {

namespace {

constexpr int kMinRoughness = 13;  // of 255: mirrors of 8 bit flicker

// One vertex per different (position, uv, normal), and side of the UVs where there are tangents; indices by tile.
struct VertexBuffers {
  std::vector<float> positions, normals, uvs, tangents;
  std::vector<std::vector<std::uint32_t>> indices;
};

/// Buffers of the triangles of one object. @param origin  Of the positions. @param tangents  Null: vertices have none.
VertexBuffers make_buffers(const Mesh& mesh, const GlbTiles& tiles, const GlbObjects& objects, std::size_t object,
                           const Vec3& origin, double scale, const CornerTangents* tangents) {
  VertexBuffers buffers;
  const bool has_tangents = tangents != nullptr;
  buffers.indices.resize(tiles.names.size());
  std::map<std::array<int, 4>, std::uint32_t> index_of;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!objects.triangle_object.empty() && static_cast<std::size_t>(objects.triangle_object[t]) != object) continue;
    std::vector<std::uint32_t>& indices =
        buffers.indices[tiles.triangle_tile.empty() ? 0 : static_cast<std::size_t>(tiles.triangle_tile[t])];
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_mirrored = has_tangents && tangents->is_mirrored[t];
      const std::array<int, 4> corner = {mesh.triangles[t][k], mesh.uv_triangles[t][k], mesh.normal_triangles[t][k],
                                         is_mirrored ? 1 : 0};
      const auto [found, is_new] = index_of.try_emplace(corner, static_cast<std::uint32_t>(index_of.size()));
      indices.push_back(found->second);
      if (!is_new) continue;
      const Vec3 p = scale * (mesh.positions[corner[0]] - origin);
      const Vec2& uv = mesh.uvs[corner[1]];
      const Eigen::Vector3f n = mesh.normals[corner[2]].cast<float>().normalized();
      for (int i = 0; i < 3; ++i) buffers.positions.push_back(static_cast<float>(p[i]));
      for (int i = 0; i < 3; ++i) buffers.normals.push_back(n[i]);
      buffers.uvs.push_back(static_cast<float>(uv.x()));
      buffers.uvs.push_back(static_cast<float>(1.0 - uv.y()));
      if (!has_tangents) continue;
      const Eigen::Vector3f tangent = tangents->tangent[t][k].cast<float>().normalized();
      for (int i = 0; i < 3; ++i) buffers.tangents.push_back(tangent[i]);
      buffers.tangents.push_back(is_mirrored ? -1.0f : 1.0f);
    }
  }
  for (const std::vector<float>* values : {&buffers.positions, &buffers.normals, &buffers.uvs, &buffers.tangents}) {
    for (const float value : *values) {
      if (!std::isfinite(value)) throw InvalidInput("glb: the mesh has a value that is not finite");
    }
  }
  return buffers;
}

// glTF keeps roughness in green and metalness in blue. @param gloss  Perhaps with metalness as its second channel.
GlbTexture roughness_map(const GlbTexture& gloss, bool has_metal) {
  GlbTexture map = gloss;
  map.channels = 3;
  map.make = [&gloss, has_metal](const auto& write) {
    std::vector<std::uint8_t> rows;
    gloss.make([&](std::span<const std::uint8_t> values) {
      const auto channels = static_cast<std::size_t>(gloss.channels);
      rows.assign(3 * values.size() / channels, 0);
      for (std::size_t i = 0; 3 * i < rows.size(); ++i) {
        const int rough = 255 - values[i * channels];
        rows[3 * i + 1] = static_cast<std::uint8_t>(std::max(rough, kMinRoughness));
        if (has_metal) rows[3 * i + 2] = values[i * channels + 1];
      }
      write(rows);
    });
  };
  return map;
}

/// Texture of a whole image; `image` must outlive it.
GlbTexture whole(const ImageU8& image) {
  return {image.width(), image.height(), image.channels(), [&image](const auto& write) { write(image.values()); }};
}
GlbTexture whole(const ImageF& linear) {
  return {linear.width(), linear.height(), 3,
          [&linear](const auto& write) { write(srgb8_from_linear(linear).values()); }};
}

std::vector<GlbAppearance> appearances_of(const std::vector<GlbVariant>& variants) {
  std::vector<GlbAppearance> appearance;
  const auto all = [](const auto& images) {
    std::vector<GlbTexture> textures;
    for (const auto& image : images) textures.push_back(whole(image));
    return textures;
  };
  for (const GlbVariant& v : variants)
    appearance.push_back({v.name, all(v.base_colors), all(v.normals), all(v.speculars)});
  return appearance;
}

void check_glb(const Mesh& mesh, const GlbTiles& tiles, const std::vector<GlbAppearance>& variants,
               const GlbOptions& options) {
  if (!mesh.has_uvs()) throw InvalidInput("glb: the mesh has no UVs; unwrap it first");
  if (variants.empty()) throw InvalidInput("glb: there is no variant to write");
  const bool fits = tiles.names.size() == 1
                        ? tiles.triangle_tile.empty() || tiles.triangle_tile.size() == mesh.triangles.size()
                        : !tiles.names.empty() && tiles.triangle_tile.size() == mesh.triangles.size();
  const auto is_tile = [&](int tile) { return tile >= 0 && static_cast<std::size_t>(tile) < tiles.names.size(); };
  if (!fits || !std::all_of(tiles.triangle_tile.begin(), tiles.triangle_tile.end(), is_tile)) {
    throw InvalidInput("glb: every triangle needs a tile");
  }
  std::set<std::string> names;
  if (!tiles.only_in.empty() && tiles.only_in.size() != tiles.names.size())
    throw InvalidInput("glb: it is not known of every tile where it is seen");
  const auto is_empty = [](const GlbTexture& t) { return t.width <= 0 || t.height <= 0 || t.channels <= 0; };
  for (std::size_t number = 0; number < variants.size(); ++number) {
    const GlbAppearance& variant = variants[number];
    if (variant.base_colors.size() != tiles.names.size())
      throw InvalidInput("glb: `" + variant.name + "` needs one texture per tile");
    if (!(variant.reflectance >= 0.0 && variant.reflectance <= 0.99))
      throw InvalidInput("glb: the reflectance of `" + variant.name + "` must be in [0, 0.99]");
    for (const std::vector<GlbTexture>* maps :
         {&variant.normals, &variant.speculars, &variant.gloss_and_metal, &variant.reflectance_colors}) {
      if (!maps->empty() && maps->size() != tiles.names.size())
        throw InvalidInput("glb: `" + variant.name + "` needs a map per tile, or none");
      for (std::size_t tile = 0; tile < maps->size(); ++tile) {
        if (!tiles.is_seen(tile, number)) continue;
        const GlbTexture& map = (*maps)[tile];
        const int channels = maps == &variant.speculars ? map.channels : maps == &variant.gloss_and_metal ? 2 : 3;
        if (is_empty(map) || map.channels != channels)
          throw InvalidInput("glb: a map of `" + variant.name + "` is empty or has not " + std::to_string(channels) +
                             " channels");
      }
    }
    for (std::size_t tile = 0; tile < tiles.names.size(); ++tile) {
      if (tiles.is_seen(tile, number) && is_empty(variant.base_colors[tile]))
        throw InvalidInput("glb: the texture of `" + variant.name + "` is empty");
    }
    if (!names.insert(variant.name).second) throw InvalidInput("glb: the variant `" + variant.name + "` occurs twice");
  }
  const GlbObjects& objects = options.objects;
  const bool has_objects = objects.names.size() < 2 ? objects.triangle_object.empty()
                                                    : objects.triangle_object.size() == mesh.triangles.size();
  const auto is_object = [&](int object) {
    return object >= 0 && static_cast<std::size_t>(object) < objects.names.size();
  };
  if (!has_objects || !std::all_of(objects.triangle_object.begin(), objects.triangle_object.end(), is_object))
    throw InvalidInput("glb: every triangle needs an object");
  if (std::set<std::string>(objects.names.begin(), objects.names.end()).size() != objects.names.size())
    throw InvalidInput("glb: two objects have one name");
  if (!(options.meters_per_unit > 0.0)) throw InvalidInput("glb: meters_per_unit must be > 0");
  if (!(options.roughness >= 0.0 && options.roughness <= 1.0)) throw InvalidInput("glb: roughness must be in [0, 1]");
}

/// Names of nodes and meshes.
std::vector<std::string> object_names(const GlbOptions& options) {
  return options.objects.names.empty() ? std::vector<std::string>{options.name} : options.objects.names;
}

void use_extension(Json& gltf, const std::string& name) {
  Json& used = gltf["extensionsUsed"];
  if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
}

/// A tile that is seen in one variant alone has a name of its own.
std::string material_name(const GlbTiles& tiles, std::size_t tile, const std::string& variant) {
  if (!tiles.only_in.empty() && tiles.only_in[tile] >= 0) return tiles.names[tile];
  return tiles.names.size() == 1 ? variant : variant + " " + tiles.names[tile];
}

/// Of what a variant does not show: nothing of it passes the mask.
Json unseen_material() {
  return {{"name", "unseen"},
          {"alphaMode", "MASK"},
          {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 0}}, {"metallicFactor", 0}}}};
}

// Images, textures, materials (of the first variant: objects, and of each its tiles; of the second, ...) and the list
// of variants.
void add_materials(Json& gltf, GlbBinary& binary, const GlbTiles& tiles, const std::vector<GlbAppearance>& variants,
                   const GlbOptions& options, const RunControl& control) {
  gltf["samplers"] = {{{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 33071}, {"wrapT", 33071}}};
  const std::vector<std::string>& objects = options.objects.names;
  const std::size_t num_objects = std::max<std::size_t>(1, objects.size());
  const double num_materials = static_cast<double>(variants.size() * tiles.names.size());
  double num_done = 0.0;
  const auto add_texture = [&](const std::string& name, const GlbTexture& texture, bool is_color) {
    control.throw_if_stopped();
    const std::size_t index = gltf["textures"].size();
    gltf["images"].push_back(
        {{"name", name}, {"mimeType", "image/png"}, {"bufferView", binary.add_png(texture, is_color)}});
    gltf["textures"].push_back({{"sampler", 0}, {"source", index}});
    return index;
  };
  for (std::size_t number = 0; number < variants.size(); ++number) {
    const GlbAppearance& variant = variants[number];
    std::vector<Json> of_tiles;
    for (std::size_t tile = 0; tile < tiles.names.size(); ++tile) {
      if (!tiles.is_seen(tile, number)) {
        of_tiles.push_back(unseen_material());
        continue;
      }
      const std::string name = material_name(tiles, tile, variant.name);
      const std::size_t index = add_texture(name, variant.base_colors[tile], true);
      Json material = {
          {"name", name},
          {"doubleSided", true},
          {"pbrMetallicRoughness",
           {{"baseColorTexture", {{"index", index}}}, {"metallicFactor", 0}, {"roughnessFactor", options.roughness}}}};
      const bool has_metal = !variant.gloss_and_metal.empty();
      if (const auto& gloss = has_metal ? variant.gloss_and_metal : variant.speculars; !gloss.empty()) {
        Json& surface = material["pbrMetallicRoughness"];
        if (has_metal) surface["metallicFactor"] = 1;
        surface["roughnessFactor"] = 1;
        surface["metallicRoughnessTexture"] = {
            {"index", add_texture(name + " roughness", roughness_map(gloss[tile], has_metal), false)}};
      }
      if (!variant.normals.empty())
        material["normalTexture"] = {{"index", add_texture(name + " normals", variant.normals[tile], false)}};
      if (variant.has_reflectance()) {
        use_extension(gltf, "KHR_materials_ior");
        material["extensions"]["KHR_materials_ior"] = {{"ior", index_of_refraction(variant.reflectance)}};
      }
      if (!variant.reflectance_colors.empty()) {
        use_extension(gltf, "KHR_materials_specular");
        material["extensions"]["KHR_materials_specular"]["specularColorTexture"] = {
            {"index", add_texture(name + " reflectance", variant.reflectance_colors[tile], true)}};
      }
      of_tiles.push_back(std::move(material));
      control.report(0.9 * ++num_done / num_materials);
    }
    for (std::size_t object = 0; object < num_objects; ++object) {
      for (const Json& of_tile : of_tiles) {
        gltf["materials"].push_back(of_tile);
        if (num_objects > 1)
          gltf["materials"].back()["name"] = of_tile["name"].get<std::string>() + " " + objects[object];
      }
    }
    gltf["extensions"]["KHR_materials_variants"]["variants"].push_back({{"name", variant.name}});
  }
}

/// Numbers of the accessors of one object's vertices.
struct ObjectAccessors {
  int positions = 0, normals = 0, uvs = 0, tangents = -1;
  std::vector<int> indices;  ///< By tile; -1 = no triangle shows it.
};

ObjectAccessors add_accessors(Json& gltf, GlbBinary& binary, const VertexBuffers& buffers) {
  const auto add = [&](const std::vector<float>& values, std::size_t channels, const char* shape) {
    return add_gltf_accessor(gltf, binary.add(values, kGltfVertices), kGltfFloat, values.size() / channels, shape);
  };
  ObjectAccessors accessors;
  accessors.positions = add_gltf_positions(gltf, binary.add(buffers.positions, kGltfVertices), buffers.positions);
  accessors.normals = add(buffers.normals, 3, "VEC3");
  accessors.uvs = add(buffers.uvs, 2, "VEC2");
  if (!buffers.tangents.empty()) accessors.tangents = add(buffers.tangents, 4, "VEC4");
  for (const std::vector<std::uint32_t>& indices : buffers.indices) {
    accessors.indices.push_back(indices.empty() ? -1
                                                : add_gltf_accessor(gltf, binary.add(indices, kGltfIndices),
                                                                    kGltfUint32, indices.size(), "SCALAR"));
  }
  return accessors;
}

// A primitive per tile that has triangles.
// @param first_material  Of the object in the first variant. @param num_materials  Of a variant.
Json make_primitives(const ObjectAccessors& accessors, std::size_t num_variants, std::size_t first_material,
                     std::size_t num_materials) {
  Json primitives = Json::array();
  for (std::size_t tile = 0; tile < accessors.indices.size(); ++tile) {
    if (accessors.indices[tile] < 0) continue;
    Json primitive = {
        {"attributes",
         {{"POSITION", accessors.positions}, {"NORMAL", accessors.normals}, {"TEXCOORD_0", accessors.uvs}}},
        {"indices", accessors.indices[tile]},
        {"material", first_material + tile}};
    if (accessors.tangents >= 0) primitive["attributes"]["TANGENT"] = accessors.tangents;
    Json& mappings = primitive["extensions"]["KHR_materials_variants"]["mappings"];
    for (std::size_t i = 0; i < num_variants; ++i)
      mappings.push_back({{"material", i * num_materials + first_material + tile}, {"variants", Json::array({i})}});
    primitives.push_back(std::move(primitive));
  }
  return primitives;
}

void write_file(const std::filesystem::path& path, Json& gltf, GlbBinary& binary) {
  const std::string head = glb_head(gltf, binary.views(), binary.size(), path.string());
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out << head;
    binary.copy_to(out);
    if (!out.flush()) throw CannotComplete(path.string() + ": cannot be written; is the disk full?");
  });
}

std::uint32_t u32_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[offset + i])) << (8 * i);
  return value;
}

}  // namespace

double index_of_refraction(double reflectance) {
  const double root = std::sqrt(reflectance);
  return (1.0 + root) / (1.0 - root);
}

void write_glb(const std::filesystem::path& path, const Mesh& mesh, const std::vector<GlbVariant>& variants,
               const GlbOptions& options, const RunControl& control) {
  write_glb(path, mesh, GlbTiles{}, variants, options, control);
}

void write_glb(const std::filesystem::path& path, const Mesh& mesh, const GlbTiles& tiles,
               const std::vector<GlbVariant>& variants, const GlbOptions& options, const RunControl& control) {
  write_glb(path, mesh, tiles, appearances_of(variants), options, control);
}

void write_glb(const std::filesystem::path& path, const Mesh& mesh, const GlbTiles& tiles,
               const std::vector<GlbAppearance>& appearance, const GlbOptions& options, const RunControl& control) {
  check_glb(mesh, tiles, appearance, options);
  const Mesh shaded = with_normals(mesh);
  const bool has_tangents = std::any_of(appearance.begin(), appearance.end(),
                                        [](const GlbAppearance& look) { return !look.normals.empty(); });
  const CornerTangents tangents = has_tangents ? corner_tangents(shaded) : CornerTangents{};
  const std::vector<std::string> names = object_names(options);
  const Vec3 origin = model_origin(mesh);

  Json gltf;
  gltf["asset"] = gltf_asset();
  std::string credits;
  for (const std::string& credit : options.credits) credits += (credits.empty() ? "" : "; ") + credit;
  if (!credits.empty()) gltf["asset"]["copyright"] = credits;
  if (!options.key.empty()) gltf["asset"]["extras"] = {{"patinate_key", options.key}};
  gltf["extensionsUsed"] = {"KHR_materials_variants"};
  gltf["scene"] = 0;
  gltf["scenes"] = Json::array({{{"nodes", Json::array()}}});

  GlbBinary binary(path);
  std::vector<ObjectAccessors> accessors;
  std::vector<std::string> shown;
  std::vector<std::size_t> numbers;
  for (std::size_t object = 0; object < names.size(); ++object) {
    const VertexBuffers buffers = make_buffers(shaded, tiles, options.objects, object, origin, options.meters_per_unit,
                                               has_tangents ? &tangents : nullptr);
    if (buffers.positions.empty()) continue;  // glTF has no empty mesh.
    const std::size_t node = shown.size();
    gltf["scenes"][0]["nodes"].push_back(node);
    gltf["nodes"].push_back({{"name", names[object]}, {"mesh", node}});
    move_gltf_node(gltf["nodes"].back(), options.meters_per_unit * origin);
    shown.push_back(names[object]);
    numbers.push_back(object);
    accessors.push_back(add_accessors(gltf, binary, buffers));
  }
  gltf["textures"] = Json::array();
  add_materials(gltf, binary, tiles, appearance, options, control);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    gltf["meshes"].push_back(
        {{"name", shown[i]},
         {"primitives", make_primitives(accessors[i], appearance.size(), numbers[i] * tiles.names.size(),
                                        names.size() * tiles.names.size())}});
  }
  write_file(path, gltf, binary);
  control.report(1.0);
}

std::string read_glb_key(const std::filesystem::path& path) {
  check_may_read(path);
  require_regular_file(path);
  std::ifstream file(path, std::ios::binary);
  std::string head(20, '\0');
  std::error_code error;
  if (!file) throw IoError(path.string(), "cannot be read");
  if (!file.read(head.data(), 20) || u32_at(head, 0) != kGlbMagic || u32_at(head, 16) != kGlbJsonChunk) return "";
  const std::uint64_t length = u32_at(head, 12), size = std::filesystem::file_size(path, error);
  if (error || length > size - head.size()) return "";
  std::string text(static_cast<std::size_t>(length), '\0');  // Textures are behind it, and many.
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size()))) return "";
  Json gltf;
  try {
    gltf = parse_json(path.string(), text);
  } catch (const IoError&) {
    return "";  // Another's, then.
  }
  const Json::json_pointer pointer("/asset/extras/patinate_key");
  if (!gltf.is_object() || !gltf.contains(pointer) || !gltf.at(pointer).is_string()) return "";
  return gltf.at(pointer).get<std::string>();
}

}  // namespace patinate
