#include "libcommon/output/glb.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "libcommon/core/error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/json.h"
#include "libcommon/image/color.h"
#include "libcommon/output/glb_tangents.h"

namespace patinate {

namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUint32 = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;
constexpr int kLeastRoughness = 13;  // of 255: mirrors of 8 bit flicker

// One vertex per different (position, uv, normal), and side of the UVs where there are tangents; indices by tile.
struct VertexBuffers {
  std::vector<float> positions, normals, uvs, tangents;
  std::vector<std::vector<std::uint32_t>> indices;
};

VertexBuffers make_buffers(const Mesh& mesh, const GlbTiles& tiles, double scale, bool has_tangents) {
  VertexBuffers buffers;
  const CornerTangents tangents = has_tangents ? corner_tangents(mesh) : CornerTangents{};
  buffers.indices.resize(tiles.names.size());
  std::map<std::array<int, 4>, std::uint32_t> index_of;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::vector<std::uint32_t>& indices = buffers.indices[tiles.triangle_tile.empty() ? 0 : static_cast<std::size_t>(tiles.triangle_tile[t])];
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_mirrored = has_tangents && tangents.is_mirrored[t];
      const std::array<int, 4> corner = {mesh.triangles[t][k], mesh.uv_triangles[t][k], mesh.normal_triangles[t][k], is_mirrored ? 1 : 0};
      const auto [found, is_new] = index_of.try_emplace(corner, static_cast<std::uint32_t>(index_of.size()));
      indices.push_back(found->second);
      if (!is_new) continue;
      const Vec3 p = scale * mesh.positions[static_cast<std::size_t>(corner[0])];
      const Vec2& uv = mesh.uvs[static_cast<std::size_t>(corner[1])];
      const Eigen::Vector3f n = mesh.normals[static_cast<std::size_t>(corner[2])].cast<float>().normalized();
      for (int i = 0; i < 3; ++i) buffers.positions.push_back(static_cast<float>(p[i]));
      for (int i = 0; i < 3; ++i) buffers.normals.push_back(n[i]);
      buffers.uvs.push_back(static_cast<float>(uv.x()));
      buffers.uvs.push_back(static_cast<float>(1.0 - uv.y()));
      if (!has_tangents) continue;
      const Eigen::Vector3f tangent = tangents.tangent[t][k].cast<float>().normalized();
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

std::string png_bytes(const ImageU8& codes, bool is_color) {
  OIIO::Filesystem::IOVecOutput bytes;
  const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create("picture.png", &bytes);
  OIIO::ImageSpec spec(codes.width(), codes.height(), codes.channels(), OIIO::TypeDesc::UINT8);
  if (is_color) spec.attribute("oiio:ColorSpace", "sRGB");
  if (!out || !out->open("picture.png", spec) || !out->write_image(OIIO::TypeDesc::UINT8, codes.data()) ||
      !out->close()) {
    throw CannotComplete("glb: a texture could not be encoded as PNG" + (out ? ": " + out->geterror() : std::string()));
  }
  const auto& buffer = bytes.buffer();
  return {buffer.begin(), buffer.end()};
}

// glTF keeps roughness in green and metalness in blue.
ImageU8 roughness_map(const ImageU8& specular) {
  ImageU8 map(specular.width(), specular.height(), 3);
  for (std::int64_t i = 0; i < specular.num_pixels(); ++i) {
    const int rough = 255 - specular.data()[i * specular.channels()];
    map.data()[3 * i + 1] = static_cast<std::uint8_t>(std::max(rough, kLeastRoughness));
  }
  return map;
}

// The binary chunk and the views into it.
class BinaryChunk {
 public:
  int add(const void* data, std::size_t size, int target = 0) {
    bytes_.resize((bytes_.size() + 3) / 4 * 4, '\0');
    Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    bytes_.append(static_cast<const char*>(data), size);
    views_.push_back(std::move(view));
    return static_cast<int>(views_.size()) - 1;
  }
  template <class T>
  int add(const std::vector<T>& values, int target) {
    return add(values.data(), values.size() * sizeof(T), target);
  }
  [[nodiscard]] const Json& views() const { return views_; }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  Json views_ = Json::array();
};

Json accessor(int view, int type, std::size_t count, const char* shape) {
  return {{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", shape}};
}

Json position_accessor(int view, const std::vector<float>& positions) {
  Json json = accessor(view, kFloat, positions.size() / 3, "VEC3");
  std::array<float, 3> low = {positions[0], positions[1], positions[2]}, high = low;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
  }
  json["min"] = low;
  json["max"] = high;
  return json;
}

void check(const Mesh& mesh, const GlbTiles& tiles, const std::vector<GlbVariant>& variants, const GlbOptions& options) {
  if (!mesh.has_uvs()) throw InvalidInput("glb: the mesh has no UVs; unwrap it first");
  if (variants.empty()) throw InvalidInput("glb: there is no variant to write");
  const bool fits = tiles.names.size() == 1 ? tiles.triangle_tile.empty() || tiles.triangle_tile.size() == mesh.triangles.size()
                                            : !tiles.names.empty() && tiles.triangle_tile.size() == mesh.triangles.size();
  const auto is_tile = [&](int tile) { return tile >= 0 && static_cast<std::size_t>(tile) < tiles.names.size(); };
  if (!fits || !std::all_of(tiles.triangle_tile.begin(), tiles.triangle_tile.end(), is_tile)) {
    throw InvalidInput("glb: every triangle needs a tile");
  }
  std::set<std::string> names;
  for (const GlbVariant& variant : variants) {
    if (variant.base_colors.size() != tiles.names.size()) throw InvalidInput("glb: `" + variant.name + "` needs one texture per tile");
    for (const std::vector<ImageU8>* maps : {&variant.normals, &variant.speculars}) {
      if (!maps->empty() && maps->size() != tiles.names.size()) throw InvalidInput("glb: `" + variant.name + "` needs a map per tile, or none");
      for (const ImageU8& map : *maps) {
        if (map.empty() || (maps == &variant.normals && map.channels() != 3)) throw InvalidInput("glb: a map of `" + variant.name + "` is empty or has not 3 channels");
      }
    }
    for (const ImageF& texture : variant.base_colors) {
      if (texture.empty()) throw InvalidInput("glb: the texture of `" + variant.name + "` is empty");
    }
    if (!names.insert(variant.name).second) throw InvalidInput("glb: the variant `" + variant.name + "` occurs twice");
  }
  if (!(options.metres_per_unit > 0.0)) throw InvalidInput("glb: metres_per_unit must be > 0");
  if (!(options.roughness >= 0.0 && options.roughness <= 1.0)) throw InvalidInput("glb: roughness must be in [0, 1]");
}

// Images, textures, materials (tiles of the first variant, of the second, ...) and the list of variants.
void add_materials(Json& gltf, BinaryChunk& binary, const GlbTiles& tiles, const std::vector<GlbVariant>& variants,
                   const GlbOptions& options, const RunControl& control) {
  gltf["samplers"] = {{{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 33071}, {"wrapT", 33071}}};
  const double num_materials = static_cast<double>(variants.size() * tiles.names.size());
  const auto add_texture = [&](const std::string& name, const ImageU8& codes, bool is_color) {
    control.throw_if_stopped();
    const std::string png = png_bytes(codes, is_color);
    const std::size_t index = gltf["textures"].size();
    gltf["images"].push_back({{"name", name}, {"mimeType", "image/png"}, {"bufferView", binary.add(png.data(), png.size())}});
    gltf["textures"].push_back({{"sampler", 0}, {"source", index}});
    return index;
  };
  for (const GlbVariant& variant : variants) {
    for (std::size_t tile = 0; tile < tiles.names.size(); ++tile) {
      const std::string name = tiles.names.size() == 1 ? variant.name : variant.name + " " + tiles.names[tile];
      const std::size_t index = add_texture(name, srgb8_from_linear(variant.base_colors[tile]), true);
      Json material = {{"name", name},
                       {"doubleSided", true},
                       {"pbrMetallicRoughness",
                        {{"baseColorTexture", {{"index", index}}}, {"metallicFactor", 0}, {"roughnessFactor", options.roughness}}}};
      if (!variant.speculars.empty()) {
        Json& surface = material["pbrMetallicRoughness"];
        surface["roughnessFactor"] = 1;
        surface["metallicRoughnessTexture"] = {{"index", add_texture(name + " roughness", roughness_map(variant.speculars[tile]), false)}};
      }
      if (!variant.normals.empty()) material["normalTexture"] = {{"index", add_texture(name + " normals", variant.normals[tile], false)}};
      gltf["materials"].push_back(std::move(material));
      control.report(0.9 * static_cast<double>(gltf["materials"].size()) / num_materials);
    }
    gltf["extensions"]["KHR_materials_variants"]["variants"].push_back({{"name", variant.name}});
  }
}

// A primitive per tile that has triangles.
Json make_primitives(const std::vector<int>& index_accessors, std::size_t num_variants, int tangent_accessor) {
  Json primitives = Json::array();
  for (std::size_t tile = 0; tile < index_accessors.size(); ++tile) {
    if (index_accessors[tile] < 0) continue;
    Json primitive = {{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}},
                      {"indices", index_accessors[tile]},
                      {"material", tile}};
    if (tangent_accessor >= 0) primitive["attributes"]["TANGENT"] = tangent_accessor;
    Json& mappings = primitive["extensions"]["KHR_materials_variants"]["mappings"];
    for (std::size_t i = 0; i < num_variants; ++i) {
      mappings.push_back({{"material", i * index_accessors.size() + tile}, {"variants", Json::array({i})}});
    }
    primitives.push_back(std::move(primitive));
  }
  return primitives;
}

void append_u32(std::string& bytes, std::size_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((value >> shift) & 0xFF);
}

std::string container(std::string json, std::string binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const std::size_t total = 12 + 8 + json.size() + 8 + binary.size();
  if (total > 0xFFFFFFFFu) throw InvalidInput("glb: more than 4 GB; use smaller textures or fewer variants");
  std::string bytes;
  bytes.reserve(total);
  append_u32(bytes, kMagic);
  append_u32(bytes, 2);
  append_u32(bytes, total);
  append_u32(bytes, json.size());
  append_u32(bytes, kJsonChunk);
  bytes += json;
  append_u32(bytes, binary.size());
  append_u32(bytes, kBinaryChunk);
  bytes += binary;
  return bytes;
}

std::uint32_t u32_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[offset + i])) << (8 * i);
  return value;
}

}  // namespace

void write_glb(const std::filesystem::path& path, const Mesh& mesh, const std::vector<GlbVariant>& variants,
               const GlbOptions& options, const RunControl& control) {
  write_glb(path, mesh, GlbTiles{}, variants, options, control);
}

void write_glb(const std::filesystem::path& path, const Mesh& mesh, const GlbTiles& tiles, const std::vector<GlbVariant>& variants,
               const GlbOptions& options, const RunControl& control) {
  check(mesh, tiles, variants, options);
  const Mesh shaded = with_normals(mesh);
  const bool has_tangents = std::any_of(variants.begin(), variants.end(), [](const GlbVariant& variant) { return !variant.normals.empty(); });
  const VertexBuffers buffers = make_buffers(shaded, tiles, options.metres_per_unit, has_tangents);

  Json gltf;
  gltf["asset"] = {{"version", "2.0"}, {"generator", "patinate"}};
  if (!options.key.empty()) gltf["asset"]["extras"] = {{"patinate_key", options.key}};
  gltf["extensionsUsed"] = {"KHR_materials_variants"};
  gltf["scene"] = 0;
  gltf["scenes"] = {{{"nodes", {0}}}};
  gltf["nodes"] = {{{"name", options.name}, {"mesh", 0}}};

  BinaryChunk binary;
  gltf["accessors"] = Json::array();
  gltf["accessors"].push_back(position_accessor(binary.add(buffers.positions, kArrayBuffer), buffers.positions));
  gltf["accessors"].push_back(
      accessor(binary.add(buffers.normals, kArrayBuffer), kFloat, buffers.normals.size() / 3, "VEC3"));
  gltf["accessors"].push_back(accessor(binary.add(buffers.uvs, kArrayBuffer), kFloat, buffers.uvs.size() / 2, "VEC2"));
  const int tangent_accessor = has_tangents ? static_cast<int>(gltf["accessors"].size()) : -1;
  if (has_tangents) {
    gltf["accessors"].push_back(accessor(binary.add(buffers.tangents, kArrayBuffer), kFloat, buffers.tangents.size() / 4, "VEC4"));
  }
  std::vector<int> index_accessors;  // -1 = no triangle shows this tile
  for (const std::vector<std::uint32_t>& indices : buffers.indices) {
    index_accessors.push_back(indices.empty() ? -1 : static_cast<int>(gltf["accessors"].size()));
    if (!indices.empty()) gltf["accessors"].push_back(accessor(binary.add(indices, kElementBuffer), kUint32, indices.size(), "SCALAR"));
  }
  gltf["textures"] = Json::array();
  add_materials(gltf, binary, tiles, variants, options, control);
  gltf["meshes"] = Json::array({{{"name", options.name}, {"primitives", make_primitives(index_accessors, variants.size(), tangent_accessor)}}});
  gltf["bufferViews"] = binary.views();
  gltf["buffers"] = Json::array({{{"byteLength", binary.bytes().size()}}});
  std::string text;
  try {
    text = gltf.dump();
  } catch (const nlohmann::json::exception&) {
    throw InvalidInput("glb: a name is not UTF-8");
  }
  write_atomically(path, container(std::move(text), binary.bytes()));
  control.report(1.0);
}

std::string read_glb_key(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  if (bytes.size() < 20 || u32_at(bytes, 0) != kMagic || u32_at(bytes, 16) != kJsonChunk) return "";
  const std::size_t length = u32_at(bytes, 12);
  if (length > bytes.size() - 20) return "";
  const Json gltf =
      Json::parse(bytes.begin() + 20, bytes.begin() + 20 + static_cast<std::ptrdiff_t>(length), nullptr, false);
  const Json::json_pointer pointer("/asset/extras/patinate_key");
  if (gltf.is_discarded() || !gltf.is_object() || !gltf.contains(pointer) || !gltf.at(pointer).is_string()) return "";
  return gltf.at(pointer).get<std::string>();
}

}  // namespace patinate
