#include "libcommon/mesh_files/gltf_compression.h"

#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/module.h"
#include "libcommon/mesh_files/draco_module.h"
#include "libcommon/mesh_files/gltf_json.h"
#include "libcommon/mesh_files/gltf_uvs.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr const char *kMeshopt = "/extensions/EXT_meshopt_compression",
                     *kDraco = "/extensions/KHR_draco_mesh_compression";

/// A number of an extension's object; `without` where it is not given. @throws IoError
std::size_t count_in(const std::string& what, const Json& object, const char* name, std::size_t without = 0) {
  const Json& value = gltf_member(object, name);
  if (value.is_null()) return without;
  if (!value.is_number_unsigned()) throw IoError(what, std::string(name + 1) + " is no count");
  return value.get<std::size_t>();
}

/// @throws IoError
std::span<const unsigned char> bytes_of(const std::string& what, const tinygltf::Model& model, std::size_t buffer,
                                        std::size_t offset, std::size_t length) {
  if (buffer >= model.buffers.size()) throw IoError(what, "its compressed data have no buffer");
  const std::vector<unsigned char>& data = model.buffers[buffer].data;
  if (offset > data.size() || length > data.size() - offset)
    throw IoError(what, "its compressed data end behind their buffer of " + std::to_string(data.size()) + " bytes");
  return {data.data() + offset, length};
}

/// Bytes as a buffer of their own. @returns its view
int add_view(tinygltf::Model& model, std::vector<unsigned char> bytes, std::size_t stride) {
  tinygltf::BufferView view;
  view.buffer = static_cast<int>(model.buffers.size());
  view.byteLength = bytes.size();
  view.byteStride = stride;
  tinygltf::Buffer buffer;
  buffer.data = std::move(bytes);
  model.buffers.push_back(std::move(buffer));
  model.bufferViews.push_back(view);
  return static_cast<int>(model.bufferViews.size()) - 1;
}

// ---- EXT_meshopt_compression: a view at a time ----

bool undo_filter(const std::string& filter, std::size_t count, std::size_t stride, unsigned char* values) {
  if (filter == "NONE" || filter.empty()) return true;
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(values, count, stride);
  } else if (filter == "QUATERNION" && stride == 8) {
    meshopt_decodeFilterQuat(values, count, stride);
  } else if (filter == "EXPONENTIAL" && stride % 4 == 0) {
    meshopt_decodeFilterExp(values, count, stride);
  } else {
    return false;
  }
  return true;
}

/// @returns whether the data are whole.
bool decode_meshopt(const std::string& mode, std::span<const unsigned char> from, std::size_t count, std::size_t stride,
                    unsigned char* to) {
  constexpr std::size_t kLongestVertex = 256;
  const bool is_index = stride == 2 || stride == 4;
  if (mode == "ATTRIBUTES" && stride % 4 == 0 && stride <= kLongestVertex)
    return meshopt_decodeVertexBuffer(to, count, stride, from.data(), from.size()) == 0;
  if (mode == "TRIANGLES" && is_index && count % 3 == 0)
    return meshopt_decodeIndexBuffer(to, count, stride, from.data(), from.size()) == 0;
  if (mode == "INDICES" && is_index)
    return meshopt_decodeIndexSequence(to, count, stride, from.data(), from.size()) == 0;
  return false;
}

void decompress_view(const std::string& what, const Json& coded, tinygltf::Model& model, std::size_t index) {
  const std::size_t count = count_in(what, coded, "/count"), stride = count_in(what, coded, "/byteStride");
  const auto from = bytes_of(what, model, count_in(what, coded, "/buffer", model.buffers.size()),
                             count_in(what, coded, "/byteOffset"), count_in(what, coded, "/byteLength"));
  constexpr std::size_t kMaxOfByte = 64;  // Four bytes or more hold a column of 256 vertices, one byte a triangle.
  if (stride == 0 || count / kMaxOfByte > from.size() || count * stride > kLargestGltf)
    throw IoError(what, "its compressed data have a wrong size");
  const auto text = [&](const char* name) {
    const Json& value = gltf_member(coded, name);
    return value.is_string() ? value.get<std::string>() : std::string();
  };
  std::vector<unsigned char> values(count * stride);
  if (!decode_meshopt(text("/mode"), from, count, stride, values.data()) ||
      !undo_filter(text("/filter"), count, stride, values.data()))
    throw IoError(what, "its compressed data are damaged");
  const int added = add_view(model, std::move(values), text("/mode") == "ATTRIBUTES" ? stride : 0);
  model.bufferViews[index] = model.bufferViews[added];
}

// ---- KHR_draco_mesh_compression: a primitive at a time ----

/// A copy of an accessor, as several primitives may share it, that looks into the decoded values.
int add_accessor(const std::string& what, tinygltf::Model& model, int index, std::size_t count, int view) {
  if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size())
    throw IoError(what, "accessor " + std::to_string(index) + " does not exist");
  tinygltf::Accessor accessor = model.accessors[index];
  if (accessor.count != count)
    throw IoError(what, "its Draco data have " + std::to_string(count) + " entries; accessor " + std::to_string(index) +
                            " has " + std::to_string(accessor.count));
  accessor.bufferView = view;
  accessor.byteOffset = 0;
  accessor.sparse.isSparse = false;
  model.accessors.push_back(std::move(accessor));
  return static_cast<int>(model.accessors.size()) - 1;
}

std::unique_ptr<DracoMesh> decode_draco(const std::string& what, std::span<const unsigned char> bytes) {
  static DecodeDraco* const decode = reinterpret_cast<DecodeDraco*>(module_function("patinate-draco", kDracoEntry));
  std::unique_ptr<DracoMesh> mesh(decode(bytes.data(), bytes.size()));
  if (!mesh) throw IoError(what, "its Draco data are damaged");
  return mesh;
}

void set_draco_indices(const std::string& what, const DracoMesh& mesh, tinygltf::Model& model,
                       tinygltf::Primitive& primitive) {
  const std::vector<std::uint32_t> indices = mesh.indices();
  std::vector<unsigned char> bytes(indices.size() * sizeof(std::uint32_t));
  if (!indices.empty()) std::memcpy(bytes.data(), indices.data(), bytes.size());
  const int view = add_view(model, std::move(bytes), 0);
  primitive.indices = add_accessor(what, model, primitive.indices, indices.size(), view);
  model.accessors[primitive.indices].componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;  // A strip is stored as the triangles that it has.
}

void decompress_primitive(const std::string& what, const Json& coded, tinygltf::Model& model,
                          tinygltf::Primitive& primitive) {
  const std::size_t index = count_in(what, coded, "/bufferView", model.bufferViews.size());
  if (index >= model.bufferViews.size()) throw IoError(what, "its Draco data have no buffer view");
  const tinygltf::BufferView view = model.bufferViews[index];
  const auto mesh = decode_draco(
      what, bytes_of(what, model, static_cast<std::size_t>(view.buffer), view.byteOffset, view.byteLength));
  for (const auto& [name, id] : gltf_member(coded, "/attributes").items()) {
    const auto named = primitive.attributes.find(name);
    if (named == primitive.attributes.end()) continue;
    if (!id.is_number_unsigned() || !mesh->has_attribute(id.get<std::uint32_t>()))
      throw IoError(what, name + " is missing in its Draco data");
    const int added = add_accessor(what, model, named->second, mesh->num_points(), -1);
    const tinygltf::Accessor& accessor = model.accessors[added];
    std::vector<unsigned char> bytes =
        mesh->values(id.get<std::uint32_t>(), accessor.componentType,
                     tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
    if (bytes.empty()) throw IoError(what, name + " is of another type than its Draco data");
    const int view_of_values = add_view(model, std::move(bytes), 0);
    model.accessors[added].bufferView = view_of_values;
    named->second = added;
  }
  if (primitive.indices >= 0) set_draco_indices(what, *mesh, model, primitive);
}

bool has_bytes(const tinygltf::Model& model, const tinygltf::BufferView& view) {
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size()) return false;
  const std::size_t size = model.buffers[view.buffer].data.size();
  return view.byteOffset <= size && view.byteLength <= size - view.byteOffset;
}

/// Whether indices and positions are there uncompressed as well.
bool has_values(const tinygltf::Model& model, const tinygltf::Primitive& primitive) {
  const auto has = [&](int index) {
    if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size()) return false;
    return model.accessors[index].bufferView >= 0 || model.accessors[index].sparse.isSparse;
  };
  const auto positions = primitive.attributes.find("POSITION");
  return (primitive.indices < 0 || has(primitive.indices)) &&
         (positions == primitive.attributes.end() || has(positions->second));
}

/// @returns whether there are some.
bool fill_fallbacks(Json& document) {
  if (!gltf_member(document, "/buffers").is_array()) return false;
  bool has_some = false;
  for (Json& buffer : document["buffers"]) {
    if (!gltf_member(buffer, kMeshopt).is_object() || buffer.contains("uri")) continue;
    buffer["uri"] = "data:application/octet-stream;base64,AA==";
    buffer["byteLength"] = 1;
    has_some = true;
  }
  return has_some;
}

/// @returns whether there are some.
bool remove_draco_indices(Json& document) {
  if (!gltf_member(document, "/meshes").is_array()) return false;
  bool has_some = false;
  for (Json& mesh : document["meshes"]) {
    if (!gltf_member(mesh, "/primitives").is_array()) continue;
    for (Json& primitive : mesh["primitives"])
      has_some = (gltf_member(primitive, kDraco).is_object() && primitive.erase("indices") > 0) || has_some;
  }
  return has_some;
}

/// The accessor of a primitive's indices; -1 = none.
int indices_of(const Json& primitive) {
  const Json& index = gltf_member(primitive, "/indices");
  return index.is_number_integer() ? index.get<int>() : -1;
}

}  // namespace

std::string loadable_gltf(std::string_view bytes, const Json& document) {
  Json loadable = document;
  const bool has_fallbacks = fill_fallbacks(loadable), has_indices = remove_draco_indices(loadable);
  if (!has_fallbacks && !has_indices) return "";
  std::string json = loadable.dump();
  if (!bytes.starts_with("glTF")) return json;
  constexpr std::size_t kHead = 12, kChunkHead = 8;
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string_view binary = bytes.substr(kHead + kChunkHead + gltf_json("", bytes).size());
  const auto number = [](std::size_t value) {
    std::string text;
    for (unsigned i = 0; i < 4; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
  };
  return std::string(bytes.substr(0, 8)) + number(kHead + kChunkHead + json.size() + binary.size()) +
         number(json.size()) + "JSON" + json + std::string(binary);
}

void decompress_gltf(const std::string& file, const Json& document, tinygltf::Model& model) {
  const auto is_required = [&](const std::string& name) {
    const auto& names = model.extensionsRequired;
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const std::size_t num_views = model.bufferViews.size();
  for (std::size_t i = 0; i < num_views; ++i) {
    const Json& coded = gltf_member(document, ("/bufferViews/" + std::to_string(i) + kMeshopt).c_str());
    if (coded.is_object() && (is_required("EXT_meshopt_compression") || !has_bytes(model, model.bufferViews[i])))
      decompress_view(file + ": buffer view " + std::to_string(i), coded, model, i);
  }
  for (std::size_t m = 0; m < model.meshes.size(); ++m) {
    for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
      const std::string at = "/meshes/" + std::to_string(m) + "/primitives/" + std::to_string(p);
      const Json& json = gltf_member(document, at.c_str());
      const Json& coded = gltf_member(json, kDraco);
      if (!coded.is_object()) continue;
      primitive.indices = indices_of(json);
      if (is_required("KHR_draco_mesh_compression") || !has_values(model, primitive))
        decompress_primitive(file + ": mesh " + std::to_string(m), coded, model, primitive);
    }
  }
}

}  // namespace patinate
